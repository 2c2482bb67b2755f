#pragma once
// The magnetic field that magnets, coils and far poles apply: what there would be without magnetic materials.

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "config/formula.hpp"
#include "geometry/rigid_motion.hpp"

namespace bulkley {

/// The same everywhere.
struct UniformField {
  VectorFormula field;  ///< A/m, formulas of t
};
struct Dipole {
  Vec3 center = Vec3::Zero();                                ///< m
  Vec3 axis = Vec3::UnitZ();                                 ///< direction of the moment, any length > 0
  double moment = std::numeric_limits<double>::quiet_NaN();  ///< A m^2
};
/// A block with a uniform magnetisation along its axis.
struct BoxMagnet {
  Vec3 center = Vec3::Zero();  ///< m
  Vec3 axis = Vec3::UnitZ();   ///< from the south to the north pole, any length > 0
  Vec3 side = Vec3::Zero();    ///< along its x; zero: see `own_axes`
  Vec3 sizes = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());  ///< m: along `side`, across both, along `axis`
  double remanence = std::numeric_limits<double>::quiet_NaN();            ///< B_r, T
};
struct CylinderMagnet {
  Vec3 center = Vec3::Zero();                                   ///< m
  Vec3 axis = Vec3::UnitZ();                                    ///< from the south to the north pole, any length > 0
  double radius = std::numeric_limits<double>::quiet_NaN();     ///< m
  double length = std::numeric_limits<double>::quiet_NaN();     ///< m
  double remanence = std::numeric_limits<double>::quiet_NaN();  ///< B_r, T
};
/// A thin ring of current, counter-clockwise about its axis.
struct Coil {
  Vec3 center = Vec3::Zero();                                 ///< m
  Vec3 axis = Vec3::UnitZ();                                  ///< any length > 0
  double radius = std::numeric_limits<double>::quiet_NaN();   ///< m
  double current = std::numeric_limits<double>::quiet_NaN();  ///< A, times the number of turns
};
/// A field without divergence and curl wherever there is magnetic material.
struct FieldFormula {
  VectorFormula field;  ///< A/m, formulas of x, y, z, t
};

/// One source: what it is, and how it changes with time.
struct FieldSource {
  std::variant<UniformField, Dipole, BoxMagnet, CylinderMagnet, Coil, FieldFormula> kind;
  std::string amplitude = "1";            ///< a factor, formula of t
  std::optional<std::string> moves_with;  ///< a collider, by name
  RigidMotion motion;                     ///< of that collider; the whole field moves and turns along
  std::string place;                      ///< "file:line:column" in the scene, for messages
};

/// Axes of a source as columns of a rotation: z along `axis`, x along the part of `side` across it; a `side` of zero means x, or y
/// where `axis` is nearer to x than 45 degrees. Precondition: `side` is not along `axis`. Not collective.
Mat3 own_axes(const Vec3& axis, const Vec3& side = Vec3::Zero());

/// The body of a box or cylinder magnet, at the place that its centre and axes give; none for other sources. Not collective.
std::optional<Shape> body_of(const FieldSource& source);

/// H_0(x, t): the sum of the sources. Inside a magnet it is B/mu_0 of that magnet; infinite or NaN on a dipole, on a thin wire and on
/// the edges of a magnet. Outside of them every source but formulas has neither divergence nor curl. Evaluations keep the last
/// time's amplitudes and poses: not safe for several threads. Move-only.
class AppliedField {
 public:
  /// Throws UsageError with the reason where an amplitude is no formula of t.
  explicit AppliedField(const std::vector<FieldSource>& sources);
  AppliedField(AppliedField&&) noexcept;
  AppliedField& operator=(AppliedField&&) noexcept;
  ~AppliedField();

  /// H_0 at the position `x` (m) and the time `t` (s), A/m. The result follows from the arguments alone. Not collective.
  Vec3 at(const Vec3& x, double t) const;
  /// Whether H_0 changes with time: a motion, or a formula with t. Not collective.
  bool varies() const;
  /// Whether some source is not at `t2` (s) what it is at `t1`; one with a formula of x, y, z and t counts as changing. Not collective.
  bool changes(double t1, double t2) const;

 private:
  struct Source;
  void set_time(double t) const;
  std::vector<std::unique_ptr<Source>> sources_;
  mutable double time_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace bulkley
