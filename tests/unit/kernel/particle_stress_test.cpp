#include "kernel/particle_stress.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "kernel/stress_update.hpp"
#include "support/serial_step.hpp"

namespace bulkley::particle_stress_test {
namespace {

const NeoHookean solid{{1000.0, 3e5, 2e4}};
const HerschelBulkley fluid{{1200.0, 1e5, 5e3, 400.0, 50.0, 0.4}};
const std::vector<NamedMaterial> both{{"solid", solid}, {"fluid", fluid}};

// Deformed particles of the materials in turn, with the stress of their laws where they store one.
void deform_all(const std::vector<NamedMaterial>& materials, ParticleSet& set) {
  std::mt19937_64 generator(21);
  std::uniform_real_distribution<double> uniform(-0.3, 0.3);
  for (LocalIndex p = 0; p < set.size(); ++p) {
    const auto m = static_cast<std::size_t>(p) % materials.size();
    State<double> state = state_at_rest(solid);
    Tensor<double> L{};
    for (double& component : L.c) component = uniform(generator);
    deform(state, L, 1.0);
    for (int c = 0; c < 6; ++c) set.real(Field::left_cauchy_green, c)[p] = state.left_cauchy_green.c[c];
    set.real(Field::volume_ratio)[p] = state.volume_ratio;
    set.material()[p] = static_cast<std::uint8_t>(m);
    if (!set.has(Field::kirchhoff_stress)) continue;
    const SymTensor<double> tau = neo_hookean_stress(materials[m].material)->kirchhoff_stress(state);
    for (int c = 0; c < 6; ++c) set.real(Field::kirchhoff_stress, c)[p] = tau.c[c];
  }
}

TEST(ParticleStress, OfTheStateIsTheOneThatWouldBeStored) {
  for (const bool one : {true, false}) {
    const std::vector<NamedMaterial> materials(both.begin() + one, both.end());
    ParticleSet stored({Field::kirchhoff_stress}), set;
    stored.resize(37);
    set.resize(37);
    deform_all(materials, stored);
    deform_all(materials, set);
    const StressOfState none, of_state(materials);
    EXPECT_FALSE(none.any());
    ASSERT_TRUE(of_state.any());
    const ParticleStress expected(stored, none), found(set, of_state);
    const double largest = 1e-12 * 3e5;
    for (LocalIndex p = 0; p < set.size(); ++p)
      for (int c = 0; c < 6; ++c) EXPECT_NEAR(found.of_one(p).c[c], expected.of_one(p).c[c], largest);
    for (LocalIndex p = 0; p < set.size(); p += n_lanes)
      for (int lane = 0; lane < std::min<int>(n_lanes, set.size() - p); ++lane) {
        const Pack other = broadcast<Pack>(77.0);
        EXPECT_NEAR(found.mean(p)[lane], expected.mean(p)[lane], largest);
        for (int c = 0; c < 6; ++c) {
          EXPECT_NEAR(found.of(p).c[c][lane], expected.of_one(p + lane).c[c], largest);
          EXPECT_NEAR(found.with_mean(p, other).c[c][lane], expected.with_mean(p, other).c[c][lane], largest);
        }
      }
  }
}

TEST(ParticleStress, IsStoredWhereALawNeedsMoreThanStrain) {
  EXPECT_TRUE(StressOfState(both).any());
  HerschelBulkley thin = fluid;
  thin.parameters.background_viscosity = 0.1;
  for (const Material& other : {Material{thin}, Material{Newtonian{{1000.0, 1e5, 3.0}}}, Material{Hencky{{1000.0, 1e5, 1e4}}}}) {
    const std::vector<NamedMaterial> materials{{"solid", solid}, {"other", other}};
    EXPECT_FALSE(StressOfState(materials).any());
    EXPECT_TRUE(internal_fields(materials).contains(Field::kirchhoff_stress));
  }
  EXPECT_FALSE(internal_fields(both).contains(Field::kirchhoff_stress));
  EXPECT_TRUE(StressOfState(std::vector<NamedMaterial>{{"thin", without_viscosity(thin)}}).any());
}

TEST(ParticleStress, IsSetFromTheStrainByEachLaw) {
  ParticleSet set({Field::kirchhoff_stress}), bare;
  set.resize(9);
  bare.resize(9);
  deform_all(both, set);
  deform_all(both, bare);
  for (int c = 0; c < 6; ++c) std::fill_n(set.real(Field::kirchhoff_stress, c), set.size(), 0.0);
  set_stress(both, set);
  const StressOfState none, of_state(both);
  const ParticleStress found(set, none), expected(bare, of_state);
  for (LocalIndex p = 0; p < set.size(); ++p)
    for (int c = 0; c < 6; ++c) EXPECT_NEAR(found.of_one(p).c[c], expected.of_one(p).c[c], 1e-12 * 3e5);
}

// As frames show it: what is stored, else what the law gives beside an implicit pressure and viscosity.
TEST(ParticleStress, OfFramesLacksWhatOtherFieldsHold) {
  const auto of_frame = [](OptionalFields fields) {
    ParticleSet set(fields);
    set.resize(1);
    deform_all({{"solid", solid}}, set);
    if (set.has(Field::kirchhoff_stress)) set.real(Field::kirchhoff_stress)[0] = 5.0;
    const StressOfState of_state(set, std::vector<NamedMaterial>{{"solid", solid}});
    return ParticleStress(set, of_state).of_one(0);
  };
  EXPECT_EQ(of_frame({Field::kirchhoff_stress}).c[0], 5.0);
  EXPECT_GT(std::fabs(trace(of_frame({}))), 1.0);
  EXPECT_NEAR(trace(of_frame({Field::cell_mean_stress})), 0.0, 1e-9);
  EXPECT_EQ(of_frame({Field::cell_mean_stress}).c[3], of_frame({}).c[3]);
}

// And p2g makes the same of both, with the means of cells, too.
TEST(ParticleStress, GivesNodesTheSame) {
  SerialScene scene = open_scene({});
  scene.materials = both;
  ParticleSet start = random_particles(scene, 500, 3, false);
  deform_all(both, start);
  const SerialStep run(scene, std::move(start));
  ParticleSet bare(OptionalFields{}, run.particles.densities());
  bare.resize(run.particles.size());
  for (const FieldInfo& field : field_table) {
    if (!bare.has(field.field) || field.type != FieldType::real) continue;
    for (int c = 0; c < field.n_components; ++c)
      std::copy_n(run.particles.real(field.field, c), bare.size(), bare.real(field.field, c));
  }
  std::copy_n(run.particles.material(), bare.size(), bare.material());
  std::vector<CellSums> sums(run.map.count.size());
  const CellGroups groups(run.map.cell);
  const CellSumBounds bounds{2.5e-3, run.bounds.sums.stress_volume, 3.0, run.bounds.sums.cell_count};
  const StressOfState of_state(both);
  const auto nodes_of = [&](const ParticleSet& set, const StressOfState& stress, bool with_means) {
    const SumBounds node_sums = sum_bounds(scene.grid, scene.transfer, run.bounds, 1e-4, false, {}, true);
    if (with_means) {
      sum_stress(set, groups, bounds, sums, stress);
      take_means_of_stress(sums);
    }
    std::vector<Node> nodes(run.nodes.size());
    p2g(scene.grid, scene.transfer, run.layout, set, run.map, node_sums, 1e-4, nodes.data(), {},
        with_means ? CellMeans{groups.data(), sums.data(), 0.0} : CellMeans{}, stress);
    return nodes;
  };
  for (const bool with_means : {false, true}) {
    const std::vector<Node> expected = nodes_of(run.particles, {}, with_means), found = nodes_of(bare, of_state, with_means);
    double largest = 0.0, difference = 0.0;
    for (std::size_t n = 0; n < found.size(); ++n)
      for (int c = 0; c < 4; ++c) {
        largest = std::max(largest, std::fabs(expected[n].c[c]));
        difference = std::max(difference, std::fabs(found[n].c[c] - expected[n].c[c]));
      }
    EXPECT_GT(largest, 0.0);
    EXPECT_LT(difference, 1e-12 * largest);
  }
}

}  // namespace
}  // namespace bulkley::particle_stress_test
