// The batched transfers against the plain ones of the reference, and their independence of the order of particles.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "support/reference_particles.hpp"
#include "support/serial_step.hpp"

namespace bulkley::transfer_test {
namespace {

ReferenceMpm reference_of(const SerialStep& run) {
  ReferenceScene scene;
  scene.grid = run.scene.grid;
  scene.transfer = run.scene.transfer;
  scene.gravity = run.scene.gravity;
  scene.faces = run.scene.faces;
  scene.materials = {{1e5, 3e4, false, 0.0, 0.0, 1.0}, {1e5, 3e4, true, 400.0, 50.0, 0.4}};
  ReferenceMpm reference(scene, reference_particles(run.particles, run.scene.materials));
  const SumBounds sums = sum_bounds(scene.grid, scene.transfer, run.bounds, 0.0, scene.transfer.keeps_residual());
  reference.empty_node = SerialStep::empty_mass * sums.mass / run.bounds.sums.mass;
  return reference;
}

// Node of the reference for the n-th node of the pool, or -1 beyond the grid.
std::ptrdiff_t reference_node(const SerialStep& run, std::size_t n) {
  const GridGeometry& grid = run.scene.grid;
  std::ptrdiff_t index = 0;
  for (int a = 0; a < 3; ++a) {
    if (run.indices[n][a] >= grid.n_nodes(a)) return -1;
    index = index * grid.n_nodes(a) + run.indices[n][a];
  }
  return index;
}

// Number of particles that reach each node.
std::vector<int> addends(const ReferenceMpm& reference) {
  std::vector<int> result(reference.nodes.size(), 0);
  for (const ReferenceParticle& p : reference.particles)
    for (const ReferenceMpm::Entry& e : reference.stencil(p.x)) ++result[e.node];
  return result;
}

// Every addend may be off by half a quantum, and by its own rounding, which is far less.
double sum_tolerance(int n_addends, double bound) { return 0.55 * n_addends * rounding_quantum(bound); }

bool same_bits(const std::vector<Node>& a, const std::vector<Node>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Node)) == 0);
}

std::vector<LocalIndex> shuffled(LocalIndex count, unsigned seed) {
  std::vector<LocalIndex> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  return order;
}

// --- against the reference -------------------------------------------------------------------------------------------

TEST(Transfer, NodesReceiveWhatTheReferenceGivesThem) {
  const double dt = 1e-3;
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    SerialStep run(scene, random_particles(scene, 777, 5, true));
    ReferenceMpm reference = reference_of(run);
    run.particles_to_nodes(dt);
    reference.p2g();
    const std::vector<int> n_addends = addends(reference);
    for (std::size_t n = 0; n < run.nodes.size(); ++n) {
      const Vec3 q(run.nodes[n].c[0], run.nodes[n].c[1], run.nodes[n].c[2]);
      const std::ptrdiff_t at = reference_node(run, n);
      if (at < 0) {
        EXPECT_EQ(q.norm() + run.nodes[n].c[3], 0.0);
        continue;
      }
      const auto tolerance = [&](double bound) { return sum_tolerance(n_addends[static_cast<std::size_t>(at)], bound); };
      const ReferenceNode& truth = reference.nodes[static_cast<std::size_t>(at)];
      EXPECT_NEAR(run.nodes[n].c[3], truth.m, tolerance(run.sums.mass));
      const Vec3 truth_q = run.split() ? truth.momentum : Vec3(truth.momentum + dt * truth.force);
      EXPECT_LE((q - truth_q).cwiseAbs().maxCoeff(), tolerance(run.sums.momentum));
      if (run.split()) {
        const Vec3 f(run.impulse[n].c[0], run.impulse[n].c[1], run.impulse[n].c[2]);
        EXPECT_LE((f - dt * truth.force).cwiseAbs().maxCoeff(), tolerance(run.sums.impulse));
      }
    }
  }
}

