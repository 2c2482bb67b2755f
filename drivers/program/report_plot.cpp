#include "program/report_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "program/human_text.hpp"

namespace bulkley {

namespace {

// Units of the view box, about pixels of a phone.
constexpr double width = 400.0, height = 250.0;
constexpr double left = 52.0, right = 20.0, top = 18.0, bottom = 34.0;
constexpr double log_axis_from = 30.0;  // largest over smallest value
constexpr int n_colours = 9;

// From values to the view box along one axis.
struct Axis {
  double lower, upper;  // of log10 on a logarithmic axis
  double from, to;
  bool log = false;

  double place(double value) const {
    const double v = log ? std::log10(value) : value;
    return from + (v - lower) / (upper - lower) * (to - from);
  }
};

struct Range {
  double lower = std::numeric_limits<double>::infinity(), upper = -std::numeric_limits<double>::infinity();
  void add(double value) {
    lower = std::min(lower, value);
    upper = std::max(upper, value);
  }
};

bool is_finite(const PlotPoint& p) { return std::isfinite(p.x) && std::isfinite(p.y); }

Axis axis_of(Range range, bool log, bool from_zero, double from, double to) {
  if (log) return {std::log10(range.lower) - 0.05, std::log10(range.upper) + 0.05, from, to, true};
  if (from_zero) range.add(0.0);
  if (from_zero && range.upper == range.lower) range.upper = 1.0;
  if (!(range.upper > range.lower)) {
    const double room = range.lower == 0.0 ? 1.0 : 0.1 * std::abs(range.lower);
    range = {range.lower - room, range.upper + room};
  }
  return {range.lower, range.upper, from, to};
}

// A little air above and below curves.
void widen(Axis& axis, bool from_zero) {
  const double room = 0.04 * (axis.upper - axis.lower);
  if (!from_zero || axis.lower < 0.0) axis.lower -= room;
  if (!from_zero || axis.upper > 0.0) axis.upper += room;
}

// Labels share a power of ten where numbers would be long.
struct Labels {
  int exponent = 0, decimals = 0;

  Labels(const std::vector<double>& ticks) {
    double largest = 0.0;
    for (const double t : ticks) largest = std::max(largest, std::abs(t));
    if (largest > 0.0 && (largest >= 1e4 || largest < 1e-2))
      exponent = static_cast<int>(std::floor(std::log10(largest) / 3.0)) * 3;
    const double step = ticks.size() > 1 ? (ticks[1] - ticks[0]) / std::pow(10.0, exponent) : 1.0;
    decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  }
  std::string text(double value) const {
    const std::string digits = fmt::format("{:.{}f}", value / std::pow(10.0, exponent), decimals);
    return digits.find_first_not_of("-0.") == std::string::npos ? fmt::format("{:.{}f}", 0.0, decimals) : digits;
  }
  std::string factor() const {
    return exponent == 0 ? std::string() : fmt::format("\xC3\x97 10<tspan class=\"up\" dy=\"-4\">{}</tspan>", exponent);
  }
};

std::string label(double x, double y, const char* anchor, const std::string& text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor, text);
}

std::string line(const char* kind, double x1, double y1, double x2, double y2) {
  return fmt::format("<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n", kind, x1, y1, x2, y2);
}

std::string x_axis(const Axis& axis, const std::string& name) {
  const double base = height - bottom;
  std::string text;
  const std::vector<double> ticks = axis_ticks(axis.lower, axis.upper, 5);
  const Labels labels(ticks);
  for (const double t : ticks) {
    text += line("grid", axis.place(t), top, axis.place(t), base);
    text += label(axis.place(t), base + 14.0, "middle", labels.text(t));
  }
  const std::string factor = labels.factor();
  return text + label(width - right, height - 4.0, "end", escaped(name) + (factor.empty() ? "" : ", " + factor));
}

std::string log_tick(double value) {
  const double exponent = std::floor(std::log10(value) + 1e-9);
  const double digit = std::round(value / std::pow(10.0, exponent));
  const std::string power = fmt::format("10<tspan class=\"up\" dy=\"-4\">{:.0f}</tspan>", exponent);
  return digit == 1.0 ? power : fmt::format("{:.0f}\xC2\xB7{}", digit, power);
}

std::string log_y_axis(const Axis& axis) {
  std::string text;
  const double decades = axis.upper - axis.lower;
  const int stride = std::max(1, static_cast<int>(std::ceil(decades / 7.0)));
  for (int e = static_cast<int>(std::floor(axis.lower)); e <= axis.upper; ++e)
    for (const double digit : {1.0, 2.0, 5.0}) {
      if (digit != 1.0 && decades > 2.5) continue;
      if (digit == 1.0 && e % stride != 0) continue;
      const double value = digit * std::pow(10.0, e);
      if (std::log10(value) < axis.lower || std::log10(value) > axis.upper) continue;
      text += line("grid", left, axis.place(value), width - right, axis.place(value));
      text += label(left - 5.0, axis.place(value) + 4.0, "end", log_tick(value));
    }
  return text;
}

std::string y_axis(const Axis& axis) {
  if (axis.log) return log_y_axis(axis);
  const std::vector<double> ticks = axis_ticks(axis.lower, axis.upper, 5);
  const Labels labels(ticks);
  std::string text = label(left - 5.0, top - 7.0, "start", labels.factor());
  for (const double t : ticks) {
    text += line(t == 0.0 ? "zero" : "grid", left, axis.place(t), width - right, axis.place(t));
    text += label(left - 5.0, axis.place(t) + 4.0, "end", labels.text(t));
  }
  return text;
}

std::string path_of(const PlotCurve& curve, const Axis& x, const Axis& y, bool dots) {
  std::string path;
  Range range;
  std::size_t n = 0;
  for (const PlotPoint& p : curve.points) {
    if (!is_finite(p)) continue;
    range.add(p.y);
    if (++n == 1 || dots)
      path += fmt::format("M{:.1f} {:.1f}{}", x.place(p.x), y.place(p.y), dots ? "h0" : "");
    else
      path += fmt::format("L{:.1f} {:.1f}", x.place(p.x), y.place(p.y));
  }
  if (n == 0) return {};
  if (n == 1 && !dots) path += "h0";
  const bool as_dots = dots || n == 1;
  return fmt::format("<path class=\"{} s{}\" d=\"{}\"><title>{}: {} to {}</title></path>\n", as_dots ? "dots" : "curve",
                     curve.colour % n_colours, path, escaped(curve.name), number_text(range.lower),
                     number_text(range.upper));
}

std::string legend_of(const Plot& plot) {
  if (plot.curves.size() < 2 && !plot.dots) return {};
  std::string keys;
  for (const PlotCurve& curve : plot.curves)
    keys += fmt::format("<span class=\"key s{}\">{}</span> ", curve.colour % n_colours, escaped(curve.name));
  return fmt::format("<p class=\"legend\">{}</p>\n", keys);
}

std::string caption_of(const std::string& title, const std::string& unit) {
  return fmt::format("<figcaption>{}{}</figcaption>\n", escaped(title),
                     unit.empty() ? "" : fmt::format(" <span class=\"unit\">{}</span>", escaped(unit)));
}

}  // namespace

