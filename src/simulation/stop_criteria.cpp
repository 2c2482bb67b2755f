#include "simulation/stop_criteria.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

constexpr double walltime_before_first_checkpoint = 0.1;  // part of the whole

// --max-walltime: stops so early that the checkpoint is written in time.
class WalltimeCriterion : public StopCriterion {
 public:
  Request wants(const Run& run) override {
    const double limit = run.options.max_walltime;
    if (limit <= 0.0 || !run.comm.is_root()) return Request::none;
    const double elapsed = MPI_Wtime() - run.options.begin;
    const double reserve = 2.0 * run.last_checkpoint.seconds + 3.0 * run.clock.slowest_step + 0.01 * limit;
    if (elapsed + reserve > limit) return Request::stop;
    // One must have been written to know how long the last one will take.
    if (run.last_checkpoint.seconds == 0.0 && elapsed > walltime_before_first_checkpoint * limit) return Request::checkpoint;
    return Request::none;
  }
  std::string reason(const Run& run) const override {
    return fmt::format("before its wall time of {:g} s is over", run.options.max_walltime);
  }
};

// A file of the name STOP in the output folder.
class StopFileCriterion : public StopCriterion {
 public:
  Request wants(const Run& run) override {
    constexpr double interval = 1.0;  // s; to look for a file costs a shared file system about a millisecond
    const double now = MPI_Wtime();
    if (!run.comm.is_root() || now - last_check_ < interval) return Request::none;
    last_check_ = now;
    std::error_code none;
    return std::filesystem::exists(file_of(run), none) ? Request::stop : Request::none;
  }
  std::string reason(const Run& run) const override { return fmt::format("by the file {}", file_of(run)); }
  // Only now: whoever is told to stop and dies on the way must find it again.
  void obeyed(const Run& run) override {
    root_guard(run.comm, [&] { remove_file(file_of(run)); });
  }

 private:
  static std::string file_of(const Run& run) { return path_in(run.options.folder, "STOP"); }
  double last_check_ = 0.0;  // MPI_Wtime
};

class SignalCriterion : public StopCriterion {
 public:
  Request wants(const Run&) override { return pending_request(); }
  std::string reason(const Run&) const override { return "by a signal"; }
};

}  // namespace

StopCriteria stop_criteria_of(const Run&) {
  StopCriteria criteria;
  criteria.push_back(std::make_unique<WalltimeCriterion>());
  criteria.push_back(std::make_unique<StopFileCriterion>());
  criteria.push_back(std::make_unique<SignalCriterion>());
  return criteria;
}

}  // namespace bulkley