// Impulses in both nodes of a pair: momenta with them as in one node, and impulses as they are apart.
TEST(Transfer, ImpulsesInBothNodesOfAPairLeaveMomentaAsTheyAre) {
  const double dt = 1e-2;
  for (const TransferSettings& transfer : all_transfers())
    for (const bool forced : {false, true}) {
      if (transfer.keeps_residual()) continue;
      SCOPED_TRACE(describe(transfer));
      SerialStep run(open_scene(transfer), random_particles(open_scene(transfer), 777, 5, true));
      if (forced) run.force = ParticleForce{Field::velocity, 1.0};
      run.particles_to_nodes(dt);
      std::vector<NodePair> both(run.nodes.size()), apart(run.nodes.size());
      const auto scatter = [&](std::vector<NodePair>& pairs, Impulses impulses) {
        const SumBounds sums = sum_bounds(run.scene.grid, transfer, run.bounds, dt, impulses == Impulses::apart, run.force);
        p2g(run.scene.grid, transfer, run.layout, run.particles, run.map, sums, dt, pairs.data(), run.force, impulses);
      };
      scatter(both, Impulses::both);
      scatter(apart, Impulses::apart);
      double largest = 0.0;
      for (std::size_t n = 0; n < both.size(); ++n) {
        for (int c = 0; c < 4; ++c)
          EXPECT_NEAR(both[n].motion.c[c], run.nodes[n].c[c],
                      sum_tolerance(1000, c < 3 ? run.sums.momentum : run.sums.mass));
        const Node &f = both[n].change, &truth = apart[n].change;
        for (int a = 0; a < 3; ++a) {
          EXPECT_NEAR(f.c[a], truth.c[a], sum_tolerance(1000, run.sums.impulse));
          largest = std::max(largest, std::abs(truth.c[a]));
        }
      }
      EXPECT_GT(largest, 1e6 * sum_tolerance(1000, run.sums.impulse));
    }
}

// Any field of three components serves as the force.
TEST(Transfer, AForceOnParticlesJoinsTheImpulses) {
  const double dt = 1e-2;
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    SerialStep plain(open_scene(transfer), random_particles(open_scene(transfer), 777, 5, true));
    SerialStep forced(plain.scene, random_particles(plain.scene, 777, 5, true));
    forced.force = ParticleForce{Field::velocity, 1.0};
    plain.particles_to_nodes(dt);
    forced.particles_to_nodes(dt);
    const ReferenceMpm reference = reference_of(plain);
    std::vector<Vec3> expected(reference.nodes.size(), Vec3::Zero());
    for (const ReferenceParticle& p : reference.particles)
      for (const ReferenceMpm::Entry& e : reference.stencil(p.x)) expected[e.node] += dt * e.w * p.v;
    const std::vector<int> n_addends = addends(reference);
    const auto& received = [](const SerialStep& step) -> const auto& { return step.split() ? step.impulse : step.nodes; };
    for (std::size_t n = 0; n < plain.nodes.size(); ++n) {
      const std::ptrdiff_t at = reference_node(plain, n);
      if (at < 0) continue;
      const double bound = plain.split() ? forced.sums.impulse : forced.sums.momentum;
      for (int a = 0; a < 3; ++a)
        ASSERT_NEAR(received(forced)[n].c[a] - received(plain)[n].c[a], expected[static_cast<std::size_t>(at)][a],
                    2.0 * sum_tolerance(n_addends[static_cast<std::size_t>(at)], bound));
      ASSERT_EQ(forced.nodes[n].c[3], plain.nodes[n].c[3]);
      for (int a = 0; a < 3 && plain.split(); ++a)  // which products are fused may differ
        ASSERT_NEAR(forced.nodes[n].c[a], plain.nodes[n].c[a],
                    2.0 * sum_tolerance(n_addends[static_cast<std::size_t>(at)], forced.sums.momentum));
    }
  }
}

