#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cctype>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "config/duration.hpp"
#include "program/commands.hpp"
#include "program/human_text.hpp"
#include "program/status_text.hpp"

namespace bulkley {

namespace {

constexpr double shortest_interval = 0.1;  // s

struct StatusArguments {
  std::vector<std::string> folders;
  std::string interval, patience;
  bool json = false;
};

std::vector<RunView> look_at(const std::vector<std::string>& folders) {
  std::vector<RunView> views;
  for (const std::string& folder : folders) views.emplace_back(folder);
  return views;
}

std::string text_of(const std::vector<RunView>& views, bool as_json) {
  if (!as_json) return views.size() == 1 ? status_lines(views.front()) : status_table(views);
  if (views.size() == 1) return json_text(status_json(views.front())) + "\n";
  Json list = Json::array();
  for (const RunView& view : views) list.push_back(status_json(view));
  return json_text(list) + "\n";
}

// What is said of a run that has the state running and has written nothing for too long; empty for all others.
std::string lost_text(const RunView& view, std::optional<double> patience) {
  const RunFolder& run = view.run;
  if (!run.running()) return {};
  const bool states_it = std::isfinite(run.longest_silence);
  if (!patience && !states_it && !view.silent()) return {};  // of an earlier version
  const double limit = patience ? *patience : states_it ? run.longest_silence : 0.0;
  const bool never = limit == 0.0 && (patience || states_it);
  if (never || run.age <= limit) return {};
  const char* const of = patience ? " (--patience)" : states_it ? " (longest_silence in its status.json)" : "";
  return fmt::format("{}: has written nothing for {}{}: it hangs or was killed, and is watched no longer", run.path,
                     span_text(run.age), limit > 0.0 ? fmt::format(", more than {}{}", span_text(limit), of) : "");
}

// Until no run has the state running, or those that have it have written nothing for too long: a killed run still has it. Throws
// RunError then.
void watch(const StatusArguments& a, double interval, std::optional<double> patience) {
  const bool on_terminal = ::isatty(STDOUT_FILENO) == 1;
  constexpr const char* clear = "\033[H\033[2J";
  while (true) {
    const std::vector<RunView> views = look_at(a.folders);
    bool goes_on = false;
    std::vector<std::string> lost;
    for (const RunView& view : views) {
      const std::string sentence = lost_text(view, patience);
      goes_on = goes_on || (view.run.running() && sentence.empty());
      if (!sentence.empty()) lost.push_back(sentence);
    }
    std::string text;
    if (on_terminal && !a.json)
      text = clear + text_of(views, false);
    else if (a.json || !goes_on)
      text = text_of(views, a.json);
    else
      for (const RunView& view : views) text += status_line(view) + "\n";
    fmt::print("{}", text);
    std::fflush(stdout);
    if (!goes_on && !lost.empty()) throw RunError(fmt::format("{}", fmt::join(lost, "\nbulkley: ")));
    if (!goes_on) return;
    std::this_thread::sleep_for(std::chrono::duration<double>(interval));
  }
}

}  // namespace

Command add_status(CLI::App& app) {
  auto a = std::make_shared<StatusArguments>();
  app.add_option("folders", a->folders, "output folders of runs; several: a table with one line each")->type_name("DIR");
  auto* const watch_option =
      app.add_option("--watch", a->interval, "repeat at this interval until all runs have ended (default: 5s)")
          ->type_name("[SECONDS]")
          ->expected(0, 1);
  app.add_option(
         "--patience", a->patience,
         "with --watch: end, exit code 3, once a run has written nothing for this long; 0: never (default: what each run "
         "states in its status.json)")
      ->type_name("TIME");
  app.add_flag("--json", a->json, "numbers in SI units, for programs");
  return [a, watch_option](const Comm& comm) {
    double interval = 5.0;
    if (!a->interval.empty()) {
      // "--watch DIR": a word that does not begin with a digit is no duration.
      if (std::isdigit(static_cast<unsigned char>(a->interval.front())))
        interval = parse_duration(a->interval);
      else
        a->folders.insert(a->folders.begin(), a->interval);
    }
    if (a->folders.empty()) throw UsageError("bulkley status: give the output folder of a run");
    if (interval < shortest_interval)
      throw UsageError(fmt::format("--watch {}: at least {} s", a->interval, shortest_interval));
    if (!a->patience.empty() && watch_option->count() == 0)
      throw UsageError("--patience is for --watch, which is not given");
    std::optional<double> patience;
    if (!a->patience.empty()) patience = parse_duration(a->patience);
    root_guard(comm, [&] {
      if (watch_option->count() > 0)
        watch(*a, interval, patience);
      else
        fmt::print("{}", text_of(look_at(a->folders), a->json));
    });
    return ExitCode::finished;
  };
}

}  // namespace bulkley
