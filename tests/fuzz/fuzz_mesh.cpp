// Any bytes as an OBJ, an STL and a PLY file: triangles, and of those a solid, or a sentence.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "bulkley/base/error.hpp"
#include "geometry/mesh_format.hpp"
#include "geometry/mesh_shape.hpp"

namespace {

using namespace bulkley;

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

void try_format(std::string_view bytes, MeshFormat format) {
  try {
    TriangleMesh mesh = parse_mesh(bytes, format);
    weld_checked(mesh);
    if (mesh.triangles.size() > 300) return;  // their solid takes time, and is no other
    Mesh shape;
    shape.size = 0.2;
    shape.center = Vec3::Zero();
    const Shape solid{filled(shape, std::move(mesh))};
    const Bounds box = bounds(solid);
    require(box.lower.allFinite() && box.upper.allFinite(), "bounds that are not finite");
    for (const Vec3& x : {Vec3(0.0, 0.0, 0.0), Vec3(0.05, -0.02, 0.01), Vec3(1.0, 2.0, 3.0)})
      require(std::isfinite(signed_distance(solid, x)) && outward_normal(solid, x).allFinite(),
              "a distance that is not finite");
  } catch (const UsageError& error) {
    const std::string sentence = error.what();
    require(!sentence.empty() && sentence.size() < 400, "no sentence, or one that is far too long");
    for (const char c : sentence) require(static_cast<unsigned char>(c) >= 0x20, "a control character in a sentence");
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) { return 0; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const MeshFormat format : {MeshFormat::obj, MeshFormat::stl, MeshFormat::ply}) try_format(bytes, format);
  return 0;
}