TEST(Transfer, ParticlesReceiveWhatTheReferenceGivesThem) {
  const double dt = 1e-3;
  for (TransferSettings transfer : all_transfers())
    for (const double damping : {0.0, 0.3}) {
      transfer.affine_damping = damping;
      SCOPED_TRACE(describe(transfer) + " " + std::to_string(damping));
      SerialScene scene = open_scene(transfer);
      scene.gravity = Vec3(1.0, -2.0, -9.81);
      SerialStep run(scene, random_particles(scene, 777, 6, true));
      ReferenceMpm reference = reference_of(run);
      const std::vector<int> n_addends = addends(reference);
      const std::vector<ReferenceParticle> start = reference.particles;
      run.step(dt);
      reference.step(dt);
      const std::vector<ReferenceParticle> found = reference_particles(run.particles, run.scene.materials);
      ASSERT_EQ(found.size(), start.size());
      // What the rounding of the order-free sums can do to the velocity of each node: much where there is little mass.
      std::vector<double> of_node(reference.nodes.size(), 0.0);
      for (std::size_t n = 0; n < of_node.size(); ++n)
        if (const ReferenceNode& node = reference.nodes[n]; node.v != Vec3::Zero())
          of_node[n] = std::sqrt(3.0) *
                       (sum_tolerance(n_addends[n], run.sums.momentum) + sum_tolerance(n_addends[n], run.sums.impulse) +
                        sum_tolerance(n_addends[n], run.sums.mass) * node.v.norm()) /
                       node.m;
      for (std::size_t p = 0; p < found.size(); ++p) {
        double of_v = 1e-15, of_L = 1e-13;
        for (const ReferenceMpm::Entry& e : reference.stencil(start[p].x)) {
          of_v += e.w * of_node[e.node];
          of_L += (transfer.gradient == GradientForm::mls ? e.w * e.offset.norm() / reference.second_moment()
                                                          : e.gradient.norm()) *
                  of_node[e.node];
        }
        const ReferenceParticle& truth = reference.particles[p];
        EXPECT_LE((found[p].x - truth.x).norm(), dt * of_v + 1e-15);
        EXPECT_LE((found[p].v - truth.v).norm(), 2.0 * of_v);  // FLIP sees velocity and change
        EXPECT_LE((found[p].L - truth.L).norm(), of_L);
        if (transfer.affine() && transfer.gradient == GradientForm::mls) {
          EXPECT_LE((found[p].C - truth.C).norm(), of_L);
        }
        EXPECT_NEAR(found[p].J, truth.J, 3.0 * dt * of_L + 1e-15);
        EXPECT_LE((found[p].b - truth.b).norm(), 3.0 * dt * of_L + 4e-15);
        EXPECT_LE((found[p].tau - truth.tau).norm(), 3e5 * (3.0 * dt * of_L + 4e-15));
      }
    }
}

// --- bounds ----------------------------------------------------------------------------------------------------------

// Sums of absolute contributions, formed here without the kernel, never exceed the bounds that the kernel rounds by.
void expect_bounds_hold(SerialStep& run, double dt) {
  ReferenceMpm reference = reference_of(run);
  run.particles_to_nodes(dt);
  std::vector<double> mass(reference.nodes.size()), momentum(mass), impulse(mass);
  for (const ReferenceParticle& p : reference.particles)
    for (const ReferenceMpm::Entry& e : reference.stencil(p.x)) {
      const Vec3 v = run.scene.transfer.affine() ? Vec3(p.v + p.C * e.offset) : p.v;
      const Vec3 lever =
          run.scene.transfer.gradient == GradientForm::mls ? Vec3(e.w * e.offset / reference.second_moment()) : e.gradient;
      const Vec3 force = -dt * p.V * p.tau * lever;
      mass[e.node] += e.w * p.m;
      momentum[e.node] += (e.w * p.m * v + (run.split() ? Vec3::Zero() : force)).cwiseAbs().maxCoeff();
      impulse[e.node] += force.cwiseAbs().maxCoeff();
    }
  EXPECT_LE(*std::max_element(mass.begin(), mass.end()), run.sums.mass);
  EXPECT_LE(*std::max_element(momentum.begin(), momentum.end()), run.sums.momentum);
  EXPECT_LE(*std::max_element(impulse.begin(), impulse.end()), run.sums.impulse);
}

TEST(Transfer, BoundsHoldForRandomAndExtremeStates) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    for (const double half_width : {0.2, 0.06, 1e-9}) {  // spread; crowded; all in one place
      SerialStep run(scene, random_particles(scene, 1000, 8, true, half_width));
      for (const double dt : {1e-9, 1e-3, 1e3}) expect_bounds_hold(run, dt);
    }
    // Masses and stresses over forty orders of magnitude.
    ParticleSet extreme = random_particles(scene, 500, 9, true);
    for (LocalIndex p = 0; p < extreme.size(); ++p) {
      extreme.real(Field::reference_volume)[p] *= std::pow(10.0, p % 41 - 20);
      for (int c = 0; c < 6; ++c) extreme.real(Field::kirchhoff_stress, c)[p] *= std::pow(10.0, p % 37 - 18);
    }
    SerialStep run(scene, std::move(extreme));
    expect_bounds_hold(run, 1e-3);
  }
}

