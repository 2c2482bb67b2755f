#include "geometry/mesh_format.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "bulkley/base/error.hpp"

namespace bulkley::mesh_format_test {
namespace {

using enum MeshFormat;

std::string fault_of(const std::string& bytes, MeshFormat format) {
  try {
    parse_mesh(bytes, format);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

template <class Number>
std::string raw(Number number, bool is_big_endian = false) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  return is_big_endian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

std::string stl_of(std::uint32_t promised, int n_triangles) {
  std::string bytes = std::string(80, 's') + raw(promised);
  for (int t = 0; t < n_triangles; ++t) {
    for (int k = 0; k < 12; ++k) bytes += raw(0.5f * static_cast<float>(k));
    bytes += std::string(2, '\0');
  }
  return bytes;
}

std::string ply_header(const std::string& format, int n_vertices, int n_faces) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(n_vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(n_faces) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

TEST(MeshFormat, IsThatOfTheExtension) {
  EXPECT_EQ(mesh_format("a/b.OBJ"), obj);
  EXPECT_EQ(mesh_format("x.y.stl"), stl);
  EXPECT_EQ(mesh_format("x.Ply"), ply);
  EXPECT_FALSE(mesh_format("ply"));
  EXPECT_FALSE(mesh_format("a.ply.txt"));
}

TEST(MeshFormat, ObjCountsFromOneOrBackwardsAndCutsPolygons) {
  const TriangleMesh mesh =
      parse_mesh("# square\r\nv 0 0 0 1\nv +1.5e0 0 0\nv 1 1 0\r\nv 0 1 0\nvt 0 0\nf 1/1 2/1/1 3//1 4\nf -4 -3 -2\n", obj);
  ASSERT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.vertices[1], Vec3(1.5, 0.0, 0.0));
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.triangles[1], (Int3{0, 2, 3}));
  EXPECT_EQ(mesh.triangles[2], (Int3{0, 1, 2}));
}

TEST(MeshFormat, ObjSaysWhatIsWrongAndWhere) {
  EXPECT_EQ(fault_of("v 0 0 0\nv 1 2\n", obj), "cannot be read as a mesh: line 2: a number is missing");
  EXPECT_EQ(fault_of("v 0 0 1e999\n", obj), "cannot be read as a mesh: line 1: '1e999' is no number that can be used here");
  EXPECT_EQ(fault_of("v 0 0 0\nf 1 0 1\n", obj),
            "cannot be read as a mesh: line 2: vertices are counted from 1, and from -1 backwards; there is no 0");
  EXPECT_EQ(fault_of("v 0 0 0\nf 1 2 1\n", obj), "has a face with vertex 1, but only 1 vertices (the first is 0)");
  EXPECT_EQ(fault_of("v 0 0 0\nf -1 -2 -1\n", obj), "has a face with vertex -1, but only 1 vertices (the first is 0)");
  EXPECT_EQ(fault_of("v 0 0 0\nf -9223372036854775808 1 1\n", obj).substr(0, 22), "has a face with vertex");
  EXPECT_EQ(fault_of("v 0 0 0\nf\n", obj), "has faces without vertices: the file is truncated or corrupted");
  EXPECT_EQ(fault_of("hello\n", obj), "cannot be read as a mesh: it has neither vertices ('v') nor faces ('f')");
}

TEST(MeshFormat, StlBinaryIsKnownByItsSize) {
  EXPECT_EQ(parse_mesh(stl_of(2, 2), stl).triangles.size(), 2u) << "begins with 's', but has the size of a binary file";
  EXPECT_EQ(parse_mesh(stl_of(1, 1), stl).vertices.at(0), Vec3(1.5, 2.0, 2.5));
  EXPECT_EQ(parse_mesh(stl_of(1, 1) + "more", stl).triangles.size(), 1u);
  EXPECT_EQ(fault_of(stl_of(3, 2), stl),
            "cannot be read as a mesh: it is truncated: 3 triangles take 234 bytes, and it has 184");
  EXPECT_EQ(fault_of(stl_of(4294967295u, 0), stl),
            "cannot be read as a mesh: it is truncated: 4294967295 triangles take 214748364834 bytes, and it has 84");
  EXPECT_NE(fault_of("short", stl).find("neither begins with 'solid'"), std::string::npos);
}

TEST(MeshFormat, StlTextMustBeWhole) {
  const std::string facet =
      "solid a b facet\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n "
      "endloop\nendfacet\n";
  EXPECT_EQ(parse_mesh(facet + "endsolid a\n", stl).triangles.size(), 1u);
  EXPECT_EQ(fault_of(facet, stl), "cannot be read as a mesh: it is truncated: its last line is not 'endsolid'");
  EXPECT_EQ(fault_of(facet + "vertx\n", stl), "cannot be read as a mesh: line 9: 'vertx' does not belong into an STL file");
  EXPECT_EQ(fault_of("solid\nendloop\n", stl), "cannot be read as a mesh: line 2: a facet has fewer than three vertices");
}

TEST(MeshFormat, PlyOfEitherEndianness) {
  for (const bool is_big_endian : {false, true}) {
    std::string bytes = ply_header(is_big_endian ? "binary_big_endian" : "binary_little_endian", 3, 1);
    for (int k = 0; k < 9; ++k) bytes += raw(0.25f * static_cast<float>(k), is_big_endian);
    bytes += '\3' + raw(2, is_big_endian) + raw(0, is_big_endian) + raw(1, is_big_endian);
    const TriangleMesh mesh = parse_mesh(bytes, ply);
    EXPECT_EQ(mesh.vertices.at(2), Vec3(1.5, 1.75, 2.0));
    EXPECT_EQ(mesh.triangles.at(0), (Int3{2, 0, 1}));
    EXPECT_EQ(fault_of(bytes.substr(0, bytes.size() - 1), ply),
              "cannot be read as a mesh: it is truncated: its header declares more vertices or faces than follow");
  }
}

TEST(MeshFormat, PlyPassesOverWhatItDoesNotNeed) {
  const TriangleMesh mesh = parse_mesh(
      "ply\r\nformat ascii 1.0\r\ncomment a\r\nelement edge 2\r\nproperty list uchar int a\r\nelement vertex 3\r\nproperty "
      "double z\r\n"
      "property uchar red\r\nproperty double y\r\nproperty double x\r\nelement face 1\r\nproperty float q\r\n"
      "property list uint8 uint32 vertex_index\r\nend_header\r\n2 5 5\r\n0\r\n3 9 2 1\r\n6 9 5 4\r\n9 9 8 7\r\n.5 3 0 1 "
      "2\r\n",
      ply);
  EXPECT_EQ(mesh.vertices.at(1), Vec3(4.0, 5.0, 6.0));
  EXPECT_EQ(mesh.triangles.size(), 1u);
}

TEST(MeshFormat, PlySaysWhatIsWrong) {
  const std::string corners = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(fault_of(ply_header("ascii", 3, 2) + corners + "3 0 1 2\n", ply),
            "cannot be read as a mesh: it is truncated: its header declares more vertices or faces than follow");
  EXPECT_EQ(fault_of(ply_header("ascii", 3, 1) + corners + "3 0 1 3\n", ply),
            "has a face with vertex 3, but only 3 vertices (the first is 0)");
  EXPECT_EQ(fault_of(ply_header("ascii", 3, 1) + corners + "3 0 1 1.5\n", ply),
            "cannot be read as a mesh: 1.5 is no valid number of vertices or vertex index");
  EXPECT_EQ(fault_of(ply_header("ascii", 2000000000, 1) + corners, ply).substr(0, 43),
            "cannot be read as a mesh: it is truncated: ");
  EXPECT_EQ(fault_of(ply_header("ascii", 3, 1) + corners + "9000000000000000 0 1 2\n", ply).substr(0, 43),
            "cannot be read as a mesh: it is truncated: ");
  EXPECT_EQ(fault_of(ply_header("ebcdic", 3, 1), ply),
            "cannot be read as a mesh: line 2: 'ebcdic' is no format of PLY files");
  EXPECT_EQ(fault_of("ply\nformat ascii 1.0\nelement vertex 9999999999\nend_header\n", ply),
            "cannot be read as a mesh: it is truncated: its header declares 9999999999 of 'vertex'");
  EXPECT_EQ(fault_of("ply\nformat ascii 1.0\n", ply), "cannot be read as a mesh: its header has no end");
  EXPECT_EQ(fault_of("plymouth\n", ply), "cannot be read as a mesh: its first line is not 'ply'");
}

}  // namespace
}  // namespace bulkley::mesh_format_test
