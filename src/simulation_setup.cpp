#include "bulkley/simulation_setup.hpp"

#include "bulkley/kernel/stress_update.hpp"

namespace bulkley {

Physics physics_of(const Scene& scene) {
  return {scene.grid,      scene.transfer, scene.time,      scene.gravity,
          scene.materials, scene.faces,    scene.colliders, scene.acceleration_field};
}

OptionalFields optional_fields(const Scene& scene) {
  OptionalFields fields = internal_fields(scene.materials);
  if (scene.transfer.needs_velocity_gradient()) fields.insert(Field::velocity_gradient);
  return fields;
}

namespace {

void sum_over_ranks(const Comm& comm, std::vector<GlobalIndex>& load) {
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, load.data(), static_cast<int>(load.size()), MPI_INT64_T, MPI_SUM, comm.get()));
}

}  // namespace

std::vector<GlobalIndex> seeded_load(const Comm& comm, const Scene& scene) {
  const TileIndex n_tiles = scene.grid.n_tiles();
  std::vector<GlobalIndex> load(static_cast<std::size_t>(n_tiles), 0);
  const auto first = static_cast<TileIndex>(GlobalIndex{n_tiles} * comm.rank() / comm.size());
  const auto last = static_cast<TileIndex>(GlobalIndex{n_tiles} * (comm.rank() + 1) / comm.size());
  collective_guard(comm, [&] {
    const std::vector<GlobalIndex> share = count_particles(scene.grid, scene.bodies, first, last);
    std::copy(share.begin(), share.end(), load.begin() + first);
  });
  sum_over_ranks(comm, load);
  return load;
}

std::vector<GlobalIndex> present_load(const Comm& comm, const GridGeometry& grid, const ParticleSet& particles) {
  std::vector<GlobalIndex> load(static_cast<std::size_t>(grid.n_tiles()), 0);
  for (LocalIndex p = 0; p < particles.size(); ++p)
    ++load[static_cast<std::size_t>(grid.tile_of(particles.vector(Field::position, p)))];
  sum_over_ranks(comm, load);
  return load;
}

ParticleSet seed_share(const Comm& comm, const Scene& scene, const Partition& partition) {
  std::vector<TileIndex> tiles;
  for (std::size_t tile = 0; tile < partition.worker.size(); ++tile)
    if (partition.worker[tile] == comm.rank()) tiles.push_back(static_cast<TileIndex>(tile));
  ParticleSet particles(optional_fields(scene));
  collective_guard(comm, [&] { seed_particles(scene.grid, scene.bodies, tiles, particles); });
  for (std::size_t m = 0; m < scene.materials.size(); ++m)
    set_internal_variables(scene.materials[m].material, static_cast<std::uint8_t>(m), particles);
  return particles;
}

std::unique_ptr<Solver> start_solver(const Comm& comm, const Scene& scene) {
  Partition partition = make_partition(scene.grid, scene.partition, seeded_load(comm, scene), comm.size());
  ParticleSet particles = seed_share(comm, scene, partition);
  return std::make_unique<Solver>(comm, physics_of(scene), std::move(partition), std::move(particles), std::nullopt);
}

}  // namespace bulkley
