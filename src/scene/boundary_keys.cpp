#include "scene/boundary_keys.hpp"

#include <fmt/format.h>

#include "geometry/mesh_shape.hpp"
#include "scene/shape_keys.hpp"

namespace bulkley {
namespace {

using config::Faults;
using config::Value;

constexpr const char* face_names[6] = {"x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"};

config::Rule friction_rule() { return {.about = "Coulomb coefficient of friction.", .range = config::at_least(0.0)}; }

/// An axis is periodic at both ends or at none.
void check_periodic_pairs(const Value& table, Faces& faces, Faults& faults) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool lower = faces[2 * axis].kind == FaceKind::periodic, upper = faces[2 * axis + 1].kind == FaceKind::periodic;
    if (lower == upper) continue;
    const char* periodic = face_names[2 * axis + (lower ? 0 : 1)];
    const char* other = face_names[2 * axis + (lower ? 1 : 0)];
    faults.add(table.find(periodic)->place,
               fmt::format("'{}.{}' is periodic but '{}' is not; an axis is periodic at both ends or at none", table.path,
                           periodic, other));
  }
}

/// A wall moves along itself only: the domain keeps its size.
void check_wall_velocities(const Value& table, Faces& faces, Faults& faults) {
  for (std::size_t f = 0; f < 6; ++f)
    if (faces[f].velocity[static_cast<Eigen::Index>(f / 2)] != 0.0)
      faults.add(table.find(face_names[f])->place,
                 fmt::format("'{}.{}.velocity' has a component along {}; a face moves only in its own plane", table.path,
                             face_names[f], "xyz"[f / 2]));
}

}  // namespace

config::Names<Contact> names(config::Of<Contact>) {
  return {{"sticky", Contact::sticky}, {"slip", Contact::slip}, {"separating", Contact::separating}};
}

std::string name(Contact contact) {
  for (const auto& [word, value] : names(config::Of<Contact>{}))
    if (value == contact) return word;
  return "unknown";
}

config::Names<FaceKind> names(config::Of<FaceKind>) {
  return {{"sticky", FaceKind::sticky},     {"slip", FaceKind::slip},       {"separating", FaceKind::separating},
          {"periodic", FaceKind::periodic}, {"outflow", FaceKind::outflow}, {"open", FaceKind::open}};
}

const config::Keys<Face>& keys(config::Of<Face>) {
  static const auto table =
      config::Keys<Face>(
          "A face as a table, `{ type = \"separating\", friction = 0.3 }`. sticky: material moves with the wall, which "
          "is at rest unless it has a `velocity`; slip: no motion through the "
          "wall; "
          "separating: material may leave the wall, with friction while it presses on it; periodic: joined to the opposite "
          "face; outflow: particles that cross it are removed and counted; open: no wall, and a particle that crosses it is "
          "an error.")
          .key("type", &Face::kind, {.about = "Kind of the face.", .required = true})
          .key("friction", &Face::friction, friction_rule())
          .only_with("type = \"separating\"", [](const Face& face) { return face.kind == FaceKind::separating; })
          .key("velocity", &Face::velocity, {.about = "Velocity of the wall in its own plane.", .unit = "m/s"})
          .only_with("type = \"sticky\"", [](const Face& face) { return face.kind == FaceKind::sticky; });
  return table;
}

const config::Keys<Faces>& keys(config::Of<Faces>) {
  static const auto table =
      config::Keys<Faces>("The six faces of the domain, each by the name of its type or as a table.")
          .key("x_lower", [](auto& f) -> auto& { return f[0]; }, {.about = "Face at the lower end of x."})
          .key("x_upper", [](auto& f) -> auto& { return f[1]; }, {.about = "Face at the upper end of x."})
          .key("y_lower", [](auto& f) -> auto& { return f[2]; }, {.about = "Face at the lower end of y."})
          .key("y_upper", [](auto& f) -> auto& { return f[3]; }, {.about = "Face at the upper end of y."})
          .key("z_lower", [](auto& f) -> auto& { return f[4]; }, {.about = "Face at the lower end of z."})
          .key("z_upper", [](auto& f) -> auto& { return f[5]; }, {.about = "Face at the upper end of z."})
          .check([](const Value& value, Faces& faces, Faults& faults) {
            check_periodic_pairs(value, faces, faults);
            check_wall_velocities(value, faces, faults);
          });
  return table;
}

