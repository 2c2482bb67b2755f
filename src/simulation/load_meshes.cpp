#include "simulation/load_meshes.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "geometry/builtin_mesh.hpp"
#include "geometry/mesh_shape.hpp"
#include "io/files/mesh_file.hpp"
#include "parallel/gather.hpp"
#include "particle/feed_frames.hpp"

namespace bulkley {

namespace {

struct ReadMesh {
  TriangleMesh triangles;
  WeldCount welded;
};

/// Runs `work`; the mesh's place and file precede the sentence that it throws.
void naming(const Mesh& mesh, const std::function<void()>& work) {
  try {
    work();
  } catch (const UsageError& error) {
    throw UsageError(fmt::format("{}{}mesh '{}' {}", mesh.place, mesh.place.empty() ? "" : ": ", mesh.file, error.what()));
  }
}

ReadMesh read(const Mesh& mesh) {
  const std::string prefix = builtin_prefix;
  ReadMesh result;
  result.triangles =
      mesh.file.starts_with(prefix) ? builtin_mesh(mesh.file.substr(prefix.size())) : read_mesh_file(mesh.file);
  result.welded = weld_checked(result.triangles);
  return result;
}

void broadcast(const Comm& comm, ReadMesh& mesh) {
  std::vector<GlobalIndex> sizes = {
      static_cast<GlobalIndex>(mesh.triangles.vertices.size()), static_cast<GlobalIndex>(mesh.triangles.triangles.size()),
      static_cast<GlobalIndex>(mesh.welded.vertices), static_cast<GlobalIndex>(mesh.welded.degenerate),
      static_cast<GlobalIndex>(mesh.welded.duplicates)};
  broadcast_values(comm, sizes);
  const auto size = [&](std::size_t n) { return static_cast<std::size_t>(sizes[n]); };
  mesh.welded = {size(2), size(3), size(4)};
  mesh.triangles.vertices.resize(size(0));
  mesh.triangles.triangles.resize(size(1));
  broadcast_values(comm, mesh.triangles.vertices);
  broadcast_values(comm, mesh.triangles.triangles);
}

/// The rows of an inflow's file of key frames, on every rank.
std::vector<FeedFrame> read_key_frames(const Comm& comm, const Inflow& inflow) {
  std::vector<double> numbers;
  root_guard(comm, [&] {
    const std::string owner =
        fmt::format("{}: inflow '{}': key_frames_file '{}' ", inflow.place, inflow.name, inflow.key_frames_file);
    std::error_code ignored;
    std::ifstream stream(inflow.key_frames_file);
    if (std::filesystem::is_directory(inflow.key_frames_file, ignored) || !stream)
      throw UsageError(owner + "cannot be opened");
    std::ostringstream text;
    text << stream.rdbuf();
    std::vector<FeedFrame> frames;
    try {
      frames = parse_key_frames(text.str());
    } catch (const UsageError& error) {
      throw UsageError(owner + error.what());
    }
    if (const std::string fault = key_frames_fault(frames); !fault.empty()) throw UsageError(owner + fault);
    for (const FeedFrame& f : frames)
      numbers.insert(numbers.end(), {f.time, f.position[0], f.position[1], f.position[2], f.volume});
  });
  std::vector<GlobalIndex> size{static_cast<GlobalIndex>(numbers.size())};
  broadcast_values(comm, size);
  numbers.resize(static_cast<std::size_t>(size[0]));
  broadcast_values(comm, numbers);
  std::vector<FeedFrame> frames;
  for (std::size_t n = 0; n < numbers.size(); n += 5)
    frames.push_back({numbers[n], {numbers[n + 1], numbers[n + 2], numbers[n + 3]}, numbers[n + 4]});
  return frames;
}

/// The motions of the colliders that carry inflows, once their centres are known.
void settle_motions(Scene& scene) {
  for (Inflow& inflow : scene.inflows)
    for (const Collider& collider : scene.colliders)
      if (inflow.moves_with == collider.name) inflow.motion = collider.motion;
}

}  // namespace

void load_meshes(const Comm& comm, Scene& scene, MeshesOf which) {
  std::map<std::string, ReadMesh> files;
  const auto fill = [&](const Mesh& mesh) {
    const auto [entry, is_new] = files.try_emplace(mesh.file);
    if (is_new) {
      root_guard(comm, [&] { naming(mesh, [&] { entry->second = read(mesh); }); });
      broadcast(comm, entry->second);
    }
    Mesh result = mesh;
    result.welded = entry->second.welded;
    naming(mesh, [&] { result = filled(result, entry->second.triangles); });
    return result;
  };
  if (which == MeshesOf::everything)
    for (Body& body : scene.bodies) body.shape = with_meshes(body.shape, fill);
  for (RigidBody& body : scene.rigid_bodies) body.shape = with_meshes(body.shape, fill);
  for (Collider& collider : scene.colliders) {
    collider.shape = with_meshes(collider.shape, fill);
    settle_center(collider);
  }
  for (Inflow& inflow : scene.inflows)
    if (auto* section = std::get_if<ShapeSection>(&inflow.section)) section->shape = with_meshes(section->shape, fill);
  settle_motions(scene);
  for (Inflow& inflow : scene.inflows)
    if (!inflow.key_frames_file.empty()) inflow.key_frames = read_key_frames(comm, inflow);
}

}  // namespace bulkley
