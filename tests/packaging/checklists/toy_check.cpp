// Uses the toys of checklists_test.py as a run would: through a scene, the kernels and the reference page.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "bulkley/base/error.hpp"
#include "kernel/cells.hpp"
#include "kernel/stress_update.hpp"
#include "kernel/derived_fields.hpp"
#include "rheometer/specimen.hpp"
#include "scene/scene.hpp"

namespace {

using namespace bulkley;

void expect(bool holds, const char* what) {
  std::printf("%s: %s\n", holds ? "ok" : "WRONG", what);
  if (!holds) std::exit(1);
}

const std::string text =
    "[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\ncell_size = 0.1\n[time]\nend = 1\n"
    "[materials.m]\nlaw = \"toy_law\"\ndensity = 1000\nbulk_modulus = 1e5\n"
    "[[bodies]]\nname = \"b\"\nmaterial = \"m\"\nshape = { type = \"sphere\", center = [0.5, 0.5, 0.5], radius = 0.2 }\n"
    "[boundaries]\nz_lower = { type = \"toy_face\", friction = 0.25, velocity = [0.5, 0, 0] }\n"
    "[output]\nfields = [\"toy_field\", \"hardening\"]\n";

std::string fault_of(const std::string& scene) {
  try {
    parse_scene(scene, "toy.toml", {});
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

std::string with(std::string scene, const std::string& old, const std::string& replacement) {
  return scene.replace(scene.find(old), old.size(), replacement);
}

void check_law(const Scene& scene) {
  const Material& material = scene.materials[0].material;
  expect(std::string(law_name(material)) == "toy_law", "the scene has the toy law");
  expect(internal_fields(scene.materials).contains(Field::hardening), "its particles have the law's variable");
  expect(characteristic_stress(material, 2.0)->total == 6.0, "the law gives its characteristic stress");
  expect(fault_of(with(text, "1e5", "-1")).find("must be greater than 0") != std::string::npos, "ranges of its keys hold");
  expect(scene.effective_text.find("shear_modulus = 10.0") != std::string::npos, "the effective scene has its default");
  const std::string page = input_reference();
  for (const char* word :
       {"law = \"toy_law\"", "`\"toy_field\"`", "`\"toy_face\"`", "toy_face: a wall with friction that slides"})
    expect(page.find(word) != std::string::npos, word);

  rheometer::Specimen specimen(material);
  specimen.advance(rheometer::Flow::simple_shear, 0.1, 1e-4);
  expect(std::fabs(specimen.read().shear_stress - 1.0) < 1e-6, "the rheometer measures mu gamma");
}

void check_field_and_face(const Scene& scene) {
  ParticleSet particles(internal_fields(scene.materials), densities_of(scene.materials));
  std::vector<TileIndex> tiles;
  for (TileIndex tile = 0; tile < scene.grid.n_tiles(); ++tile) tiles.push_back(tile);
  seed_particles(scene.grid, scene.bodies, tiles, particles);
  set_internal_variables(scene.materials[0].material, 0, particles);
  expect(particles.size() > 100 && particles.real(Field::hardening)[0] == 5.0, "variables start at their values");
  bool found = false;
  for (const DerivedField& field : derived_fields()) {
    if (std::string(field.name) != "toy_field") continue;
    double value = 0.0;
    field.evaluate({particles, {}, 0, 0}, &value);
    found = value == 2.0 * particles.mass(0);
  }
  expect(found, "the toy field has its value");

  expect(fault_of(with(text, "[0.5, 0, 0] }", "[0, 0, 1] }")).find("z_lower.velocity' has a component along z") !=
             std::string::npos,
         "the rules for faces hold for the toy face");
  expect(fault_of(with(text, "\"toy_face\"", "\"slip\"")).find("toy_face") != std::string::npos,
         "a key that another kind does not take names the kinds that do");
  const auto constraints = node_constraints(scene.grid, scene.faces, {}, {{5, 5, scene.grid.node_offset(2)}});
  expect(constraints.size() == 1 && constraints[0].friction == 0.25 && constraints[0].velocity[0] == 0.5,
         "nodes on the toy face feel it");
  particles.real(Field::position, 2)[0] = -0.01;
  std::vector<LocalIndex> removed;
  StepBounds bounds;
  confine(scene.grid, scene.faces, particles, removed, bounds);
  expect(particles.real(Field::position, 2)[0] == 0.0 && !bounds.failed(), "a particle behind the toy face is put back");
}

}  // namespace

int main() {
  try {
    const Scene scene = parse_scene(text, "toy.toml", {});
    check_bodies(scene);
    check_law(scene);
    check_field_and_face(scene);
  } catch (const std::exception& error) {
    std::printf("WRONG: %s\n", error.what());
    return 1;
  }
  return 0;
}