// Equal particles where every one gives a node its largest share: the bound is reached to a few percent, so it is not idle.
TEST(Transfer, TheMassBoundIsReachedByTheWorstPlacement) {
  for (const auto order : {SplineOrder::quadratic, SplineOrder::cubic}) {
    TransferSettings transfer;
    transfer.order = order;
    const SerialScene scene = open_scene(transfer);
    const double dx = scene.grid.cell_size, shift = order == SplineOrder::quadratic ? 0.5 : 0.0;
    const Vec3 node = scene.grid.lower + 4.0 * dx * Vec3::Ones();
    // Per axis: on the node, or just across the edges of the base cell that holds it.
    std::vector<double> offsets = {-1e-9, 1e-9};
    if (order == SplineOrder::quadratic) offsets = {-shift - 1e-9, 0.0, shift + 1e-9};
    if (order == SplineOrder::cubic) offsets = {-1.0 - 1e-9, -1e-9, 1e-9, 1.0 + 1e-9};
    ParticleSet set(stressed_fields(), densities_of(scene.materials));
    set.resize(static_cast<LocalIndex>(offsets.size() * offsets.size() * offsets.size()));
    LocalIndex p = 0;
    for (const double x : offsets)
      for (const double y : offsets)
        for (const double z : offsets) place_particle(set, p++, node + dx * Vec3(x, y, z), 2e-3);
    SerialStep run(scene, std::move(set));
    EXPECT_EQ(run.bounds.sums.cell_count, 1);
    run.particles_to_nodes(1e-3);
    double largest = 0.0;
    for (const Node& n : run.nodes) largest = std::max(largest, n.c[3]);
    EXPECT_LE(largest, run.sums.mass);
    EXPECT_GT(largest, (order == SplineOrder::quadratic ? 0.99 : 0.5) * run.sums.mass);
  }
}

// --- order -----------------------------------------------------------------------------------------------------------

TEST(Transfer, ShuffledParticlesGiveTheSameNodes) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    SerialStep run(scene, random_particles(scene, 1003, 10, true));
    run.particles_to_nodes(1e-3);
    for (unsigned seed = 1; seed <= 5; ++seed) {
      SerialStep other(scene, picked(run.particles, shuffled(run.particles.size(), seed)));
      other.particles_to_nodes(1e-3);
      EXPECT_TRUE(same_bits(run.nodes, other.nodes));
      EXPECT_TRUE(same_bits(run.impulse, other.impulse));
    }
  }
}

// As ranks do it: each sums its own particles under the common bounds, and the pools are added in any order.
TEST(Transfer, PartsOfTheParticlesAddUpToTheSameNodes) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    SerialStep whole(scene, random_particles(scene, 1003, 11, true));
    whole.particles_to_nodes(1e-3);
    const std::vector<LocalIndex> order = shuffled(whole.particles.size(), 12);
    std::vector<std::vector<Node>> pools, impulses;
    for (std::size_t first = 0, length = 1; first < order.size(); first += length, length = 3 * length + 1) {
      const auto begin = order.begin() + static_cast<std::ptrdiff_t>(first);
      SerialStep part(scene, picked(whole.particles,
                                    {begin, begin + static_cast<std::ptrdiff_t>(std::min(length, order.size() - first))}));
      part.bounds = whole.bounds;
      part.particles_to_nodes(1e-3);
      pools.push_back(part.nodes);
      impulses.push_back(part.impulse);
    }
    for (unsigned seed = 1; seed <= 5; ++seed) {
      std::vector<Node> sum(whole.nodes.size(), Node{}), impulse(whole.impulse.size(), Node{});
      for (const LocalIndex part : shuffled(static_cast<LocalIndex>(pools.size()), seed)) {
        const auto k = static_cast<std::size_t>(part);
        for (std::size_t n = 0; n < sum.size(); ++n)
          for (int c = 0; c < 4; ++c) sum[n].c[c] += pools[k][n].c[c];
        for (std::size_t n = 0; n < impulse.size(); ++n)
          for (int c = 0; c < 4; ++c) impulse[n].c[c] += impulses[k][n].c[c];
      }
      EXPECT_TRUE(same_bits(whole.nodes, sum));
      EXPECT_TRUE(same_bits(whole.impulse, impulse));
    }
  }
}

