// Writes a small run as the program would: frames (one of them empty), a grid, tiles, colliders and a checkpoint, of a ball
// that falls.
// Usage: write_sample_run FOLDER

#include <petscsys.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "bulkley/parallel/petsc.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "io/files/text_file.hpp"
#include "io/frames/frame.hpp"

namespace {

using namespace bulkley;

constexpr double spacing = 0.01, radius = 0.1;
constexpr OptionalFields fields{Field::kirchhoff_stress, Field::structure, Field::viscous_left_cauchy_green};

/// A ball of particles at height `z`, every rank a share of them; those in its shell belong to the second material.
ParticleSet make_ball(const Comm& comm, double z) {
  ParticleSet particles(fields, Densities(std::array{1000.0, 1000.0}));
  GlobalIndex id = 0;
  const int n = static_cast<int>(radius / spacing);
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j)
      for (int k = -n; k <= n; ++k) {
        const Vec3 from_center = spacing * Vec3(i, j, k);
        if (from_center.norm() > radius || id++ % comm.size() != comm.rank()) continue;
        const LocalIndex p = particles.size();
        particles.resize(p + 1);
        particles.id()[p] = id - 1;
        particles.material()[p] = from_center.norm() > 0.7 * radius;
        particles.set_vector(Field::position, p, Vec3(0.5, 0.4, z) + from_center);
        particles.set_vector(Field::velocity, p, Vec3(0.0, 0.0, -5.0 + from_center.x() * 20.0));
        particles.real(Field::volume_ratio)[p] = 1.0;
        particles.real(Field::reference_volume)[p] = spacing * spacing * spacing;
        for (int c = 0; c < 6; ++c) particles.real(Field::kirchhoff_stress, c)[p] = 100.0 * (c + 1) + from_center.z();
        for (int c = 0; c < 3; ++c) particles.real(Field::left_cauchy_green, c)[p] = 1.0;
      }
  return particles;
}

/// All nodes on the root, with velocities that say where they are.
GridNodes make_grid(const Comm& comm, std::vector<Node>& nodes) {
  GridGeometry geometry;
  geometry.cell_size = 0.1;
  geometry.n_cells = {10, 8, 6};
  GridNodes grid{geometry, {0, 0, 0}, {0, geometry.n_nodes(1), geometry.n_nodes(2)}, {}};
  grid.count[0] = comm.is_root() ? geometry.n_nodes(0) : 0;
  for (int i = 0; i < grid.count[0]; ++i)
    for (int j = 0; j < grid.count[1]; ++j)
      for (int k = 0; k < grid.count[2]; ++k)
        nodes.push_back(
            {{geometry.node_coordinate(0, i), geometry.node_coordinate(1, j), geometry.node_coordinate(2, k), 1.0}});
  grid.nodes = nodes;
  return grid;
}

/// Values of the tiles that say which tile they belong to.
struct SampleTiles {
  explicit SampleTiles(const GridGeometry& grid) : geometry(grid) {
    std::vector<std::int32_t> rank;
    for (TileIndex t = 0; t < grid.n_tiles(); ++t) {
      rank.push_back(t % 3);
      tile.push_back(t);
      particles.push_back(10 * t);
      load.push_back(0.5 + t);
    }
    owners = TileMap(3, std::move(rank));
  }
  TileValues values() const { return {geometry, owners, tile, particles, load}; }

  GridGeometry geometry;
  TileMap owners;
  std::vector<TileIndex> tile;
  std::vector<GlobalIndex> particles;
  std::vector<double> load;
};

/// One that rests and one that turns as it rises.
std::vector<Collider> make_colliders() {
  std::vector<Collider> colliders(2);
  colliders[0].name = "stone";
  colliders[0].shape = {Sphere{{0.2, 0.2, 0.1}, 0.1}};
  colliders[1].name = "paddle";
  colliders[1].shape = {Box{{0.7, 0.3, 0.1}, {0.9, 0.5, 0.15}}};
  colliders[1].motion.velocity = Vec3(0.0, 0.0, 1.0);
  colliders[1].motion.angular_velocity = Vec3(0.0, 5.0, 0.0);
  colliders[1].motion.center = Vec3(0.8, 0.4, 0.125);
  return colliders;
}

void write_run(const Comm& comm, const std::string& folder) {
  const std::vector<NamedMaterial> materials{{"cream", HerschelBulkley{}}, {"pie", NeoHookean{}}};
  OutputSettings settings;
  settings.fields = frame_field_names();
  std::erase(settings.fields, "added_law_variables");
  std::erase(settings.fields, "cell_mean_stress");  // of runs with the implicit pressure
  std::erase(settings.fields, "layer_pressure");    // with the explicit step, of some fluids
  std::erase(settings.fields, "viscous_stress");    // and with implicit viscosity
  std::erase(settings.fields, "magnetic_field_strength");
  std::erase(settings.fields, "magnetic_field");
  std::erase(settings.fields, "magnetisation");
  std::erase(settings.fields, "magnetic_force");
  std::erase(settings.fields, "hardening");
  std::erase(settings.fields, "plastic_volume_ratio");
  std::vector<Node> nodes;
  const GridNodes grid = make_grid(comm, nodes);
  const SampleTiles sample(grid.geometry);
  const TileValues tiles = sample.values();

  root_guard(comm, [&] {
    std::filesystem::create_directories(folder);
    write_text_atomically(path_in(folder, "scene.toml"),
                          "[domain]\nlower = [0.0, 0.0, 0.0]\nupper = [1.0, 0.8, 0.6]\ncell_size = 0.1\n");
  });
  const ColliderSurfaces colliders(make_colliders(), {}, {Vec3::Zero(), Vec3(1.0, 0.8, 0.6)});
  colliders.write(comm, folder);
  FrameSeries series(comm, folder, -1);
  for (GlobalIndex index = 0; index < 4; ++index) {
    const double time = 0.04 * static_cast<double>(index);
    const ParticleSet particles = index == 2 ? ParticleSet(fields) : make_ball(comm, 0.4 - 5.0 * time * 0.5);
    write_frame(comm, folder, {index, 10 * index, time, 0}, particles, materials, settings, &grid, &tiles, &colliders);
    series.add(comm, index);
  }
  CheckpointHeader header;
  header.step = 30;
  header.time = 0.12;
  write_checkpoint(comm, folder, header, make_ball(comm, 0.1), std::vector<std::string>{"cream", "pie"}, 1);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_sample_run FOLDER\n");
    return 2;
  }
  BULKLEY_PETSC(PetscInitializeNoArguments());
  {
    const Comm comm(PETSC_COMM_WORLD);
    write_run(comm, argv[1]);
  }
  BULKLEY_PETSC(PetscFinalize());
  return 0;
}
