#include "program/run_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "bulkley/base/error.hpp"
#include "io/files/json_text.hpp"
#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

namespace fs = std::filesystem;

constexpr double usual_silence = 120.0;       // s; status.json is renewed every 20 s, but a step may take longer
constexpr double usual_silence_steps = 20.0;  // in steps

// Empty when the file is not there (any more) or cannot be read.
std::string text_if_there(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

double age_of(fs::file_time_type written) {
  return std::chrono::duration<double>(fs::file_time_type::clock::now() - written).count();
}

bool is_of(const std::string& name, const char* prefix) { return name.starts_with(prefix); }

void count_file(RunFolder& run, const fs::directory_entry& entry) {
  std::error_code error;
  const double bytes = static_cast<double>(entry.file_size(error));
  if (error) return;
  const double age = age_of(entry.last_write_time(error));
  if (error) return;
  const std::string name = entry.path().filename().string();
  if (is_of(name, "checkpoint_")) {
    run.disk.checkpoints += bytes;
    if (entry.path().extension() == ".h5")
      run.checkpoints.push_back({entry.path().string(), std::atol(name.c_str() + 11), bytes, age});
  } else if (is_of(name, "frame_") || is_of(name, "frames.xdmf")) {
    run.disk.frames += bytes;
    if (is_of(name, "frame_") && entry.path().extension() == ".h5") ++run.disk.n_frames;
  } else {
    run.disk.rest += bytes;
  }
  // Pictures, reports and copies of files may be newer than the run's last sign of life.
  if (is_of(name, "checkpoint_") || is_of(name, "frame") || is_of(name, "status.json") || is_of(name, "history.csv"))
    run.age = std::min(run.age, std::max(age, 0.0));
}

void count_files(RunFolder& run) {
  run.age = std::numeric_limits<double>::infinity();
  std::error_code error;
  fs::recursive_directory_iterator entry(run.path, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code gone;
    if (entry.depth() > 0) entry.disable_recursion_pending();
    if (entry->is_regular_file(gone) && !entry->is_symlink(gone)) {
      if (entry.depth() == 0)
        count_file(run, *entry);
      else if (const auto bytes = entry->file_size(gone); !gone)
        run.disk.rest += static_cast<double>(bytes);
    }
  }
  std::sort(run.checkpoints.begin(), run.checkpoints.end(),
            [](const CheckpointFile& a, const CheckpointFile& b) { return a.step < b.step; });
}

// The member of a JSON object; `missing` where there is none of its kind.
double number_in(const Json& object, const char* key, double missing) {
  const auto member = object.find(key);
  return member != object.end() && member->is_number() ? member->get<double>() : missing;
}

std::string text_in(const Json& object, const char* key) {
  const auto member = object.find(key);
  return member != object.end() && member->is_string() ? member->get<std::string>() : std::string();
}

Json list_in(const Json& object, const char* key) {
  const auto member = object.find(key);
  return member != object.end() && member->is_array() ? *member : Json::array();
}

void take_status(RunFolder& run, const Json& status) {
  run.state = text_in(status, "state");
  run.reason = text_in(status, "reason");
  run.title = text_in(status, "title");
  run.host = text_in(status, "host");
  run.program = text_in(status, "program");
  run.continuation = text_in(status, "continuation");
  run.last_checkpoint = text_in(status, "checkpoint");
  const auto number = [&](double& value, const char* key) { value = number_in(status, key, unknown); };
  number(run.step, "step");
  number(run.time, "time");
  number(run.end_time, "end_time");
  number(run.n_ranks, "ranks");
  number(run.n_particles, "particles");
  number(run.first_step, "first_step");
  number(run.first_time, "first_time");
  number(run.elapsed, "wall_time");
  number(run.stepping, "wall_time_stepping");
  number(run.output, "wall_time_output");
  number(run.peak_memory, "peak_memory");
  number(run.longest_silence, "longest_silence");
  number(run.last_checkpoint_time, "checkpoint_time");
  for (const Json& phase : list_in(status, "phases"))
    run.phases.push_back({text_in(phase, "name"), 0, 0.0, number_in(phase, "mean", 0.0), number_in(phase, "largest", 0.0)});
  for (const Json& warning : list_in(status, "warnings"))
    if (warning.is_string()) run.warnings.push_back(warning.get<std::string>());
}

}  // namespace

bool RunFolder::silent(double seconds_per_step) const {
  const double by_steps = std::isfinite(seconds_per_step) ? usual_silence_steps * seconds_per_step : 0.0;
  return running() && age > std::max(usual_silence, by_steps);
}

RunFolder read_run_folder(const std::string& path) {
  std::error_code error;
  const fs::file_status kind = fs::status(path, error);
  if (kind.type() == fs::file_type::not_found) throw UsageError(fmt::format("{}: there is no such folder", path));
  if (kind.type() != fs::file_type::directory)
    throw UsageError(fmt::format("{}: is not a folder; give the output folder of a run", path));
  const fs::directory_iterator readable(path, error);
  if (error) throw UsageError(fmt::format("{}: the folder cannot be read: {}", path, error.message()));

  RunFolder run;
  run.path = path;
  const bool has_history = fs::exists(fs::path(path) / "history.csv", error);
  // Text that is no JSON gives a value that is no object.
  const Json status = Json::parse(text_if_there(path_in(path, "status.json")), nullptr, false);
  const bool is_ours = !text_in(status, "state").empty();
  if (!is_ours && !has_history)
    throw UsageError(fmt::format("{}: holds no run: there is neither status.json nor history.csv", path));
  take_status(run, is_ours ? status : Json::object());
  if (run.state.empty()) run.state = "unknown";
  count_files(run);
  return run;
}

}  // namespace bulkley
