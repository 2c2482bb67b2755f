#include "integrator/describe_failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace bulkley {

namespace {

constexpr const char* on_steps =
    "try smaller factors of the time step (time.elastic_cfl, time.deformation_limit, time.deformation_check = \"always\")";

struct ParticleReport {
  std::string text;
  std::optional<Vec3> place;
};

// The rank that holds the particle speaks: ids are unique, so there is at most one. Collective.
ParticleReport report_on(const Comm& comm, GlobalIndex id, const ParticleSet& particles,
                         const std::vector<NamedMaterial>& materials) {
  const GlobalIndex* ids = particles.id();
  const auto p = static_cast<LocalIndex>(std::find(ids, ids + particles.size(), id) - ids);
  const bool here = p < particles.size();
  std::string text;
  Vec3 place = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  if (here) {
    place = particles.vector(Field::position, p);
    text = fmt::format("particle {} of material '{}' at ({:.6g}, {:.6g}, {:.6g}) m with speed {:.6g} m/s and J = {:.6g}", id,
                       materials[particles.material()[p]].name, place[0], place[1], place[2],
                       particles.vector(Field::velocity, p).norm(), particles.real(Field::volume_ratio)[p]);
  }
  const auto speaker = static_cast<int>(min_global(comm, here ? GlobalIndex{comm.rank()} : GlobalIndex{comm.size()}));
  if (speaker == comm.size()) return {fmt::format("particle {}, which has left", id), {}};
  int length = static_cast<int>(text.size());
  BULKLEY_MPI(MPI_Bcast(&length, 1, MPI_INT, speaker, comm.get()));
  text.resize(static_cast<std::size_t>(length));
  BULKLEY_MPI(MPI_Bcast(text.data(), length, MPI_CHAR, speaker, comm.get()));
  BULKLEY_MPI(MPI_Bcast(place.data(), 3, MPI_DOUBLE, speaker, comm.get()));
  return {std::move(text), place.allFinite() ? std::optional<Vec3>(place) : std::nullopt};
}

// The smallest id of a particle for which `is_at_fault(p)`; -1 if there is none. Collective.
template <class IsAtFault>
GlobalIndex first_at_fault(const Comm& comm, const ParticleSet& particles, const IsAtFault& is_at_fault) {
  constexpr GlobalIndex none = std::numeric_limits<GlobalIndex>::max();
  GlobalIndex first = none;
  for (LocalIndex p = 0; p < particles.size(); ++p)
    if (is_at_fault(p)) first = std::min(first, particles.id()[p]);
  first = min_global(comm, first);
  return first == none ? -1 : first;
}

std::string advice_for(const StepBounds& bounds) {
  if (bounds.failures.n_not_finite + bounds.failures.n_inverted > 0) return on_steps;
  return "let this face of [boundaries] be a wall or an outflow, or make the domain larger";
}

}  // namespace

void throw_failure(const Comm& comm, const GridGeometry& grid, const ParticleSet& particles,
                   const std::vector<NamedMaterial>& materials, const StepBounds& bounds) {
  if (bounds.failures.n_undefined_nodes > 0) {  // any particle failure follows from that
    const Vec3 x = grid.node_position(grid.node_of_number(bounds.failures.undefined_node));
    throw StepFailure(fmt::format("the acceleration_field is NaN or infinite on {} {}, first at ({:.6g}, {:.6g}, {:.6g}) m",
                                  bounds.failures.n_undefined_nodes.value,
                                  bounds.failures.n_undefined_nodes == 1 ? "node" : "nodes", x[0], x[1], x[2]),
                      x);
  }
  std::string what;
  auto count = [&](GlobalIndex n, const char* fault) {
    if (n > 0) what += fmt::format("{}{} {} {}", what.empty() ? "" : "; ", n, n == 1 ? "particle" : "particles", fault);
  };
  count(bounds.failures.n_escaped, "left the domain through a face that is no outflow");
  count(bounds.failures.n_inverted, "inverted (det(1 + dt L) <= 0)");
  count(bounds.failures.n_not_finite, "became NaN or infinite");
  const ParticleReport first = report_on(comm, bounds.failures.failed_id, particles, materials);
  throw StepFailure(fmt::format("{}; the first is {}; {}", what, first.text, advice_for(bounds)), first.place);
}

void throw_failure(const Comm& comm, const ParticleSet& particles, const std::vector<NamedMaterial>& materials,
                   const NoStep& reason) {
  if (reason.particle < 0) throw StepFailure(fmt::format("{}; {}", reason.what(), reason.advice), {});
  const ParticleReport offender = report_on(comm, reason.particle, particles, materials);
  throw StepFailure(fmt::format("{}: {}; {}", reason.what(), offender.text, reason.advice), offender.place);
}

void check_motion(const Comm& comm, const TimeStepSettings& settings, double cell_size, double dt,
                  const ParticleSet& particles, const StepBounds& bounds) {
  const double* ratio = particles.real(Field::volume_ratio);
  if (bounds.totals.smallest_volume_ratio < settings.smallest_volume_ratio)
    throw NoStep(fmt::format("material is crushed to less than {:g} of its volume (time.smallest_volume_ratio)",
                             settings.smallest_volume_ratio),
                 first_at_fault(comm, particles, [&](LocalIndex p) { return ratio[p] < settings.smallest_volume_ratio; }),
                 "try a larger bulk_modulus, slower motion, or a smaller limit");
  if (bounds.totals.largest_volume_ratio > settings.largest_volume_ratio)
    throw NoStep(fmt::format("material has grown to more than {:g} times its volume (time.largest_volume_ratio)",
                             settings.largest_volume_ratio),
                 first_at_fault(comm, particles, [&](LocalIndex p) { return ratio[p] > settings.largest_volume_ratio; }),
                 "try more particles per cell, cohesion in the law, or a larger limit");
  if (dt * bounds.motion.speed.value > cell_size)
    throw NoStep(
        fmt::format("a particle moves {:.3g} cells in a step of {:.6g} s", dt * bounds.motion.speed.value / cell_size, dt),
        bounds.motion.speed.id, "try a smaller time.cfl or time.dt, or time.deformation_check = \"always\"");
}

}  // namespace bulkley
