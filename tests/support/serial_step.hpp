#pragma once
// One step of the real kernels in one process: the pool holds every node of the grid once, so nothing is exchanged.
// Not for periodic grids, whose pools hold copies that only an exchange brings together.

#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "kernel/bspline.hpp"
#include "kernel/g2p.hpp"
#include "kernel/grid_update.hpp"
#include "kernel/measure_particles.hpp"
#include "kernel/p2g.hpp"
#include "kernel/stress_update.hpp"
#include "support/particle_builders.hpp"
#include "support/random_vectors.hpp"

namespace bulkley {

/// Everything that does not change during a run.
struct SerialScene {
  GridGeometry grid;
  TransferSettings transfer;
  Vec3 gravity = Vec3::Zero();  ///< m/s^2
  Faces faces;
  std::vector<Collider> colliders;
  std::vector<NamedMaterial> materials;
};

/// 8^3 cells of 1/8 m with open faces, away from the origin; an elastic solid and a fluid.
inline SerialScene open_scene(const TransferSettings& transfer) {
  SerialScene scene;
  scene.grid = {.lower = Vec3(-0.3, 0.2, 0.1), .cell_size = 0.125, .n_cells = {8, 8, 8}, .order = transfer.order};
  scene.transfer = transfer;
  for (Face& face : scene.faces) face.kind = FaceKind::open;
  scene.materials = {{"solid", NeoHookean{{1000.0, 1e5, 3e4}}},
                     {"fluid", HerschelBulkley{{800.0, 1e5, 3e4, 400.0, 50.0, 0.4}}}};
  return scene;
}

/// Particles anywhere within `half_width` of the domain's centre, with random velocities, affine matrices and volumes, of the
/// scene's materials in turn; with random stresses too if `stressed`.
inline ParticleSet random_particles(const SerialScene& scene, LocalIndex count, unsigned seed, bool stressed,
                                    double half_width = 0.2) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto random_matrix = [&] {
    Mat3 m;
    for (int a = 0; a < 3; ++a) m.col(a) = random_vector(uniform, generator);
    return m;
  };
  ParticleSet set(stressed_fields(scene.transfer.needs_velocity_gradient()), densities_of(scene.materials));
  set.resize(count);
  const Vec3 middle = 0.5 * (scene.grid.lower + scene.grid.upper());
  for (LocalIndex p = 0; p < count; ++p) {
    const double volume = 1e-3 * (1.5 + uniform(generator));
    place_particle(set, p, middle + half_width * random_vector(uniform, generator), volume);
    set.set_vector(Field::velocity, p, random_vector(uniform, generator));
    set_tensor(set, Field::affine_velocity, p, random_matrix());
    const Mat3 s = random_matrix();
    if (stressed) set_symmetric(set, Field::kirchhoff_stress, p, 1e3 * (s + s.transpose()));
    set.material()[p] = static_cast<std::uint8_t>(p % static_cast<LocalIndex>(scene.materials.size()));
  }
  return set;
}

/// Particles, all nodes, and the kernels that take one to the other.
class SerialStep {
 public:
  SerialStep(SerialScene scene_of_run, ParticleSet start) : scene(std::move(scene_of_run)), particles(std::move(start)) {
    std::vector<TileIndex> tiles(static_cast<std::size_t>(scene.grid.n_tiles()));
    std::iota(tiles.begin(), tiles.end(), 0);
    layout = PoolLayout(scene.grid, tiles);
    const auto n_nodes = static_cast<std::size_t>(layout.n_nodes());
    nodes.resize(n_nodes);
    if (split()) impulse.resize(n_nodes);
    active.resize(n_nodes);
    std::iota(active.begin(), active.end(), 0);
    for (const NodeRow& row : layout.rows())
      for (int n = 0; n < row.count; ++n) indices.push_back({row.i, row.j, row.k + n});
    constraints = node_constraints(scene.grid, scene.faces, scene.colliders, indices);
    images = node_images(scene.grid, scene.faces, indices);
    measure();
  }

  /// Bounds and cells of the particles as they are; to be called after a change by hand.
  void measure() {
    bounds = StepBounds{};
    measure_particles(scene.grid, scene.transfer, particles, bounds);
    for (LocalIndex p = 0; p < particles.size(); ++p) {
      SymTensor<double> tau;
      for (int c = 0; c < 6; ++c) tau.c[c] = particles.real(Field::kirchhoff_stress, c)[p];
      bounds.sums.stress_volume.include(particles.real(Field::reference_volume)[p] * std::sqrt(norm_squared(tau)));
    }
    find_cells();
  }