std::vector<double> axis_ticks(double lower, double upper, int n) {
  const double raw = (upper - lower) / std::max(n, 1);
  if (!(raw > 0.0) || !std::isfinite(raw)) return {};
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * power;
  for (const double digit : {5.0, 2.0, 1.0})
    if (digit * power >= raw * (1.0 - 1e-9)) step = digit * power;
  std::vector<double> ticks;
  for (double k = std::ceil(lower / step - 1e-9); k * step <= upper + 1e-9 * step; k += 1.0) ticks.push_back(k * step);
  return ticks;
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '&')
      safe += "&amp;";
    else if (c == '"')
      safe += "&quot;";
    else if (c == '\'')
      safe += "&#39;";
    else if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t')
      safe += ' ';
    else
      safe += c;
  }
  return safe;
}

std::string plot_figure(const Plot& plot) {
  Range xs, ys;
  for (const PlotCurve& curve : plot.curves)
    for (const PlotPoint& p : curve.points)
      if (is_finite(p)) {
        xs.add(p.x);
        ys.add(p.y);
      }
  const std::string head = "<figure>\n" + caption_of(plot.title, plot.y_name);
  if (!(xs.lower <= xs.upper)) return head + "<p class=\"none\">no values yet</p>\n</figure>\n";
  const bool log = plot.may_be_log && ys.lower > 0.0 && ys.upper > log_axis_from * ys.lower;
  const Axis x = axis_of(xs, false, false, left, width - right);
  Axis y = axis_of(ys, log, plot.from_zero, height - bottom, top);
  if (!log) widen(y, plot.from_zero);
  std::string svg =
      fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n", width, height, escaped(plot.title));
  svg += x_axis(x, plot.x_name) + y_axis(y);
  svg +=
      line("frame", left, height - bottom, width - right, height - bottom) + line("frame", left, top, left, height - bottom);
  for (const PlotCurve& curve : plot.curves) svg += path_of(curve, x, y, plot.dots);
  return head + legend_of(plot) + svg + "</svg>\n</figure>\n";
}

std::string bar_figure(const std::string& title, const std::vector<PlotBar>& bars, const std::string& unit,
                       const std::string& caption) {
  constexpr double row = 20.0, names = 108.0, numbers = 72.0;
  double largest = 0.0;
  for (const PlotBar& bar : bars) largest = std::max({largest, bar.value, bar.largest});
  const double scale = largest > 0.0 ? (width - names - numbers) / largest : 0.0;
  std::string svg = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n", width,
                                row * static_cast<double>(bars.size()) + 4.0, escaped(title));
  double y = 2.0;
  for (const PlotBar& bar : bars) {
    svg += label(names - 6.0, y + 14.0, "end", escaped(bar.name));
    if (bar.largest > 0.0) svg += line("whisker", names, y + 10.0, names + scale * bar.largest, y + 10.0);
    svg += fmt::format("<rect class=\"bar\" x=\"{}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"12\"><title>{}</title></rect>\n",
                       names, y + 4.0, std::max(scale * bar.value, 0.5), escaped(bar.name));
    svg += label(names + scale * std::max(bar.value, bar.largest) + 5.0, y + 14.0, "start",
                 fmt::format("{} {}", number_text(bar.value), escaped(unit)));
    y += row;
  }
  return fmt::format("<figure>\n{}{}</svg>\n<p class=\"note\">{}</p>\n</figure>\n", caption_of(title, ""), svg,
                     escaped(caption));
}

}  // namespace bulkley
