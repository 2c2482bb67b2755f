#include "scene/boundary_keys.hpp"

#include <fmt/format.h>

#include "geometry/mesh_shape.hpp"
#include "scene/shape_keys.hpp"

namespace bulkley {
namespace {

using config::Faults;
using config::Value;

config::Rule friction_rule() { return {.about = "Coulomb coefficient of friction.", .range = config::at_least(0.0)}; }

/// `type = "separating"`, or several of that form: the kinds of face for which `takes` holds.
template <class Takes>
std::string kinds_with(const Takes& takes) {
  std::string text;
  for (const FaceBehaviour& row : face_table)
    if (takes(row)) text += fmt::format("{}type = \"{}\"", text.empty() ? "" : " or ", row.name);
  return text;
}
constexpr auto has_friction = [](const FaceBehaviour& row) { return row.has_friction; };
constexpr auto has_velocity = [](const FaceBehaviour& row) { return row.has_velocity; };

std::string face_meanings() {
  std::string text;
  for (const FaceBehaviour& row : face_table)
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", row.name, row.meaning);
  return text;
}

void check_faces(const Value& table, const Faces& faces, Faults& faults) {
  for (const FaceFault& fault : face_faults(faces))
    faults.add(table.find(face_names[fault.face])->place,
               fmt::format("'{}.{}{}{}' {}", table.path, face_names[fault.face], *fault.key == 0 ? "" : ".", fault.key,
                           fault.sentence));
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
  config::Names<FaceKind> result;
  for (const FaceBehaviour& row : face_table) result.emplace_back(row.name, row.kind);
  return result;
}

const config::Keys<Face>& keys(config::Of<Face>) {
  static const auto table =
      config::Keys<Face>("A face as a table, `{ type = \"separating\", friction = 0.3 }`. " + face_meanings() + ".")
          .key("type", &Face::kind, {.about = "Kind of the face.", .required = true})
          .key("friction", &Face::friction, friction_rule())
          .only_with(kinds_with(has_friction), [](const Face& face) { return has_friction(behaviour(face.kind)); })
          .key("velocity", &Face::velocity, {.about = "Velocity of the wall in its own plane.", .unit = "m/s"})
          .only_with(kinds_with(has_velocity), [](const Face& face) { return has_velocity(behaviour(face.kind)); });
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
          .check(check_faces);
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
