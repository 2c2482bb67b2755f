#include "io/status/status.hpp"

#include <sys/resource.h>

#include <fmt/format.h>

#include <fstream>

#include "io/files/text_file.hpp"
#include "io/status/json.hpp"

namespace bulkley {

namespace {

// Value of a line "key:   123 kB" of /proc/self/status, bytes; 0 where there is no such file or line.
std::size_t process_bytes(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    std::size_t kibibytes = 0;
    if (word == key + ":" && file >> kibibytes) return kibibytes * 1024;
  }
  return 0;
}

template <class Value, class Text>
std::string json_list(const std::vector<Value>& values, Text text) {
  std::string list;
  for (const Value& value : values) list += fmt::format("{}\n    {}", list.empty() ? "" : ",", text(value));
  return fmt::format("[{}{}]", list, list.empty() ? "" : "\n  ");
}

std::string phase_text(const PhaseSummary& phase) {
  return fmt::format("{{\"name\": {}, \"mean\": {}, \"largest\": {}}}", json_text(phase.name), json_text(phase.mean),
                     json_text(phase.largest));
}

std::string status_text(const Status& s) {
  const RunProgress& p = s.progress;
  std::string lines;
  const auto add = [&](const char* key, const std::string& value) {
    lines += fmt::format("{}\n  \"{}\": {}", lines.empty() ? "" : ",", key, value);
  };
  add("state", json_text(name(s.state)));
  add("step", fmt::format("{}", s.step));
  add("time", json_text(s.time));
  add("checkpoint", json_text(s.checkpoint));
  add("reason", json_text(s.reason));
  add("title", json_text(p.title));
  add("end_time", json_text(p.end_time));
  add("ranks", fmt::format("{}", p.n_ranks));
  add("particles", fmt::format("{}", p.n_particles));
  add("first_step", fmt::format("{}", p.first_step));
  add("first_time", json_text(p.first_time));
  add("wall_time", json_text(p.elapsed));
  add("wall_time_stepping", json_text(p.stepping));
  add("wall_time_output", json_text(p.output));
  add("peak_memory", fmt::format("{:.0f}", p.peak_memory));
  add("checkpoint_time", json_text(p.checkpoint_time));
  add("continuation", json_text(p.continuation));
  add("host", json_text(p.host));
  add("program", json_text(p.program));
  add("phases", json_list(p.phases, phase_text));
  add("warnings", json_list(p.warnings, [](const std::string& text) { return json_text(text); }));
  return fmt::format("{{{}\n}}\n", lines);
}

}  // namespace

const char* name(RunState state) {
  switch (state) {
    case RunState::running:
      return "running";
    case RunState::stopped:
      return "stopped";
    case RunState::failed:
      return "failed";
    case RunState::finished:
      return "finished";
  }
  return "";
}

void write_status_alone(const std::string& folder, const Status& status) {
  write_text_atomically(path_in(folder, "status.json"), status_text(status));
}

void write_status(const Comm& comm, const std::string& folder, const Status& status) {
  root_guard(comm, [&] { write_status_alone(folder, status); });
}

std::size_t peak_resident_bytes() {
  // getrusage starts from what the parent occupied when it started this program, so it comes second.
  if (const std::size_t peak = process_bytes("VmHWM"); peak > 0) return peak;
  struct rusage usage = {};
  return ::getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::size_t>(usage.ru_maxrss) * 1024 : 0;
}

}  // namespace bulkley
