// ranks: 1 2 3
// What ranks find together, each in its share of the tiles, is what one rank finds alone.
#include <gtest/gtest.h>
#include <petscsys.h>

#include "simulation/setup.hpp"
#include "support/scene_text.hpp"

namespace bulkley::scene_test::body_survey_mpi_test {
namespace {

std::string fault_of(const Scene& scene, const BodySurvey& survey) {
  try {
    check_bodies(scene, survey);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(BodySurvey, RanksFindTheSameParticleAsOneAlone) {
  const Comm comm(PETSC_COMM_WORLD);
  const BodySurvey shared = shared_survey(comm);
  // Undefined everywhere, in the last share alone, in the middle, at no particle.
  for (const std::string formula : {"log(-1)", "log(0.6 - x)", "x > 0.45 && x < 0.5 ? log(-1) : 1", "log(x)"}) {
    const Scene scene = parsed(small_scene + "velocity_field = [\"0\", \"" + formula + "\", \"0\"]\n");
    const std::string alone = fault_of(scene, survey_alone());
    EXPECT_EQ(fault_of(scene, shared), alone) << formula;
    EXPECT_EQ(alone.empty(), formula == "log(x)") << alone;
  }
}

TEST(BodySurvey, RanksVisitEachParticleOnce) {
  const Comm comm(PETSC_COMM_WORLD);
  const Scene scene = parsed(small_scene);
  EXPECT_EQ(shared_survey(comm).count(scene.grid, scene.bodies), survey_alone().count(scene.grid, scene.bodies));
}

}  // namespace
}  // namespace bulkley::scene_test::body_survey_mpi_test
