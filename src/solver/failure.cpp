#include "failure.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace bulkley {

std::string describe_failure(const Comm& comm, const GridGeometry& grid, const ParticleSet& particles,
                             const std::vector<NamedMaterial>& materials, const StepBounds& bounds) {
  if (bounds.n_undefined_nodes > 0) {  // whatever befell the particles follows from that
    const Vec3 x = grid.node_position(grid.node_of_number(bounds.undefined_node));
    return fmt::format("the acceleration_field is NaN or infinite on {} {}, first at ({:.6g}, {:.6g}, {:.6g}) m",
                       bounds.n_undefined_nodes, bounds.n_undefined_nodes == 1 ? "node" : "nodes", x[0], x[1], x[2]);
  }
  // The rank that holds the particle writes about it; the lowest such rank speaks (ids are unique, so there is one).
  const GlobalIndex* id = particles.id();
  const GlobalIndex* found = std::find(id, id + particles.size(), bounds.failed_id);
  std::string text;
  const bool here = found != id + particles.size();
  if (here) {
    const auto p = static_cast<LocalIndex>(found - id);
    const Vec3 x = particles.vector(Field::position, p), v = particles.vector(Field::velocity, p);
    text = fmt::format("particle {} of material '{}' at ({:.6g}, {:.6g}, {:.6g}) m with speed {:.6g} m/s and J = {:.6g}",
                       *found, materials[particles.material()[p]].name, x[0], x[1], x[2], v.norm(),
                       particles.real(Field::volume_ratio)[p]);
  }
  const auto speaker = static_cast<int>(min_global(comm, here ? GlobalIndex{comm.rank()} : GlobalIndex{comm.size()}));
  if (speaker < comm.size()) {
    int length = static_cast<int>(text.size());
    BULKLEY_MPI(MPI_Bcast(&length, 1, MPI_INT, speaker, comm.get()));
    text.resize(static_cast<std::size_t>(length));
    BULKLEY_MPI(MPI_Bcast(text.data(), length, MPI_CHAR, speaker, comm.get()));
  }
  std::string what;
  auto count = [&](GlobalIndex n, const char* fault) {
    if (n > 0) what += fmt::format("{}{} {} {}", what.empty() ? "" : "; ", n, n == 1 ? "particle" : "particles", fault);
  };
  count(bounds.n_escaped, "left the domain through a face that is no outflow");
  count(bounds.n_inverted, "turned inside out (det(1 + dt L) <= 0)");
  count(bounds.n_not_finite, "became NaN or infinite");
  return fmt::format("{}; the first is {}", what, text);
}

}  // namespace bulkley
