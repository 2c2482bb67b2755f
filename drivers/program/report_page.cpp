#include "program/report_page.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <fstream>

#include "bulkley/version.hpp"
#include "io/files/text_file.hpp"
#include "program/human_text.hpp"
#include "program/report_curves.hpp"
#include "program/report_pictures.hpp"
#include "program/report_plot.hpp"
#include "program/report_style.hpp"
#include "program/status_text.hpp"

namespace bulkley {

namespace {

constexpr std::size_t most_scene_bytes = 1'000'000;

std::string entry(const std::string& name, const std::string& value) {
  return fmt::format("<dt>{}</dt><dd>{}</dd>\n", escaped(name), escaped(value));
}

std::string message(const std::string& kind, const std::string& text) {
  return text.empty() ? std::string() : fmt::format("<p class=\"message {}\">{}</p>\n", kind, escaped(text));
}

std::string heading(const RunView& view) {
  const RunFolder& run = view.run;
  const std::string state = view.state();
  std::string text = fmt::format("<h1>{} <span class=\"state {}\">{}</span></h1>\n<p class=\"where\">{}</p>\n",
                                 escaped(run.title.empty() ? "A run without a title" : run.title), escaped(state),
                                 escaped(state), escaped(run.path));
  if (const double done = view.figures.done(run); std::isfinite(done))
    text += fmt::format("<div class=\"done\" title=\"{:.1f} % of the end time\"><div style=\"width:{:.1f}%\"></div></div>\n",
                        100.0 * done, 100.0 * done);
  if (run.state != "finished") text += message(state, run.reason) + message(state, advice_text(view));
  for (const std::string& warning : run.warnings) text += message("warning", "warning: " + warning);
  return text;
}

std::string summary(const RunView& view) {
  const RunFolder& run = view.run;
  std::string list = entry("progress", progress_text(view)) + entry("rate", rate_text(view));
  if (run.running()) list += entry("left", left_text(view));
  list += entry("time step", limiter_text(view)) + entry("trials", trials_text(view));
  list +=
      entry("particles", particles_text(view)) + entry("energy", energy_text(view)) + entry("balance", balance_text(view));
  if (std::isfinite(run.elapsed))
    list += entry("wall time", fmt::format("{} in this part: {} in steps, {} in output", span_text(run.elapsed),
                                           span_text(run.stepping), span_text(run.output)));
  if (run.peak_memory > 0.0) list += entry("memory", bytes_text(run.peak_memory) + " at most on a rank");
  list += entry("disk", disk_text(view)) + entry("last sign", span_text(run.age) + " before this page was written");
  return "<h2>Summary</h2>\n<dl>\n" + list + "</dl>\n";
}

std::string costs(const RunFolder& run) {
  if (run.phases.empty()) return {};
  std::vector<PlotBar> bars;
  for (const PhaseSummary& phase : run.phases) bars.push_back({phase.name, phase.mean, phase.largest});
  return bar_figure("Time by phase of the step", bars, "s",
                    "Mean over the ranks, and the thin line to the slowest rank; of this part of the run.");
}

std::string history(const RunView& view) {
  const HistoryPlots history = history_plots(view.run, view.figures.last_row_time);
  std::string figures;
  for (std::size_t k = 0; k < history.plots.size(); ++k) {
    figures += plot_figure(history.plots[k]);
    if (k == 2 && !history.limiters.empty())
      figures += bar_figure("What limits the time step", history.limiters, "%", "Of the rows of history.csv.");
  }
  return fmt::format(
      "<h2>History</h2>\n<p class=\"note\">{} of history.csv. Of more than 1000, plots show the smallest and the "
      "largest value in each of 500 parts of the time.</p>\n<div class=\"plots\">\n{}{}</div>\n",
      counted(static_cast<double>(history.n_rows), "row"), figures, costs(view.run));
}

std::string pictures(const RunFolder& run) {
  const EmbeddedPictures found = embed_pictures(run.path);
  if (found.pictures.empty()) return {};
  std::string figures;
  for (const EmbeddedPicture& picture : found.pictures)
    figures += fmt::format("<figure><img src=\"{}\" alt=\"{}\"><figcaption>{}</figcaption></figure>\n", picture.url,
                           escaped(picture.name), escaped(picture.name));
  const std::string note =
      found.pictures.size() == found.n_found
          ? std::string()
          : fmt::format("<p class=\"note\">{} of {} pictures in the folder.</p>\n", found.pictures.size(), found.n_found);
  return fmt::format("<h2>Pictures</h2>\n{}<div class=\"pictures\">\n{}</div>\n", note, figures);
}

std::string files(const RunFolder& run) {
  std::string rows;
  for (const CheckpointFile& file : run.checkpoints)
    rows +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{} ago</td></tr>\n",
                    escaped(file.path.substr(file.path.find_last_of('/') + 1)), count_text(static_cast<double>(file.step)),
                    bytes_text(file.bytes), span_text(std::max(file.age, 0.0)));
  const std::string table =
      rows.empty()
          ? "<p>There is no checkpoint.</p>\n"
          : "<div class=\"scroll\"><table>\n<tr><th>checkpoint</th><th>step</th><th>size</th><th>written</th></tr>\n" +
                rows + "</table></div>\n";
  return fmt::format("<h2>Checkpoints and frames</h2>\n{}<p>{}, {}.</p>\n", table,
                     counted(static_cast<double>(run.disk.n_frames), "frame"), bytes_text(run.disk.frames));
}

std::string scene(const RunFolder& run) {
  std::ifstream file(path_in(run.path, "scene.toml"), std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (text.empty()) return {};
  const bool cut = text.size() > most_scene_bytes;
  if (cut) text.resize(text.rfind('\n', most_scene_bytes) + 1);
  return fmt::format(
      "<h2>Scene</h2>\n<details><summary>every key in effect (scene.toml)</summary>\n<pre>{}</pre>\n{}</details>\n",
      escaped(text), cut ? "<p class=\"note\">Cut here; the file has it all.</p>\n" : "");
}

std::string versions(const RunFolder& run) {
  std::string text;
  if (!run.program.empty()) text = "<h2>Versions</h2>\n<pre>" + escaped(run.program) + "</pre>\n";
  if (!run.continuation.empty() && run.state != "finished")
    text += "<h2>To continue</h2>\n<pre>" + escaped(run.continuation) + "</pre>\n";
  return text;
}

}  // namespace

std::string report_page(const std::string& folder) {
  const RunView view(folder);
  const std::string title = view.run.title.empty() ? view.run.path : view.run.title;
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{} - Bulkley</title>\n"
      "<style>{}</style>\n</head>\n<body>\n<main>\n{}{}{}{}{}{}{}<footer>Written {:%Y-%m-%d %H:%M} UTC by Bulkley {}."
      "</footer>\n</main>\n</body>\n</html>\n",
      escaped(title), report_style, heading(view), summary(view), pictures(view.run), history(view), files(view.run),
      versions(view.run), scene(view.run), fmt::gmtime(std::time(nullptr)), escaped(version));
}

}  // namespace bulkley
