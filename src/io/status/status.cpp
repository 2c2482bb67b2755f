#include "io/status/status.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "io/files/json_text.hpp"
#include "io/files/text_file.hpp"

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

Json phases_json(const std::vector<PhaseSummary>& phases) {
  Json list = Json::array();
  for (const PhaseSummary& phase : phases)
    list.push_back({{"name", phase.name}, {"mean", phase.mean}, {"largest", phase.largest}});
  return list;
}

Json status_json(const Status& s) {
  const RunProgress& p = s.progress;
  Json json{{"state", name(s.state)},
            {"step", s.step},
            {"time", s.time},
            {"checkpoint", s.checkpoint},
            {"reason", s.reason},
            {"title", p.title},
            {"end_time", p.end_time},
            {"ranks", p.n_ranks},
            {"particles", p.n_particles},
            {"first_step", p.first_step},
            {"first_time", p.first_time},
            {"wall_time", p.elapsed},
            {"wall_time_stepping", p.stepping},
            {"wall_time_output", p.output},
            {"peak_memory", static_cast<GlobalIndex>(p.peak_memory)},
            {"checkpoint_time", p.checkpoint_time},
            {"longest_silence", p.longest_silence},
            {"pressure_iterations", p.pressure.iterations},
            {"pressure_iterations_max", p.pressure.most_iterations},
            {"contact_rounds", p.pressure.contact_rounds},
            {"viscosity_iterations", p.viscosity.iterations},
            {"viscosity_iterations_max", p.viscosity.most_iterations},
            {"volume_error", p.volume_error},
            {"continuation", p.continuation},
            {"host", p.host},
            {"started", p.started},
            {"program", p.program},
            {"phases", phases_json(p.phases)},
            {"warnings", p.warnings}};
  if (s.unresponsive) json["unresponsive"] = true;
  if (s.in_set_up) json["failed_in_set_up"] = true;
  return json;
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
  write_text_atomically(path_in(folder, "status.json"), json_text(status_json(status)) + "\n");
}

bool mark_failed_alone(const std::string& folder, const std::string& reason, bool unresponsive) {
  const std::string path = path_in(folder, "status.json");
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return false;
  Json status = Json::parse(read_text(path), nullptr, false);
  if (!status.is_object()) return false;
  status["state"] = name(RunState::failed);
  status["reason"] = reason;
  status.erase("unresponsive");  // of an earlier part
  if (unresponsive) status["unresponsive"] = true;
  write_text_atomically(path, json_text(status) + "\n");
  return true;
}

namespace {

bool is_failed(const Json& status, const std::string& started) {
  return status.is_object() && status.value("state", "") == name(RunState::failed) && status.value("started", "") == started;
}

}  // namespace

bool says_failed(const std::string& folder, const std::string& started) {
  const std::string path = path_in(folder, "status.json");
  std::error_code error;
  return std::filesystem::exists(path, error) && is_failed(Json::parse(read_text(path), nullptr, false), started);
}

void write_first_failure_alone(const std::string& folder, const Status& status, int rank) {
  if (says_failed(folder, status.progress.started)) return;
  write_text_before_end(path_in(folder, "status.json"), json_text(status_json(status)) + "\n", fmt::format(".{}", rank));
}

void mark_unresponsive_alone(const std::string& folder, const std::string& reason, const std::string& started, int rank) {
  const std::string path = path_in(folder, "status.json");
  Json status = Json::parse(read_text(path), nullptr, false);
  if (!status.is_object()) throw RunError(fmt::format("{} is not a status", path));
  if (is_failed(status, started)) return;
  status["started"] = started;
  status["state"] = name(RunState::failed);
  status["reason"] = reason;
  status["unresponsive"] = true;
  write_text_before_end(path, json_text(status) + "\n", fmt::format(".{}", rank));
}

void write_status(const Comm& comm, const std::string& folder, const Status& status) {
  root_guard(comm, [&] { write_status_alone(folder, status); });
}

std::string time_stamp() {
  const auto now = std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
  const auto seconds = std::chrono::floor<std::chrono::seconds>(now);
  return fmt::format("{:%FT%T}.{:06}Z", fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)), (now - seconds).count());
}

std::size_t peak_resident_bytes() {
  // getrusage starts from what the parent occupied when it started this program, so it comes second.
  if (const std::size_t peak = process_bytes("VmHWM"); peak > 0) return peak;
  struct rusage usage = {};
  return ::getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::size_t>(usage.ru_maxrss) * 1024 : 0;
}

}  // namespace bulkley
