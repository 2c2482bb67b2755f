#pragma once
// The scene that the tests of every key start from, and what makes each table of the reference page apply in it.

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace bulkley::scene_test {

inline const std::string base = R"(
title = "base"
[domain]
lower = [0, 0, 0]
upper = [0.16, 0.16, 0.16]
cell_size = 0.02
[time]
end = 1
[transfer]
scheme = "apic"
[materials.fluid]
preset = "cream"
[[bodies]]
name = "ball"
material = "fluid"
shape = { type = "sphere", center = [0.08, 0.08, 0.08], radius = 0.03 }
[[colliders]]
name = "rod"
shape = { type = "capsule", start = [0.02, 0.08, 0.08], end = [0.02, 0.08, 0.1], radius = 0.04 }
[boundaries]
x_lower = "slip"
[output]
grid = false
[checkpoint]
keep = 2
[partition]
method = "auto"
)";

inline const std::string solid = "density = 900, bulk_modulus = 2e5, shear_modulus = 1e5";

/// Assignments that make the section's table, the last being the table that holds its keys.
inline std::vector<std::pair<std::string, std::string>> setting(const std::string& section) {
  const auto law = [](const std::string& more) { return std::pair<std::string, std::string>("materials.fluid", more); };
  const auto shape = [](const std::string& s) { return std::pair<std::string, std::string>("colliders.0.shape", s); };
  const std::string uniform = "kind = \"uniform\", field = [\"0\", \"0\", \"1e4\"]";
  const auto magnet = [](const std::string& source, const std::string& table = "magnetics.sources.0") {
    return std::vector<std::pair<std::string, std::string>>{
        {"materials.fluid.magnetic", "{ law = \"linear\", susceptibility = 1 }"},
        {"magnetics", "{ largest_interval = 0.1, sources = [{ " + source + " }] }"},
        {table, ""}};
  };
  const auto inflow = [](const std::string& shape_text, const std::string& table) {
    return std::vector<std::pair<std::string, std::string>>{
        {"inflows", "[{ name = \"nozzle\", material = \"fluid\", position = [0.12, 0.12, 0.06], speed = 0.1, section = " +
                        shape_text + " }]"},
        {table, ""}};
  };
  const std::string ball = "{ type = \"sphere\", center = [0.08, 0.08, 0.08], radius = 0.06 }";
  const std::string small = "{ type = \"sphere\", center = [0.08, 0.08, 0.08], radius = 0.01 }";
  const std::map<std::string, std::vector<std::pair<std::string, std::string>>> contexts = {
      {"Top level", {{"", ""}}},
      {"[domain]", {{"domain", ""}}},
      {"[time]", {{"time", ""}}},
      {"[time.pressure]", {{"time.integrator", "\"imex\""}, {"time.pressure", "{}"}, {"time.pressure", ""}}},
      {"[time.viscous]",
       {{"time.integrator", "\"imex\""}, {"time.viscosity", "\"implicit\""}, {"time.viscous", "{}"}, {"time.viscous", ""}}},
      {"[transfer]", {{"transfer", ""}}},
      {"[materials.NAME]", {law("{ }")}},
      {"[materials.NAME], law = \"neo_hookean\"", {law("{ law = \"neo_hookean\", " + solid + " }")}},
      {"[materials.NAME], law = \"hencky\"", {law("{ law = \"hencky\", " + solid + " }")}},
      {"[materials.NAME], law = \"fixed_corotated\"", {law("{ law = \"fixed_corotated\", " + solid + " }")}},
      {"[materials.NAME], law = \"herschel_bulkley\"",
       {law("{ law = \"herschel_bulkley\", " + solid + ", sigma_Y = 30, eta = 20, h = 0.4 }")}},
      {"[materials.NAME], law = \"newtonian\"",
       {law("{ law = \"newtonian\", density = 900, bulk_modulus = 2e5, viscosity = 0.1 }")}},
      {"[materials.NAME], law = \"oldroyd_b\"", {law("{ law = \"oldroyd_b\", " + solid + ", relaxation_time = 0.1 }")}},
      {"[materials.NAME], law = \"finite_viscoelastic\"",
       {law("{ law = \"finite_viscoelastic\", " + solid + ", branch_shear_modulus = 1e4, relaxation_time = 0.1 }")}},
      {"[materials.NAME], law = \"thixotropic_herschel_bulkley\"",
       {law("{ law = \"thixotropic_herschel_bulkley\", " + solid +
            ", sigma_Y = 30, eta = 20, h = 0.4, build_up = 0.1, breakdown = 0.2 }")}},
      {"[materials.NAME], law = \"drucker_prager\"",
       {law("{ law = \"drucker_prager\", " + solid + ", friction_angle = 30 }")}},
      {"[materials.NAME], law = \"snow\"",
       {law("{ law = \"snow\", " + solid + ", critical_compression = 0.02, critical_stretch = 0.01, hardening = 8 }")}},
      {"[materials.NAME.magnetic]",
       {{"materials.fluid.magnetic",
         "{law=\"langevin\", susceptibility=1, saturation=9, yield=\"tanh\", yield_saturation=9, yield_field=9}"},
        {"magnetics", "{ sources = [{ " + uniform + " }] }"},
        {"materials.fluid.magnetic", ""}}},
      {"[magnetics]", magnet(uniform, "magnetics")},
      {"[[magnetics.sources]], kind = \"uniform\"", magnet(uniform)},
      {"[[magnetics.sources]], kind = \"dipole\"", magnet("kind = \"dipole\", center = [1, 1, 1], moment = 9")},
      {"[[magnetics.sources]], kind = \"box_magnet\"",
       magnet("kind = \"box_magnet\", center = [1, 1, 1], sizes = [0.1, 0.1, 0.1], remanence = 1")},
      {"[[magnetics.sources]], kind = \"cylinder_magnet\"",
       magnet("kind = \"cylinder_magnet\", center = [1, 1, 1], radius = 0.1, length = 0.1, remanence = 1")},
      {"[[magnetics.sources]], kind = \"coil\"", magnet("kind = \"coil\", center = [1, 1, 1], radius = 0.1, current = 9")},
      {"[[magnetics.sources]], kind = \"formula\"", magnet("kind = \"formula\", field = [\"0\", \"0\", \"1e4\"]")},
      {"[[magnetics.sources]], any kind", magnet(uniform)},
      {"[[bodies]]", {{"bodies.0", ""}}},
      {"[[colliders]]", {{"colliders.0", ""}}},
      {"[[colliders.key_frames]]",
       {{"colliders.0.key_frames", "[{ time = 0.1 }, { time = 0.2 }]"}, {"colliders.0.key_frames.1", ""}}},
      {"[[rigid_bodies]]",
       {{"rigid_bodies",
         "[{ name = 'weight', density = 7800, shape = { type = 'sphere', center = [0.12, 0.12, 0.03], radius = 0.025 } }]"},
        {"rigid_bodies.0", ""}}},
      {"[[inflows]]", inflow("{ type = \"disc\", radius = 0.02 }", "inflows.0")},
      {"Sections, type = \"disc\"", inflow("{ type = \"disc\", radius = 0.02 }", "inflows.0.section")},
      {"Sections, type = \"rectangle\"",
       inflow("{ type = \"rectangle\", width = 0.02, height = 0.02 }", "inflows.0.section")},
      {"Sections, type = \"shape\"",
       inflow("{ type = \"shape\", shape = { type = \"box\", lower = [-0.02, -0.02, -0.02], upper = "
              "[0.02, 0.02, 0.02] } }",
              "inflows.0.section")},
      {"Shapes, type = \"box\"", {shape("{ type = \"box\", lower = [0.02, 0.02, 0.02], upper = [0.12, 0.12, 0.12] }")}},
      {"Shapes, type = \"sphere\"", {shape(ball)}},
      {"Shapes, type = \"cylinder\"",
       {shape("{ type = \"cylinder\", start = [0.02, 0.02, 0.02], end = [0.1, 0.1, 0.1], radius = 0.04 }")}},
      {"Shapes, type = \"capsule\"",
       {shape("{ type = \"capsule\", start = [0.02, 0.02, 0.02], end = [0.1, 0.1, 0.1], radius = 0.04 }")}},
      {"Shapes, type = \"ellipsoid\"",
       {shape("{ type = \"ellipsoid\", center = [0.1, 0.1, 0.1], radii = [0.05, 0.06, 0.07] }")}},
      {"Shapes, type = \"plane\"", {shape("{ type = \"plane\", point = [0, 0, 0.05], normal = [0, 0, 1] }")}},
      {"Shapes, type = \"mesh\"", {shape("{ type = \"mesh\", file = \"builtin:hare\" }")}},
      {"Shapes, type = \"union\"", {shape("{ type = \"union\", parts = [" + ball + "] }")}},
      {"Shapes, type = \"difference\"", {shape("{ type = \"difference\", parts = [" + ball + ", " + small + "] }")}},
      {"Shapes, type = \"complement\"", {shape("{ type = \"complement\", parts = [" + ball + "] }")}},
      {"Shapes, any type", {shape(ball)}},
      {"[shape.rotation]", {{"colliders.0.shape.rotation", "{ angle = 30 }"}}},
      {"[boundaries]", {{"boundaries", ""}}},
      {"Faces", {{"boundaries.z_lower", "{ type = \"slip\" }"}}},
      {"[output]", {{"output", ""}}},
      {"[[output.front]]",
       {{"output.front", "[{ name = \"tip\", direction = [1, 0, 0], eye = [0, 0, 9] }]"}, {"output.front.0", ""}}},
      {"[[output.gauge]]", {{"output.gauge", "[{ name = \"p1\", face = \"x_lower\" }]"}, {"output.gauge.0", ""}}},
      {"[checkpoint]", {{"checkpoint", ""}}},
      {"[partition]", {{"partition", ""}}}};
  const auto found = contexts.find(section);
  return found == contexts.end() ? std::vector<std::pair<std::string, std::string>>{} : found->second;
}

}  // namespace bulkley::scene_test
