// Keys that were renamed: scenes and checkpoints of the version before still use the old names.

#include <gtest/gtest.h>

#include "scene/scene_difference.hpp"
#include "support/scene_text.hpp"

namespace bulkley::scene_test::old_names_test {
namespace {

/// small_scene with further keys of [time], which start on line 7.
std::string with_time(const std::string& lines) { return with(small_scene, "end = 1\n", "end = 1\n" + lines); }

const std::string adaptive_before = with_time("initial_step = 1e-5\nlargest_step = 1e-3\nsmallest_step = 1e-7\n");
const std::string adaptive_now = with_time("dt_initial = 1e-5\ndt_max = 1e-3\ndt_min = 1e-7\n");

TEST(OldNames, GiveTheSameSceneWithAWarningEach) {
  const Scene before = parsed(adaptive_before), now = parsed(adaptive_now);
  EXPECT_EQ(before.effective_text, now.effective_text);
  EXPECT_EQ(before.time_stepping.dt_initial, 1e-5);
  EXPECT_EQ(before.time_stepping.dt_max, 1e-3);
  EXPECT_EQ(before.time_stepping.dt_min, 1e-7);
  EXPECT_TRUE(now.warnings.empty());
  const std::string rest = "; the old name is accepted in this version only";
  EXPECT_EQ(before.warnings,
            (std::vector<std::string>{"s.toml:7:1: 'time.initial_step' is now called 'time.dt_initial'" + rest,
                                      "s.toml:8:1: 'time.largest_step' is now called 'time.dt_max'" + rest,
                                      "s.toml:9:1: 'time.smallest_step' is now called 'time.dt_min'" + rest}));
}

TEST(OldNames, OfOverrides) {
  const Scene scene = parsed(small_scene, {"time.mode=fixed", "time.step=1e-4"});
  EXPECT_EQ(scene.time_stepping.dt_fixed, 1e-4);
  EXPECT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(parsed(with_time("mode = \"fixed\"\nstep = 1e-3\n"), {"time.dt=1e-4"}).time_stepping.dt_fixed, 1e-4);
}

TEST(OldNames, AppearInTheMessagesOfWhoWritesThem) {
  EXPECT_EQ(faults_of(with_time("mode = \"fixed\"\nstep = 0\n")), "s.toml:8:8: 'time.step' is 0; it must be greater than 0");
  EXPECT_EQ(
      faults_of(with_time("mode = \"fixed\"\nstep = 1e-99\n")),
      "s.toml:8:8: 'time.step' is 1e-99; it must be at least 1e-15, or there are more than 1e+15 steps until 'time.end' "
      "= 1");
  EXPECT_EQ(faults_of(with_time("largest_step = 1e-4\nsmallest_step = 1e-3\n")),
            "s.toml:8:17: 'time.smallest_step' is 0.001; it must be at most 'time.largest_step' = 0.0001");
  EXPECT_EQ(faults_of(with_time("dt = 1e-4\nstep = 1e-4\nmode = \"fixed\"\n")),
            "s.toml:8:1: 'time.step' and 'time.dt' are both given; the first is the old name of the second: give 'time.dt' "
            "alone");
  EXPECT_EQ(faults_of(with_time("inital_step = 1e-4\n")),
            "s.toml:7:1: unknown key 'inital_step' in [time]; did you mean 'dt_initial', formerly 'initial_step'?");
}

TEST(OldNames, AreNoDifferenceToTheSceneOfACheckpoint) {
  EXPECT_EQ(scene_differences(adaptive_before, parsed(adaptive_now)), std::vector<std::string>{});
  EXPECT_EQ(scene_differences(adaptive_now, parsed(adaptive_before)), std::vector<std::string>{});
  EXPECT_EQ(scene_differences(adaptive_before, parsed(adaptive_now, {"time.dt_max=2e-3"})),
            std::vector<std::string>{"time.dt_max: 0.001 -> 0.002"});
}

}  // namespace
}  // namespace bulkley::scene_test::old_names_test