// Whole steps, stress and all: a particle's bits must not depend on the neighbours in its pack.
TEST(Transfer, ShuffledParticlesTakeTheSameSteps) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    SerialStep run(scene, random_particles(scene, 501, 13, false));
    SerialStep other(scene, picked(run.particles, shuffled(run.particles.size(), 14)));
    for (int step = 0; step < 10; ++step) {
      run.step(1e-3);
      other.step(1e-3);
      if (step == 5) sort_particles(other.particles, other.map);
    }
    std::vector<LocalIndex> by_id(static_cast<std::size_t>(run.particles.size()));
    for (LocalIndex p = 0; p < other.particles.size(); ++p) by_id[static_cast<std::size_t>(other.particles.id()[p])] = p;
    EXPECT_TRUE(same_particles(run.particles, picked(other.particles, by_id)));
    EXPECT_EQ(run.bounds.motion.speed.value, other.bounds.motion.speed.value);
    EXPECT_EQ(run.bounds.motion.speed.id, other.bounds.motion.speed.id);
    EXPECT_EQ(run.bounds.motion.velocity_gradient.id, other.bounds.motion.velocity_gradient.id);
    EXPECT_EQ(run.bounds.motion.wave_speed.id, other.bounds.motion.wave_speed.id);
    EXPECT_EQ(run.bounds.sums.momentum, other.bounds.sums.momentum);
    EXPECT_EQ(run.bounds.sums.stress_volume, other.bounds.sums.stress_volume);
  }
}

// The solver advances particles block by block.
TEST(Transfer, BlocksTogetherTakeTheStepOfTheWhole) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    SerialStep whole(scene, random_particles(scene, 301, 15, true));
    SerialStep parts(scene, random_particles(scene, 301, 15, true));
    for (SerialStep* run : {&whole, &parts}) {
      run->particles_to_nodes(1e-3);
      run->update_nodes(1e-3);
    }
    whole.nodes_to_particles(1e-3);
    const Field gradient = transfer.needs_velocity_gradient() ? Field::velocity_gradient : Field::affine_velocity;
    parts.bounds = StepBounds{};
    StepBounds& bounds = parts.bounds;
    for (LocalIndex begin = 0; begin < parts.particles.size(); begin += 2 * ParticleSet::padding) {
      const ParticleBlock block{begin, begin + 2 * ParticleSet::padding};
      parts.gather(1e-3, block);
      for (std::size_t m = 0; m < scene.materials.size(); ++m)
        stress_update(scene.materials[m].material, static_cast<std::uint8_t>(m), gradient, 1e-3, parts.particles, bounds,
                      block);
    }
    EXPECT_TRUE(same_particles(whole.particles, parts.particles));
    EXPECT_EQ(bounds.motion.speed.id, whole.bounds.motion.speed.id);
    EXPECT_EQ(bounds.motion.velocity_gradient.value, whole.bounds.motion.velocity_gradient.value);
    EXPECT_EQ(bounds.sums.mass, whole.bounds.sums.mass);
    EXPECT_EQ(bounds.sums.momentum, whole.bounds.sums.momentum);
    EXPECT_EQ(bounds.sums.stress_volume, whole.bounds.sums.stress_volume);
    EXPECT_EQ(bounds.totals.largest_volume_ratio, whole.bounds.totals.largest_volume_ratio);
  }
}

// --- base nodes ------------------------------------------------------------------------------------------------------

