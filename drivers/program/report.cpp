// `bulkley report`: what a run's folder tells, in the words of `bulkley status`, handed to the Python package, which draws the
// page (drivers/python/bulkley/report.py).

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bulkley/version.hpp"
#include "io/files/text_file.hpp"
#include "program/commands.hpp"
#include "program/human_text.hpp"
#include "program/python_tool.hpp"
#include "program/status_text.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

namespace {

// Kind and text of each: the kinds are classes of the page's style.
Json messages(const RunView& view) {
  const RunFolder& run = view.run;
  Json list = Json::array();
  const auto add = [&](const std::string& kind, const std::string& text) {
    if (!text.empty()) list.push_back(Json::array({kind, text}));
  };
  if (run.state != "finished") {
    add(view.state(), run.reason);
    add(view.state(), advice_text(view));
  }
  for (const std::string& warning : run.warnings) add("warning", "warning: " + warning);
  return list;
}

// Name and text of each line.
Json summary(const RunView& view) {
  const RunFolder& run = view.run;
  Json list = Json::array();
  const auto add = [&](const char* name, const std::string& text) { list.push_back(Json::array({name, text})); };
  add("progress", progress_text(view));
  add("rate", rate_text(view));
  if (run.running()) add("left", left_text(view));
  add("time step", limiter_text(view));
  add("trials", trials_text(view));
  if (const std::string volume = volume_text(view); !volume.empty()) add("volume", volume);
  add("particles", particles_text(view));
  add("energy", energy_text(view));
  if (view.figures.account.known()) {
    add("received", received_text(view));
    add("went to", losses_text(view));
  }
  add("balance", balance_text(view));
  if (std::isfinite(run.elapsed))
    add("wall time", fmt::format("{} in this part: {} in steps, {} in output", span_text(run.elapsed),
                                 span_text(run.stepping), span_text(run.output)));
  if (run.peak_memory > 0.0) add("memory", bytes_text(run.peak_memory) + " at most on a rank");
  add("disk", disk_text(view));
  add("last update", span_text(run.age) + " before this page was written");
  return list;
}

Json checkpoints(const RunFolder& run) {
  Json list = Json::array();
  for (const CheckpointFile& file : run.checkpoints)
    list.push_back(
        Json::array({file.path.substr(file.path.find_last_of('/') + 1), count_text(static_cast<double>(file.step)),
                     bytes_text(file.bytes), span_text(std::max(file.age, 0.0)) + " ago"}));
  return list;
}

Json report_facts(const RunView& view) {
  const RunFolder& run = view.run;
  Json phases = Json::array(), limiters = Json::array();
  for (const PhaseSummary& phase : run.phases)
    phases.push_back({{"name", phase.name}, {"mean", phase.mean}, {"largest", phase.largest}});
  for (int k = 0; k <= static_cast<int>(Limiter::output); ++k) limiters.push_back(name(static_cast<Limiter>(k)));
  return {{"title", run.title},
          {"path", run.path},
          {"state", view.state()},
          {"done", view.figures.done(run)},
          {"messages", messages(view)},
          {"summary", summary(view)},
          {"last_row_time", view.figures.last_row_time},
          {"limiters", limiters},
          {"phases", phases},
          {"checkpoints", checkpoints(run)},
          {"frames",
           fmt::format("{}, {}.", counted(static_cast<double>(run.disk.n_frames), "frame"), bytes_text(run.disk.frames))},
          {"program", run.program},
          {"continuation", run.state == "finished" ? std::string() : run.continuation},
          {"version", version}};
}

}  // namespace

Command add_report(CLI::App& app) {
  struct Arguments {
    std::string folder, file;
  };
  auto a = std::make_shared<Arguments>();
  app.add_option("folder", a->folder, "output folder of a run")->required()->type_name("DIR");
  app.add_option("--out", a->file, "page to write (default: DIR/report.html)")->type_name("FILE.html");
  return [a](const Comm& comm) {
    root_guard(comm, [&] {
      const std::string file = a->file.empty() ? path_in(a->folder, "report.html") : a->file;
      const std::string facts = json_text(report_facts(RunView(a->folder)));
      const std::string page = run_python_tool({"report", a->folder}, facts, "page " + file);
      try {
        write_text_atomically(file, page);
      } catch (const RunError& error) {
        throw UsageError(fmt::format("{}; --out names another place for the page", error.what()));
      }
      fmt::print("{}\n", file);
    });
    return ExitCode::finished;
  };
}

}  // namespace bulkley
