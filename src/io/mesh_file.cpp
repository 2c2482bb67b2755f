#include "bulkley/io/mesh_file.hpp"

#include <assimp/scene.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

namespace fs = std::filesystem;

void check_readable(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw UsageError("does not exist");
  if (fs::is_directory(path, error)) throw UsageError("is a folder, not a file");
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
  if (extension != ".obj" && extension != ".stl" && extension != ".ply")
    throw UsageError("is none of the formats .obj, .stl and .ply");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw UsageError("cannot be opened");
  if (stream.peek() == std::ifstream::traits_type::eof()) throw UsageError("is empty");
}

/// Refuses an ASCII PLY file with fewer lines than its header promises elements: the reader makes up what is missing.
void check_lines(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string line;
  if (!std::getline(stream, line) || !line.starts_with("ply")) return;
  bool is_ascii = false;
  std::size_t n_elements = 0, n_lines = 0;
  while (std::getline(stream, line) && !line.starts_with("end_header")) {
    is_ascii = is_ascii || line.starts_with("format ascii");
    if (line.starts_with("element ")) n_elements += std::strtoull(line.c_str() + line.find_last_of(' '), nullptr, 10);
  }
  if (!is_ascii) return;
  while (n_lines < n_elements && std::getline(stream, line))
    if (line.find_first_not_of(" \t\r") != std::string::npos) ++n_lines;
  if (n_lines < n_elements)
    throw UsageError(fmt::format("holds only {} of its {} vertices and faces: the file is cut off", n_lines, n_elements));
}

/// The first line, which is all that fits into a sentence.
std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// A polygon as a fan about the corner from which no triangle of it folds over; about the first if there is none.
std::size_t fan_corner(const TriangleMesh& mesh, const std::vector<int>& corners) {
  const std::size_t n = corners.size();
  const auto at = [&](std::size_t c) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(corners[c % n])]; };
  Vec3 area = Vec3::Zero();
  for (std::size_t c = 1; c + 1 < n; ++c) area += (at(c) - at(0)).cross(at(c + 1) - at(0));
  for (std::size_t start = 0; start < n; ++start) {
    bool folds = false;
    for (std::size_t c = 1; c + 1 < n; ++c)
      folds = folds || (at(start + c) - at(start)).cross(at(start + c + 1) - at(start)).dot(area) < 0.0;
    if (!folds) return start;
  }
  return 0;
}

void add_polygon(const std::vector<int>& corners, TriangleMesh& mesh) {
  const std::size_t n = corners.size();
  const std::size_t start = n > 3 ? fan_corner(mesh, corners) : 0;
  for (std::size_t c = 1; c + 1 < n; ++c)
    mesh.triangles.push_back({corners[start], corners[(start + c) % n], corners[(start + c + 1) % n]});
}

void append(const aiMesh& part, TriangleMesh& mesh) {
  const std::size_t before = mesh.vertices.size();
  if (before + part.mNumVertices > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw UsageError("has more vertices than an index can count");
  for (unsigned v = 0; v < part.mNumVertices; ++v)
    mesh.vertices.emplace_back(part.mVertices[v].x, part.mVertices[v].y, part.mVertices[v].z);
  std::vector<int> corners;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices == 0) throw UsageError("has faces without vertices: the file is cut off or spoilt");
    corners.clear();
    for (unsigned c = 0; c < face.mNumIndices; ++c) {
      if (face.mIndices[c] >= part.mNumVertices)
        throw UsageError(fmt::format("has a face with vertex {}, but only {} vertices (the first is 0)", face.mIndices[c],
                                     part.mNumVertices));
      corners.push_back(static_cast<int>(before + face.mIndices[c]));
    }
    add_polygon(corners, mesh);
  }
}

}  // namespace

TriangleMesh read_mesh_file(const std::string& path) {
  check_readable(path);
  check_lines(path);
  Assimp::Importer importer;
  TriangleMesh mesh;
  const aiScene* scene = nullptr;
  try {
    scene = importer.ReadFile(path, 0);  // as it stands: no axes turned, no vertices moved
  } catch (const std::exception& error) {
    throw UsageError(fmt::format("cannot be read as a mesh: {}", first_line(error.what())));
  }
  if (!scene) throw UsageError(fmt::format("cannot be read as a mesh: {}", first_line(importer.GetErrorString())));
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) append(*scene->mMeshes[m], mesh);
  return mesh;
}

}  // namespace bulkley
