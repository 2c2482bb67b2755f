#pragma once
// Vector fields that a scene gives as formulas of the position and the time.

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "bulkley/config/codec.hpp"

namespace bulkley {

/// A vector field as a scene writes it, one formula a component; empty texts: the field is not given.
struct VectorFormula {
  std::array<std::string, 3> text;

  bool given() const { return !text[0].empty(); }
  /// The three texts in one line, for messages.
  std::string words() const;
};

/// A formula made ready to be evaluated. It knows pi, the functions of muParser, floor, and names of its own that it assigns
/// before it uses them, as in "r = sqrt(x*x + y*y), r > 0 ? y / r : 0". Move-only; not safe for several threads.
class Formula {
 public:
  /// `variables`: the names of the numbers of `operator()`, in their order: some of x, y, z, t. Throws UsageError
  /// with the reason.
  Formula(const std::string& text, const std::vector<std::string>& variables);
  Formula(Formula&&) noexcept;
  Formula& operator=(Formula&&) noexcept;
  ~Formula();

  /// NaN where the formula has no value. The result follows from `values` alone, not from earlier evaluations.
  /// Precondition: one value for each variable.
  double operator()(const std::vector<double>& values);
  /// Whether the variable `name` occurs in it.
  bool uses(const std::string& name) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// A vector field of x, y, z, and t, made ready to be evaluated.
class VectorField {
 public:
  /// Precondition: the formulas are sound, as those of a parsed scene are.
  explicit VectorField(const VectorFormula& formula);
  /// At the position `x`, m, and the time `t`, s; a component may be NaN or infinite.
  Vec3 operator()(const Vec3& x, double t);
  /// d field_i / d x_j by central differences over 2 `step` (m): relative error (k step)^2 / 6 for waves of wave number k,
  /// and the rounding of the field over `step`.
  Mat3 gradient(const Vec3& x, double t, double step);

 private:
  std::vector<Formula> components_;
  std::vector<double> values_;
};

namespace config {

/// A list of three texts. Rule::names: the variables that the formulas may use.
template <>
struct Codec<VectorFormula> : PlainCodec {
  static std::string type(const Rule&) { return "3 formulas"; }
  static std::string allowed(const Rule& rule);
  static bool read(const Value& value, const Rule& rule, VectorFormula& out, Faults& faults);
  static Value write(const VectorFormula& formula);
};

}  // namespace config
}  // namespace bulkley