  void step(double dt) {
    particles_to_nodes(dt);
    update_nodes(dt);
    nodes_to_particles(dt);
  }

  void particles_to_nodes(double dt) {
    sums = sum_bounds(scene.grid, scene.transfer, bounds, dt, scene.transfer.keeps_residual(), force);
    if (!split()) return p2g(scene.grid, scene.transfer, layout, particles, map, sums, dt, nodes.data(), force);
    std::vector<NodePair> pairs(nodes.size());
    p2g(scene.grid, scene.transfer, layout, particles, map, sums, dt, pairs.data(), force);
    for (std::size_t n = 0; n < pairs.size(); ++n) nodes[n] = pairs[n].motion, impulse[n] = pairs[n].change;
  }

  void update_nodes(double dt) {
    Node* const change = split() ? impulse.data() : nullptr;
    const GridUpdate update{scene.gravity, dt, empty_mass * sums.mass};
    fold_images(update, images, nodes.data(), change);
    grid_update(update, active, nodes.data(), change);
    ContactImpulses impulses(scene.colliders.size(), 1.0, 1.0);
    apply_constraints(constraints, nodes.data(), change, impulses);
    unfold_images(images, nodes.data(), change);
  }

  void nodes_to_particles(double dt) {
    bounds = StepBounds{};
    gather(dt);
    const Field gradient = scene.transfer.needs_velocity_gradient() ? Field::velocity_gradient : Field::affine_velocity;
    for (std::size_t m = 0; m < scene.materials.size(); ++m)
      stress_update(scene.materials[m].material, static_cast<std::uint8_t>(m), gradient, dt, particles, bounds);
    std::vector<LocalIndex> removed;
    confine(scene.grid, scene.faces, particles, removed, bounds);
    particles.remove(removed);
    find_cells();
  }

  /// The kernel g2p on a block.
  void gather(double dt, ParticleBlock block = {}, const Gathered& gathered = {}) {
    if (!split()) return g2p(scene.grid, scene.transfer, layout, map, dt, nodes.data(), particles, bounds, block, gathered);
    std::vector<NodePair> pairs;
    for (std::size_t n = 0; n < nodes.size(); ++n) pairs.push_back({nodes[n], impulse[n]});
    const double rate = scene.transfer.damping_time > 0.0 ? 1.0 / scene.transfer.damping_time : 0.0;
    g2p(scene.grid, scene.transfer, layout, map, dt, scene.transfer.kept_share(dt, rate), pairs.data(), particles, bounds,
        block, gathered);
  }

  Vec3 node_position(std::size_t n) const {
    return {scene.grid.node_coordinate(0, indices[n][0]), scene.grid.node_coordinate(1, indices[n][1]),
            scene.grid.node_coordinate(2, indices[n][2])};
  }
  bool split() const { return scene.transfer.keeps_residual(); }
  /// D_p = second moment of the weights, m^2.
  double second_moment() const {
    return scene.grid.cell_size * scene.grid.cell_size / inverse_second_moment(scene.grid.order);
  }

  static constexpr double empty_mass = 0x1p-48;  ///< of the largest possible nodal mass, as in the solver

  SerialScene scene;
  ParticleSet particles;
  PoolLayout layout;
  std::vector<Int3> indices;  ///< grid indices of the pool's nodes
  std::vector<Node> nodes;    ///< {m v + dt f, m}, after update_nodes {v, m}
  std::vector<Node> impulse;  ///< {dt f}, after update_nodes {change of v}; empty unless split()
  std::vector<LocalIndex> active;
  std::vector<NodeConstraint> constraints;
  std::vector<NodeImage> images;
  CellMap map;
  StepBounds bounds;
  SumBounds sums{};
  ForceField force;  ///< on particles

 private:
  void find_cells() {
    std::vector<OutsideParticle> outside;
    map.reset(layout, particles.size());
    locate(scene.grid, layout, particles, map, outside);
    bounds.sums.cell_count.value = map.largest_count();
  }
};

}  // namespace bulkley
