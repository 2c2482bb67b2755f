#include "scene/body_keys.hpp"

#include "geometry/mesh_shape.hpp"
#include "scene/shape_keys.hpp"

namespace bulkley {

config::Names<SeedingLattice> names(config::Of<SeedingLattice>) {
  return {{"regular", SeedingLattice::regular}, {"jittered", SeedingLattice::jittered}};
}

const config::Keys<Body>& keys(config::Of<Body>) {
  static const auto table =
      config::Keys<Body>(
          "One piece of material at the start. Where bodies overlap (see `allow_overlap`) the first one takes precedence.")
          .key("name", &Body::name, {.about = "Name in messages; different for each body.", .required = true})
          .key("material", &Body::material, {.about = "Name of an entry of [materials].", .required = true})
          .key("shape", &Body::shape, {.about = "Initial geometry; no plane, no complement.", .required = true})
          .key("velocity", &Body::velocity, {.about = "Initial velocity.", .unit = "m/s"})
          .key("angular_velocity", &Body::angular_velocity,
               {.about = "Initial angular velocity about `center`.", .unit = "rad/s"})
          .key("center", &Body::center,
               {.about = "Centre of the initial rotation.", .unit = "m", .default_text = "centre of the shape's bounds"})
          .key("velocity_field", &Body::velocity_field,
               {.about = "Initial velocity as formulas of the position in m, added to `velocity` and rotation.",
                .unit = "m/s",
                .names = {"x", "y", "z"},
                .default_text = "none"})
          .key("particles_per_cell", &Body::particles_per_cell,
               {.about = "Particles in a full grid cell: a lattice of 1, 2, 3 or 4 along each axis; a plane flow has one layer of it.",
                .choices = {1, 8, 27, 64}})
          .key("lattice", &Body::lattice, {.about = "Whether particles are placed on the lattice or shifted at random."})
          .key("seed", &Body::seed, {.about = "Seed of the random shifts.", .range = config::at_least(0.0)})
          .only_with("lattice = \"jittered\"", [](const Body& body) { return body.lattice == SeedingLattice::jittered; })
          .check([](const config::Value& value, Body& body, config::Faults& faults) {
            if (waits_for_mesh(body.shape)) return;  // checked after it is read
            const Bounds b = bounds(body.shape);
            if (!b.lower.allFinite() || !b.upper.allFinite())
              faults.add(value.find("shape")->place, "'" + value.path + ".shape' of body '" + body.name +
                                                         "' contains a plane or complement, which is for colliders only");
            else if (!value.find("center"))
              body.center = b.center();
          });
  return table;
}

}  // namespace bulkley
