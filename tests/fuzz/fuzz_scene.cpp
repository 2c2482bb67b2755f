// Any bytes as a scene file: it is parsed and checked, or refused with sentences.
//
// Lines that begin with "--set " are overrides of the command line.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "bulkley/base/error.hpp"
#include "geometry/mesh_shape.hpp"
#include "scene/scene.hpp"

namespace {

using namespace bulkley;

void require(bool holds, const char* what, const std::string& text) {
  if (holds) return;
  std::fprintf(stderr, "%s:\n%s\n", what, text.c_str());
  std::abort();
}

/// Each line of a refusal says where, and prints on one line.
void require_sentences(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  int n_lines = 0;
  while (std::getline(lines, line)) {
    ++n_lines;
    const bool placed = line.starts_with("s.toml:") || line.starts_with("--set ") || line.starts_with("... and ");
    require(placed, "a sentence without a place", text);
    for (const char c : line) require(static_cast<unsigned char>(c) >= 0x20, "a control character in a sentence", text);
  }
  require(n_lines > 0 && n_lines < 200, "no sentence, or far too many", text);
}

std::size_t n_parts(const Shape& shape) {
  const auto sum = [](const std::vector<Shape>& parts) {
    std::size_t n = 1;
    for (const Shape& part : parts) n += n_parts(part);
    return n;
  };
  if (const auto* all = std::get_if<Union>(&shape.kind)) return sum(all->parts);
  if (const auto* difference = std::get_if<Difference>(&shape.kind)) return sum(difference->parts);
  if (const auto* complement = std::get_if<Complement>(&shape.kind)) return sum(complement->inside.parts);
  if (const auto* placed = std::get_if<Placed>(&shape.kind)) return 1 + n_parts(*placed->part);
  return 1;
}

/// Whether the geometry can be checked in a fraction of a second: real work is no fault, but slows a fuzzer down.
bool is_small(const Scene& scene) {
  std::size_t parts = 0;
  bool has_mesh = false;
  const auto look = [&](const Shape& shape) {
    parts += n_parts(shape);
    has_mesh = has_mesh || waits_for_mesh(shape);
  };
  for (const Body& body : scene.bodies) look(body.shape);
  for (const Collider& collider : scene.colliders) look(collider.shape);
  return scene.grid.n_tiles() < 1000 && parts < 12 && !has_mesh;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) { return 0; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream lines(std::string(reinterpret_cast<const char*>(data), size));
  std::string text, line;
  std::vector<std::string> overrides;
  while (std::getline(lines, line))
    if (line.starts_with("--set "))
      overrides.push_back(line.substr(6));
    else
      text += line + "\n";
  std::string effective;
  try {
    const Scene scene = parse_scene(text, "s.toml", overrides);
    effective = scene.effective_text;
    if (is_small(scene)) {
      check_bodies(scene);
      check_colliders(scene);
    }
  } catch (const UsageError& error) {
    require_sentences(error.what());
  }
  if (effective.empty()) return 0;
  try {
    require(parse_scene(effective, "/e.toml", {}).effective_text == effective, "the effective text is not stable",
            effective);
  } catch (const UsageError& error) {
    require(false, error.what(), effective);
  }
  return 0;
}
