#pragma once
// The faces of the domain, and what each kind of face does: one row of face_table.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bulkley/base/types.hpp"

namespace bulkley {

enum class Contact {
  sticky,      ///< v = 0
  slip,        ///< no normal velocity in either direction, no friction
  separating,  ///< no normal velocity into the wall; Coulomb friction while pressed against it
};

enum class FaceKind { sticky, slip, separating, periodic, outflow, open };

/// What the nodes one cell behind a face do, seen from the frame of the wall.
enum class NodesBehind {
  free,      ///< as the material that is there
  reversed,  ///< the velocity of their mirror images, all of it reversed: no slip at the wall
  mirrored,  ///< the velocity of their mirror images, reversed along the normal only: no friction
};

/// What becomes of a particle that crosses a face.
enum class Crossing {
  held,     ///< back onto the face from up to half a cell behind it; farther off it is an error
  wraps,    ///< it enters through the opposite face, which is of the same kind
  removed,  ///< removed and counted
  refused,  ///< an error
};

/// All that a kind of face does and what keys it takes.
struct FaceBehaviour {
  FaceKind kind;
  const char* name;                ///< as scenes write it
  const char* meaning;             ///< for the reference page
  std::optional<Contact> contact;  ///< what it does to the nodes on and behind it; none: material passes
  NodesBehind behind;
  Crossing crossing;
  bool has_friction = false;  ///< takes `friction`
  bool has_velocity = false;  ///< takes `velocity`
};

inline constexpr std::array face_table = {
    FaceBehaviour{.kind = FaceKind::sticky,
                  .name = "sticky",
                  .meaning = "material moves with the wall, which is at rest unless it has a `velocity`",
                  .contact = Contact::sticky,
                  .behind = NodesBehind::reversed,
                  .crossing = Crossing::held,
                  .has_velocity = true},
    FaceBehaviour{.kind = FaceKind::slip,
                  .name = "slip",
                  .meaning = "no motion through the wall",
                  .contact = Contact::slip,
                  .behind = NodesBehind::mirrored,
                  .crossing = Crossing::held},
    FaceBehaviour{.kind = FaceKind::separating,
                  .name = "separating",
                  .meaning = "material may leave the wall, with friction while it presses on it",
                  .contact = Contact::separating,
                  .behind = NodesBehind::free,
                  .crossing = Crossing::held,
                  .has_friction = true},
    FaceBehaviour{.kind = FaceKind::periodic,
                  .name = "periodic",
                  .meaning = "joined to the opposite face",
                  .contact = std::nullopt,
                  .behind = NodesBehind::free,
                  .crossing = Crossing::wraps},
    FaceBehaviour{.kind = FaceKind::outflow,
                  .name = "outflow",
                  .meaning = "particles that cross it are removed and counted",
                  .contact = std::nullopt,
                  .behind = NodesBehind::free,
                  .crossing = Crossing::removed},
    FaceBehaviour{.kind = FaceKind::open,
                  .name = "open",
                  .meaning = "no wall, and a particle that crosses it is an error",
                  .contact = std::nullopt,
                  .behind = NodesBehind::free,
                  .crossing = Crossing::refused},
};
static_assert(
    [] {
      for (std::size_t i = 0; i < face_table.size(); ++i)
        if (face_table[i].kind != static_cast<FaceKind>(i)) return false;
      return true;
    }(),
    "face_table must be in the order of FaceKind");

/// Not collective.
constexpr const FaceBehaviour& behaviour(FaceKind kind) { return face_table[static_cast<std::size_t>(kind)]; }

/// One face of the domain, an entry of [boundaries].
struct Face {
  FaceKind kind = FaceKind::sticky;
  double friction = 0.0;         ///< Coulomb coefficient, of kinds with friction
  Vec3 velocity = Vec3::Zero();  ///< m/s, along the face, of kinds with a velocity
};

/// Faces in the order x lower, x upper, y lower, y upper, z lower, z upper.
using Faces = std::array<Face, 6>;

inline constexpr std::array<const char*, 6> face_names = {"x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"};

/// Whether particles that leave through one end of the axis enter at the other. Not collective.
constexpr bool is_periodic(const Faces& faces, std::size_t axis) {
  return behaviour(faces[2 * axis].kind).crossing == Crossing::wraps;
}

/// What is wrong with a face.
struct FaceFault {
  std::size_t face;
  const char* key;       ///< the key at fault, "" if it is the kind
  std::string sentence;  ///< "is periodic but ...", its subject being the face or the key
};

/// The rules for faces: an axis wraps at both ends or at none; friction is finite and >= 0; a face moves along itself only,
/// so that the domain keeps its size. Empty if all is well. Not collective.
std::vector<FaceFault> face_faults(const Faces& faces);

}  // namespace bulkley
