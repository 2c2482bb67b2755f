#include "scene/rigid_body_keys.hpp"

#include <fmt/format.h>

#include "scene/boundary_keys.hpp"
#include "scene/shape_keys.hpp"

namespace bulkley {

namespace {

constexpr std::size_t most_bodies = 1000;

void check_body(const config::Value& table, RigidBody& body, config::Faults& faults) {
  if (body.density.has_value() == body.mass.has_value())
    faults.add(table.place, fmt::format("rigid body '{}' needs a 'density' or a 'mass', one of the two", body.name));
  if (body.contact == Contact::separating)
    faults.add(
        table.find("contact")->place,
        fmt::format("'{}.contact' is \"separating\", which rigid bodies do not have; \"sticky\" or \"slip\"", table.path));
}

}  // namespace

const config::Keys<RigidBody>& keys(config::Of<RigidBody>) {
  static const auto table =
      config::Keys<RigidBody>(
          "A solid body that gravity and the material move. history.csv contains its position, velocity and spin, and the "
          "force and the "
          "torque about its centre of mass by the material, averaged since the previous row.")
          .key("name", &RigidBody::name,
               {.about = "Name in messages and columns; different for each body and collider.", .required = true})
          .key("shape", &RigidBody::shape,
               {.about = "Initial geometry: a box, sphere, cylinder, capsule, ellipsoid or closed mesh.", .required = true})
          .key("density", &RigidBody::density,
               {.about = "Mass per volume, the same everywhere in the body.",
                .unit = "kg/m^3",
                .range = config::above(0.0),
                .default_text = "from `mass`"})
          .key("mass", &RigidBody::mass,
               {.about = "Mass, spread evenly over the body, instead of the density.",
                .unit = "kg",
                .range = config::above(0.0),
                .default_text = "from `density`"})
          .key("contact", &RigidBody::contact,
               {.about = "sticky: material moves with the surface; slip: it moves along the surface and never leaves it."})
          .key("velocity", &RigidBody::velocity, {.about = "Velocity of the centre of mass at the start.", .unit = "m/s"})
          .key("angular_velocity", &RigidBody::angular_velocity,
               {.about = "Spin about the centre of mass at the start.", .unit = "rad/s"})
          .check(check_body);
  return table;
}

void join_rigid_bodies(const config::Value& root, Scene& scene, config::Faults& faults) {
  const config::Value* const list = root.find("rigid_bodies");
  if (!list || list->items.empty()) return;
  for (const config::Value& entry : list->items) {
    scene.rigid_places.push_back(entry.place.text());
    const config::Value* const name = entry.find("name");
    for (const Collider& collider : scene.colliders)
      if (column_prefix(collider.name) == column_prefix(name->text))
        faults.add(name->place,
                   fmt::format("'{}' is \"{}\", which a collider has already: their columns in history.csv would "
                               "have the same names",
                               name->path, name->text));
  }
  if (const config::Value* const inflows = root.find("inflows"); inflows && !inflows->items.empty())
    faults.add(list->place, "'rigid_bodies' and 'inflows' cannot be in one scene yet; leave out one of the two");
  if (list->items.size() > most_bodies)
    faults.add(list->place,
               fmt::format("'rigid_bodies' has {} entries; at most {} are possible", list->items.size(), most_bodies));
  const bool is_implicit = scene.time_stepping.integrator == IntegratorKind::imex ||
                           scene.time_stepping.viscosity == ViscosityKind::implicit_stress;
  if (is_implicit)
    faults.add(list->place,
               "'rigid_bodies' needs time.integrator = \"explicit\" and explicit viscosity: the implicit systems do not "
               "contain the bodies");
}

}  // namespace bulkley
