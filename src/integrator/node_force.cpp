#include "integrator/node_force.hpp"

#include "integrator/acceleration_force.hpp"
#include "integrator/magnetic_force.hpp"

namespace bulkley {

namespace {

std::string prefix_of(const NodeForce& force) { return std::string("force.") + force.name() + "."; }

template <class Number>
void add_prefixed(const std::string& prefix, const std::map<std::string, Number>& from, std::map<std::string, Number>& to) {
  for (const auto& [name, number] : from) to[prefix + name] = number;
}

template <class Number>
std::map<std::string, Number> without_prefix(const std::string& prefix, const std::map<std::string, Number>& from) {
  std::map<std::string, Number> result;
  for (const auto& [name, number] : from)
    if (name.starts_with(prefix)) result[name.substr(prefix.size())] = number;
  return result;
}

}  // namespace

NodeForces node_forces_of(const Physics& physics) {
  NodeForces forces;
  if (physics.acceleration_field.given())
    forces.push_back(std::make_unique<AccelerationForce>(physics.grid, physics.acceleration_field));
  if (physics.magnets) forces.push_back(std::make_unique<MagneticForce>(physics.grid, *physics.magnets));
  return forces;
}

void save_forces(const NodeForces& forces, Reals& reals, Integers& integers) {
  for (const auto& force : forces) {
    Reals own_reals;
    Integers own_integers;
    force->save(own_reals, own_integers);
    add_prefixed(prefix_of(*force), own_reals, reals);
    add_prefixed(prefix_of(*force), own_integers, integers);
  }
}

void load_forces(NodeForces& forces, const Reals& reals, const Integers& integers) {
  for (const auto& force : forces)
    force->load(without_prefix(prefix_of(*force), reals), without_prefix(prefix_of(*force), integers));
}

}  // namespace bulkley