// Positions as close to cell edges as doubles go. If p2g and locate disagreed about a particle's base node, the mass would
// be a cell away from it.
TEST(Transfer, BaseNodesAgreeAtTheEdgesOfCells) {
  std::mt19937_64 generator(15);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const auto order : {SplineOrder::quadratic, SplineOrder::cubic})
    for (int trial = 0; trial < 40; ++trial) {
      TransferSettings transfer;
      transfer.order = order;
      SerialScene scene = open_scene(transfer);
      scene.grid.cell_size = std::exp(4.0 * uniform(generator) - 4.0);
      for (int a = 0; a < 3; ++a) scene.grid.lower[a] = 4.0 * uniform(generator) - 2.0;
      const Vec3 upper = scene.grid.upper();

      // Per axis: a few doubles on either side of each place where the base node changes, and the faces themselves.
      std::array<std::vector<double>, 3> edges;
      for (int a = 0; a < 3; ++a)
        for (int cell = 0; cell <= scene.grid.n_cells[a]; ++cell) {
          const double shift = order == SplineOrder::quadratic ? 0.5 : 0.0;
          double x = scene.grid.lower[a] + (cell + shift) * scene.grid.cell_size;
          for (int k = 0; k < 4; ++k) x = std::nextafter(x, -1e9);
          for (int k = 0; k < 9; ++k, x = std::nextafter(x, 1e9))
            if (x >= scene.grid.lower[a] && x <= upper[a]) edges[a].push_back(x);
        }
      ParticleSet set(stressed_fields(), densities_of(scene.materials));
      set.resize(1);
      place_particle(set, 0, scene.grid.lower, 1e-3);
      SerialStep run(scene, std::move(set));
      for (std::size_t n = 0; n < edges[0].size(); ++n) {
        const Vec3 x(edges[0][n], edges[1][n * 7 % edges[1].size()], edges[2][n * 11 % edges[2].size()]);
        run.particles.set_vector(Field::position, 0, x);
        run.measure();
        run.particles_to_nodes(1e-3);
        Vec3 center = Vec3::Zero();
        double mass = 0.0;
        for (std::size_t i = 0; i < run.nodes.size(); ++i) {
          if (run.nodes[i].c[3] == 0.0) continue;
          mass += run.nodes[i].c[3];
          center += run.nodes[i].c[3] * (run.node_position(i) - x);
        }
        EXPECT_NEAR(mass, 1.0, 1e-13);
        EXPECT_LE(center.norm(), 1e-12 * (scene.grid.cell_size + x.norm())) << x.transpose();
      }
    }
}

// The weights reproduce linear functions.
TEST(GridToParticles, GathersTheNodesFourthNumberAndItsSlopeByPlaceInTheBlock) {
  const Vec3 slope(3.0, -2.0, 0.5);
  for (const TransferSettings& transfer : all_transfers()) {
    SerialStep run(open_scene(transfer), random_particles(open_scene(transfer), 203, 5, true));
    run.particles_to_nodes(1e-3);
    run.update_nodes(1e-3);
    for (std::size_t n = 0; n < run.nodes.size(); ++n) run.nodes[n].c[3] = 1.0 + slope.dot(run.node_position(n));
    std::vector<double> expected;
    for (LocalIndex p = 0; p < run.particles.size(); ++p)
      expected.push_back(1.0 + slope.dot(run.particles.vector(Field::position, p)));
    for (const ParticleBlock block : {ParticleBlock{0, 96}, ParticleBlock{96, 300}}) {
      const std::size_t size = static_cast<std::size_t>(block.end - block.begin) + n_lanes;
      std::vector<double> value(size, -1.0), along_x(size), along_z(size);
      run.gather(1e-3, block, {value.data(), {along_x.data(), nullptr, along_z.data()}});
      for (LocalIndex p = block.begin; p < std::min(block.end, run.particles.size()); ++p) {
        const auto place = static_cast<std::size_t>(p - block.begin);
        EXPECT_NEAR(value[place], expected[static_cast<std::size_t>(p)], 1e-13) << p;
        EXPECT_NEAR(along_x[place], slope[0] * run.scene.grid.cell_size, 1e-12) << p;
        EXPECT_NEAR(along_z[place], slope[2] * run.scene.grid.cell_size, 1e-12) << p;
      }
    }
  }
}

TEST(GridToParticles, LeavesTheKineticEnergiesOfTheNewMotion) {
  for (const TransferSettings& transfer : all_transfers()) {
    SerialStep run(open_scene(transfer), random_particles(open_scene(transfer), 203, 5, true));
    run.particles_to_nodes(1e-3);
    run.update_nodes(1e-3);
    const double inertia = affine_inertia(run.scene.grid, transfer);
    EXPECT_EQ(inertia > 0.0, transfer.affine());
    for (const ParticleBlock block : {ParticleBlock{0, 96}, ParticleBlock{96, 300}}) {
      std::vector<double> energies(static_cast<std::size_t>(block.end - block.begin) + n_lanes);
      run.gather(1e-3, block, {.kinetic_energy = energies.data()});
      for (LocalIndex p = block.begin; p < std::min(block.end, run.particles.size()); ++p) {
        double square = run.particles.vector(Field::velocity, p).squaredNorm();
        for (int c = 0; c < 9; ++c) square += inertia * std::pow(run.particles.real(Field::affine_velocity, c)[p], 2);
        const double expected = 0.5 * run.particles.mass(p) * square;
        EXPECT_NEAR(energies[static_cast<std::size_t>(p - block.begin)], expected, 1e-14 * expected) << p;
      }
    }
  }
}

}  // namespace
}  // namespace bulkley::transfer_test
