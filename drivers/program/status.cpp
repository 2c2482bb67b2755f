#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "config/duration.hpp"
#include "program/commands.hpp"
#include "program/status_text.hpp"

namespace bulkley {

namespace {

constexpr double shortest_interval = 0.1;  // s

struct StatusArguments {
  std::vector<std::string> folders;
  std::string interval;
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

bool any_runs(const std::vector<RunView>& views) {
  return std::any_of(views.begin(), views.end(), [](const RunView& view) { return view.run.running(); });
}

// Until no run has the state running. A killed run still has it.
void watch(const StatusArguments& a, double interval) {
  const bool on_terminal = ::isatty(STDOUT_FILENO) == 1;
  constexpr const char* clear = "\033[H\033[2J";
  while (true) {
    const std::vector<RunView> views = look_at(a.folders);
    const bool goes_on = any_runs(views);
    std::string text;
    if (on_terminal && !a.json)
      text = clear + text_of(views, false);
    else if (a.json || !goes_on)
      text = text_of(views, a.json);
    else
      for (const RunView& view : views) text += status_line(view) + "\n";
    fmt::print("{}", text);
    std::fflush(stdout);
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
    root_guard(comm, [&] {
      if (watch_option->count() > 0)
        watch(*a, interval);
      else
        fmt::print("{}", text_of(look_at(a->folders), a->json));
    });
    return ExitCode::finished;
  };
}

}  // namespace bulkley
