#include "io/frames/collider_surfaces.hpp"

#include <algorithm>
#include <cstring>
#include <memory>

#include "geometry/surface.hpp"
#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

ArrayType stored_as(float) { return ArrayType::float32; }
ArrayType stored_as(double) { return ArrayType::float64; }
ArrayType stored_as(std::int32_t) { return ArrayType::int32; }

/// An array that the root writes; `values` row by row. Rows have the shape `row`; none: one number.
template <class Number>
Array root_array(const Comm& comm, const std::string& path, const Extents& row, std::vector<Number> values,
                 const std::string& unit, const std::string& meaning) {
  const GlobalIndex width = n_elements(row), n = static_cast<GlobalIndex>(values.size()) / width;
  Array array;
  array.path = path;
  array.type = stored_as(Number{});
  array.shape = {n};
  array.shape.insert(array.shape.end(), row.begin(), row.end());
  array.start = Extents(array.shape.size(), 0);
  array.count = array.shape;
  if (!comm.is_root()) array.count[0] = 0;
  array.unit = unit;
  array.meaning = meaning;
  array.fill = [width, shared = std::make_shared<const std::vector<Number>>(std::move(values))](
                   GlobalIndex first, GlobalIndex rows, std::byte* out) {
    std::memcpy(out, shared->data() + first * width, static_cast<std::size_t>(rows * width) * sizeof(Number));
  };
  return array;
}

std::vector<float> coordinates(const std::vector<Vec3>& points) {
  std::vector<float> values;
  values.reserve(3 * points.size());
  for (const Vec3& x : points)
    for (int axis = 0; axis < 3; ++axis) values.push_back(static_cast<float>(x[axis]));
  return values;
}

Array vertex_array(const Comm& comm, const std::vector<Vec3>& vertices) {
  return root_array(comm, "/colliders/vertices", {3}, coordinates(vertices), "m", "corners of the triangles");
}

}  // namespace

ColliderSurfaces::ColliderSurfaces(const std::vector<Collider>& colliders, const std::vector<RigidBody>& bodies,
                                   const Bounds& window)
    : body_poses_(bodies.size()), moves_(!bodies.empty()) {
  for (const Collider& collider : colliders) {
    add(collider.name, collider.shape, window);
    motions_.push_back(collider.motion);
    moves_ = moves_ || collider.motion.moves();
  }
  for (const RigidBody& body : bodies) add(body.name, body.shape, window);
  first_vertex_.push_back(static_cast<int>(vertices_.size()));
}

void ColliderSurfaces::add(const std::string& name, const Shape& shape, const Bounds& window) {
  const TriangleMesh mesh = surface_of(shape, window);
  const int first = static_cast<int>(vertices_.size());
  const auto owner = static_cast<std::int32_t>(names_.size());
  names_.push_back(name);
  first_vertex_.push_back(first);
  vertices_.insert(vertices_.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (const Int3& t : mesh.triangles) triangles_.push_back({t[0] + first, t[1] + first, t[2] + first});
  owner_.insert(owner_.end(), mesh.triangles.size(), owner);
}

std::vector<Pose> ColliderSurfaces::poses_at(double time) const {
  std::vector<Pose> poses;
  for (const RigidMotion& motion : motions_) poses.push_back(motion.pose(time));
  poses.insert(poses.end(), body_poses_.begin(), body_poses_.end());
  return poses;
}

std::vector<Vec3> ColliderSurfaces::vertices_at(double time) const {
  std::vector<Vec3> moved = vertices_;
  const std::vector<Pose> poses = poses_at(time);
  for (std::size_t c = 0; c < poses.size(); ++c) {
    if (c < motions_.size() && !motions_[c].moves()) continue;
    for (int v = first_vertex_[c]; v < first_vertex_[c + 1]; ++v) moved[v] = poses[c].to_world(vertices_[v]);
  }
  return moved;
}

void ColliderSurfaces::write(const Comm& comm, const std::string& folder) const {
  const std::string path = path_in(folder, collider_file);
  if (triangles_.empty()) {
    root_guard(comm, [&] { remove_file(path); });
    return;
  }
  std::vector<std::int32_t> corners;
  corners.reserve(3 * triangles_.size());
  for (const Int3& t : triangles_) corners.insert(corners.end(), t.begin(), t.end());
  FileContent content{collider_format, collider_version, {}, {}, 0};
  content.attributes = {
      {"/colliders", "names", join_lines(names_)},
      {"/colliders", "about", std::string("surfaces where the scene file puts them; frames have the poses")}};
  content.arrays = {vertex_array(comm, vertices_),
                    root_array(comm, "/colliders/triangles", {3}, std::move(corners), "1",
                               "corners, as rows of vertices, counter-clockwise from outside"),
                    root_array(comm, "/colliders/collider", {}, owner_, "1", "which collider a triangle belongs to")};
  write_array_file(comm, path, content);
}

void ColliderSurfaces::add_to_frame(const Comm& comm, double time, FileContent& content) const {
  if (triangles_.empty()) return;
  std::vector<double> rotation, translation;
  for (const Pose& pose : poses_at(time)) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) rotation.push_back(pose.rotation(row, column));
      translation.push_back(pose.translation[row]);
    }
  }
  content.attributes.push_back({"/colliders", "names", join_lines(names_)});
  content.arrays.push_back(root_array(comm, "/colliders/rotation", {3, 3}, std::move(rotation), "1",
                                      "x = rotation X + translation, X in the scene file"));
  content.arrays.push_back(root_array(comm, "/colliders/translation", {3}, std::move(translation), "m", "see rotation"));
  if (moves_) content.arrays.push_back(vertex_array(comm, vertices_at(time)));
}

}  // namespace bulkley