const config::Keys<KeyFrame>& keys(config::Of<KeyFrame>) {
  static const auto table =
      config::Keys<KeyFrame>(
          "Pose of an obstacle at one time, relative to its shape. Between key frames it moves along smooth curves "
          "through all of them without overshoot; before the first and after the last it is at rest.")
          .key("time", &KeyFrame::time,
               {.about = "Time, later than that of the previous key frame.", .unit = "s", .required = true})
          .key("translation", &KeyFrame::translation, {.about = "Shift of `center`.", .unit = "m"})
          .key(
              "rotation", &KeyFrame::rotation_degrees,
              {.about = "Turn about `center`: a vector along the axis, its length the angle, by the right-hand rule; 720 is "
                        "two turns.",
               .unit = "degrees"});
  return table;
}

namespace {

/// Key frames are several and in order; none at all is as if there were no list.
void check_key_frames(const Value& table, const RigidMotion& motion, Faults& faults) {
  const Value* list = table.find("key_frames");
  if (!list) return;
  if (motion.key_frames.size() == 1)
    faults.add(list->place, fmt::format("'{}' must hold at least two key frames", list->path));
  for (std::size_t k = 1; k < motion.key_frames.size(); ++k)
    if (!(motion.key_frames[k].time > motion.key_frames[k - 1].time))
      faults.add(list->items[k].place,
                 fmt::format("'{}.time' is {:g} and must be later than that of the previous key frame, {:g}",
                             list->items[k].path, motion.key_frames[k].time, motion.key_frames[k - 1].time));
}

bool turns(const RigidMotion& motion) {
  for (const KeyFrame& key : motion.key_frames)
    if (!key.rotation_degrees.isZero(0.0)) return true;
  return !motion.angular_velocity.isZero(0.0);
}

/// The centre of the motion is that of the shape unless it is given.
void choose_center(const Value& table, Collider& collider, Faults& faults) {
  settle_center(collider);
  const Bounds b = bounds(collider.shape);
  const bool is_endless = !waits_for_mesh(collider.shape) && !(b.lower.allFinite() && b.upper.allFinite());
  if (!collider.center && is_endless && turns(collider.motion))
    faults.add(table.place,
               fmt::format("collider '{}' rotates and its shape has no centre; give it a 'center'", collider.name));
}

}  // namespace

const config::Keys<Collider>& keys(config::Of<Collider>) {
  const auto steady = [](const Collider& collider) { return collider.motion.key_frames.empty(); };
  static const auto table =
      config::Keys<Collider>(
          "A rigid obstacle, fixed unless it has a velocity or key frames. history.csv contains the force on it "
          "and the torque about `center`, averaged since the previous row.")
          .key("name", &Collider::name,
               {.about = "Name in messages and columns; different for each collider.", .required = true})
          .key("shape", &Collider::shape, {.about = "Initial geometry.", .required = true})
          .key("contact", &Collider::contact,
               {.about =
                    "sticky: material stops; slip: it moves along the surface; separating: it may also leave, with friction "
                    "while it presses."})
          .key("friction", &Collider::friction, friction_rule())
          .only_with("contact = \"separating\"", [](const Collider& c) { return c.contact == Contact::separating; })
          .key("velocity", [](auto& c) -> auto& { return c.motion.velocity; },
               {.about = "Steady velocity of `center`.", .unit = "m/s"})
          .only_with("no key_frames", steady)
          .key("angular_velocity", [](auto& c) -> auto& { return c.motion.angular_velocity; },
               {.about = "Steady spin about `center`.", .unit = "rad/s"})
          .only_with("no key_frames", steady)
          .key("center", &Collider::center,
               {.about = "Centre of rotation and reference point of the torque; moves with the collider.",
                .unit = "m",
                .default_text = "centre of the shape's bounds"})
          .key("key_frames", [](auto& c) -> auto& { return c.motion.key_frames; },
               {.about = "Motion, instead of steady velocities.", .default_text = "none"})
          .check([](const Value& value, Collider& collider, Faults& faults) {
            check_key_frames(value, collider.motion, faults);
            choose_center(value, collider, faults);
          });
  return table;
}

namespace config {

bool Codec<Face>::read(const Value& value, const Rule& rule, Face& out, Faults& faults) {
  out = Face{};
  if (value.is_table()) return keys(Of<Face>{}).read(value, out, faults);
  return Codec<FaceKind>::read(value, rule, out.kind, faults);
}

Value Codec<Face>::write(const Face& face) {
  const bool plain = face.friction == 0.0 && face.velocity.isZero(0.0);
  return plain ? Codec<FaceKind>::write(face.kind) : keys(Of<Face>{}).write(face);
}

void Codec<Face>::describe(const std::string&, std::vector<TableText>& out) { keys(Of<Face>{}).describe("Faces", "", out); }

}  // namespace config
}  // namespace bulkley
