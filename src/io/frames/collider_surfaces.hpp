#pragma once
// Surfaces of the colliders, so that pictures show them.
//
// colliders.h5 holds /colliders of a run: vertices, triangles, and the collider that each triangle belongs to, where the
// scene file puts them. Each frame has where they are: /colliders/rotation and /colliders/translation (a point X of the
// scene is at rotation X + translation), and, where any collider moves, all vertices moved: no transform in XDMF works in
// both of ParaView's readers. FrameSeries lists them in colliders.xdmf.

#include <string>
#include <vector>

#include "grid/rigid_body.hpp"
#include "io/arrays/array_file.hpp"

namespace bulkley {

inline constexpr const char* collider_file = "colliders.h5";
inline constexpr const char* collider_format = "bulkley colliders";
inline constexpr GlobalIndex collider_version = 1;

/// All surfaces in one mesh; the same on every rank.
class ColliderSurfaces {
 public:
  ColliderSurfaces() = default;
  /// `window`: where planes and the like are drawn (surface_of). Not collective.
  /// Rigid bodies follow the colliders.
  ColliderSurfaces(const std::vector<Collider>& colliders, const std::vector<RigidBody>& bodies, const Bounds& window);

  bool empty() const { return names_.empty(); }
  bool moves() const { return moves_; }

  /// Where the rigid bodies are in the frames to come. Precondition: one for each. Not collective.
  void set_body_poses(std::vector<Pose> poses) { body_poses_ = std::move(poses); }

  /// Writes colliders.h5 to `folder`; removes an earlier one where there are no colliders. Throws RunError. Collective.
  void write(const Comm& comm, const std::string& folder) const;
  /// Adds /colliders as they are at `time` (s) to a frame. The arrays refer to this object.
  void add_to_frame(const Comm& comm, double time, FileContent& content) const;

 private:
  void add(const std::string& name, const Shape& shape, const Bounds& window);
  std::vector<Pose> poses_at(double time) const;
  std::vector<Vec3> vertices_at(double time) const;

  std::vector<std::string> names_;
  std::vector<RigidMotion> motions_;  ///< of the colliders
  std::vector<Pose> body_poses_;
  std::vector<Vec3> vertices_;       ///< m, where the scene file puts them
  std::vector<int> first_vertex_;    ///< of each collider, and one past the last
  std::vector<Int3> triangles_;      ///< indices of vertices
  std::vector<std::int32_t> owner_;  ///< the collider of each triangle
  bool moves_ = false;
};

}  // namespace bulkley
