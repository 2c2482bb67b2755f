#include "simulation/run_folder.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/checkpoint/checkpoint.hpp"
#include "io/files/json_text.hpp"
#include "io/files/text_file.hpp"
#include "parallel/log.hpp"
#include "simulation/run_report.hpp"

namespace bulkley {

namespace {

// The status.json in the folder is that of a run that has never begun.
bool failed_in_set_up(const std::string& folder) {
  const Json status = Json::parse(read_text(path_in(folder, "status.json")), nullptr, false);
  return status.is_object() && status.value("failed_in_set_up", false);
}

}  // namespace

void prepare_folder(const Comm& comm, const RunOptions& options) {
  root_guard(comm, [&] {
    namespace fs = std::filesystem;
    const fs::path folder = options.folder;
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw UsageError(fmt::format("{}: the output folder cannot be made: {}", options.folder, error.message()));
    const bool used =
        fs::exists(folder / "history.csv") || (fs::exists(folder / "status.json") && !failed_in_set_up(options.folder));
    if (used && !options.restart && !options.overwrite)
      throw UsageError(fmt::format(
          "{}: holds an earlier run; continue it with --restart, replace it with --overwrite, or choose another --out",
          options.folder));
    remove_leftovers(options.folder);
    if (options.restart || !used) return;
    for (const char* name : {"history.csv", "status.json", "scene.toml"}) remove_file(path_in(options.folder, name));
    for (const char* suffix : {".h5", ".xdmf"})
      for (const std::string& name : numbered_files(options.folder, "failure_", suffix))
        remove_file(path_in(options.folder, name));
  });
  collective_guard(comm, [&] {
    if (!std::filesystem::is_directory(options.folder))
      throw UsageError(
          fmt::format("{}: rank {} does not see the output folder that rank 0 has made or found: the hosts of all "
                      "ranks must share its disk",
                      options.folder, comm.rank()));
  });
  if (!options.restart) remove_checkpoints_after(comm, options.folder, -1, 1);
}

void write_set_up_failure_alone(const Comm& comm, const Scene& scene, const RunOptions& options, const std::string& reason,
                                bool unresponsive) {
  if (options.restart && mark_failed_alone(options.folder, reason, unresponsive)) return;
  Status status{RunState::failed, 0, 0.0, "", reason, progress_at_start(comm, scene, options)};
  status.in_set_up = true;
  status.unresponsive = unresponsive;
  write_status_alone(options.folder, status);
}

void write_set_up_failure(const Comm& comm, const Scene& scene, const RunOptions& options, const std::string& reason) {
  try {
    root_guard(comm, [&] { write_set_up_failure_alone(comm, scene, options, reason, false); });
  } catch (const RunError&) {
    log_line(comm, fmt::format("{} could not be written", path_in(options.folder, "status.json")));
  }
}

void write_failure(const Comm& comm, const std::string& folder, const Status& status) {
  try {
    write_status(comm, folder, status);
  } catch (const RunError&) {
    log_line(comm, fmt::format("{} could not be written", path_in(folder, "status.json")));
  }
}

}  // namespace bulkley
