#pragma once
// Plots as SVG elements for a page: curves over time and bars. Their colours are the page's classes s0 to s8, so that they
// follow its light and dark looks. Not collective.

#include <string>
#include <utility>
#include <vector>

namespace bulkley {

struct PlotPoint {
  double x, y;
};

struct PlotCurve {
  std::string name;
  int colour = 0;                 ///< of the class s0 to s8
  std::vector<PlotPoint> points;  ///< by ascending x; what is not finite is left out
};

struct Plot {
  std::string title;
  std::string x_name, y_name;  ///< with units
  std::vector<PlotCurve> curves;
  bool dots = false;         ///< points by themselves, no lines between them
  bool may_be_log = false;   ///< logarithmic axis if all values are positive and span more than a factor of 30
  bool skips_first = false;  ///< for who fills the curves: the first row holds no value
  bool from_zero = false;    ///< the axis shows zero
};

struct PlotBar {
  std::string name;
  double value = 0.0, largest = 0.0;  ///< largest: of a thin line behind the bar; 0: none
};

/// Values that an axis from `lower` to `upper` marks: multiples of 1, 2 or 5 times a power of ten, about `n` of them.
std::vector<double> axis_ticks(double lower, double upper, int n);

/// Text of HTML and XML with nothing in it that could be read as markup.
std::string escaped(const std::string& text);

/// A figure with its title, its legend and its plot; one without any finite point says so.
std::string plot_figure(const Plot& plot);

/// A figure of horizontal bars; `unit` goes behind each value.
std::string bar_figure(const std::string& title, const std::vector<PlotBar>& bars, const std::string& unit,
                       const std::string& caption);

}  // namespace bulkley
