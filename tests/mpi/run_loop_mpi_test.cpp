// ranks: 1 3
// The run loop finds outputs and stop criteria that it does not know.
#include "simulation/run_loop.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "io/checkpoint/checkpoint.hpp"
#include "simulation/outputs/output.hpp"
#include "simulation/run_folder.hpp"
#include "simulation/simulation_state.hpp"
#include "simulation/stop_criteria.hpp"
#include "support/scene_text.hpp"

namespace bulkley::run_loop_mpi_test {
namespace {

struct Calls {
  std::vector<GlobalIndex> steps;  // at which the output wrote
  int n_starts = 0, n_stops = 0, n_ends = 0, n_durable = 0;
};

// Writes every third step, and asks for a checkpoint before step 4.
class EveryThird : public Output {
 public:
  explicit EveryThird(Calls& calls) : calls_(calls) {}
  Request wants(const Run& run) override { return run.state.step == 4 ? Request::checkpoint : Request::none; }
  bool is_due(const Run& run, const Occasion& occasion) const override {
    calls_.n_starts += occasion.event == RunEvent::start;
    calls_.n_stops += occasion.event == RunEvent::stop;
    calls_.n_ends += occasion.event == RunEvent::end;
    return occasion.event == RunEvent::step && run.state.step % 3 == 0;
  }
  void write(Run& run) override { calls_.steps.push_back(run.state.step); }
  void make_durable(Run&) override { ++calls_.n_durable; }

 private:
  Calls& calls_;
};

// One rank has had enough after step 7.
class EnoughOnOneRank : public StopCriterion {
 public:
  explicit EnoughOnOneRank(int& n_obeyed) : n_obeyed_(n_obeyed) {}
  Request wants(const Run& run) override {
    return run.comm.rank() == run.comm.size() - 1 && run.state.step >= 7 ? Request::stop : Request::none;
  }
  std::string reason(const Run&) const override { return "by one rank that had enough"; }
  void obeyed(const Run&) override { ++n_obeyed_; }

 private:
  int& n_obeyed_;
};

class RunLoop : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  std::string folder = "run_loop_" + std::to_string(comm.size());
  Scene scene = scene_test::parsed(scene_test::small_scene, {"time.end=0.02", "output.frame_interval=0"});
  RunOptions options;

  void SetUp() override {
    options.folder = folder;
    options.overwrite = true;
    options.quiet = true;
    prepare_folder(comm, options);
  }
  void TearDown() override {
    BULKLEY_MPI(MPI_Barrier(comm.get()));
    if (comm.is_root()) std::filesystem::remove_all(folder);
  }
};

TEST_F(RunLoop, OverwritingDeletesAnEarlierFailure) {
  const std::vector<std::string> files{folder + "/status.json", folder + "/failure_000000003.h5",
                                       folder + "/failure_000000003.xdmf"};
  if (comm.is_root())
    for (const std::string& file : files) std::ofstream(file) << "of the run before";
  BULKLEY_MPI(MPI_Barrier(comm.get()));
  prepare_folder(comm, options);
  for (const std::string& file : files) EXPECT_FALSE(std::filesystem::exists(file)) << file;
}

TEST_F(RunLoop, ASecondOutputIsAskedAndWrites) {
  options.max_steps = 10;
  bulkley::Run run(comm, scene, options);
  Calls calls;
  run.outputs.push_back(std::make_unique<EveryThird>(calls));
  EXPECT_EQ(run_to_end(run), RunOutcome::finished);
  EXPECT_EQ(calls.steps, (std::vector<GlobalIndex>{3, 6, 9}));
  EXPECT_EQ(calls.n_starts, 1);
  EXPECT_EQ(calls.n_stops, 0);
  EXPECT_EQ(calls.n_ends, 1);
  EXPECT_EQ(calls.n_durable, 2) << "the checkpoint that it asked for, and that of the end";
  if (comm.is_root()) {
    EXPECT_TRUE(std::filesystem::exists(checkpoint_path(folder, 5)));
    EXPECT_TRUE(std::filesystem::exists(checkpoint_path(folder, 10)));
  }
}

TEST_F(RunLoop, ASecondStopCriterionStopsAllRanksWithACheckpoint) {
  bulkley::Run run(comm, scene, options);
  int n_obeyed = 0;
  run.stops.insert(run.stops.begin(), std::make_unique<EnoughOnOneRank>(n_obeyed));
  testing::internal::CaptureStdout();
  run_to_end(run);
  testing::internal::GetCapturedStdout();
  EXPECT_EQ(run.state.step, 8);
  EXPECT_EQ(n_obeyed, 1);
  EXPECT_EQ(run.last_checkpoint.step, 8);
  std::ifstream status(folder + "/status.json");
  const std::string text((std::istreambuf_iterator<char>(status)), {});
  if (comm.is_root()) {
    EXPECT_NE(text.find("stopped"), std::string::npos);
    EXPECT_NE(text.find("by one rank that had enough at step 8"), std::string::npos) << text;
  }
}

// In doubles 6 x 0.05 is greater than 0.3.
TEST(FrameTimes, TheEndIsOne) {
  SimulationState state;
  state.frame_tick = 6;
  EXPECT_EQ(next_frame_time(state, 0.05, 0.3), 0.3);
  EXPECT_EQ(next_frame_time(state, 0.05, 0.4), 6 * 0.05);
  state.time = 0.3;
  fit_frame_tick(state, 0.05);
  EXPECT_EQ(state.frame_tick, 7);
  state.frame_tick = 7;
  fit_frame_tick(state, 0.05);
  EXPECT_EQ(state.frame_tick, 7);
}

}  // namespace
}  // namespace bulkley::run_loop_mpi_test
