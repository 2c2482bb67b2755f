#include "config/formula.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>

#include "bulkley/base/error.hpp"

namespace bulkley {
namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

/// More would be no formula that a person wrote; muParser's time and stack grow with the length.
constexpr std::size_t longest_formula = 4000;

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }
bool is_letter_or_digit(char c) { return is_letter(c) || std::isdigit(static_cast<unsigned char>(c)); }

/// The names that the formula assigns to, each once: names before a single `=`.
std::vector<std::string> assigned_names(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t at = 0; at < text.size();) {
    if (!is_letter_or_digit(text[at])) {
      ++at;
      continue;
    }
    const std::size_t first = at;
    while (at < text.size() && is_letter_or_digit(text[at])) ++at;
    const std::string name = text.substr(first, at - first);
    while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at]))) ++at;
    const bool is_assigned = is_letter(name[0]) && text.compare(at, 1, "=") == 0 && text.compare(at, 2, "==") != 0;
    if (is_assigned && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

/// muParser's reason as the second half of a sentence.
std::string reason_of(const mu::ParserError& error) {
  std::string reason = error.GetMsg();
  if (!reason.empty()) reason[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(reason[0])));
  while (!reason.empty() && (reason.back() == '.' || reason.back() == '!' || reason.back() == '\n')) reason.pop_back();
  return reason;
}

}  // namespace

std::string VectorFormula::words() const { return fmt::format(R"(["{}", "{}", "{}"])", text[0], text[1], text[2]); }

// The parser holds addresses of the numbers, so these never move.
struct Formula::Parts {
  mu::Parser parser;
  std::vector<double> variables;
  std::vector<double> scratch;
};

Formula::Formula(const std::string& text, const std::vector<std::string>& variables) : parts_(std::make_unique<Parts>()) {
  if (text.size() > longest_formula)
    throw UsageError(fmt::format("it has {} characters; a formula may have at most {}", text.size(), longest_formula));
  mu::Parser& parser = parts_->parser;
  try {
    const std::vector<std::string> own = assigned_names(text);
    for (const std::string& name : own)
      if (name == "x" || name == "y" || name == "z" || name == "t" || name == "pi")
        throw UsageError(fmt::format("'{}' is given and cannot be assigned", name));
    parts_->variables.assign(variables.size(), 0.0);
    parts_->scratch.assign(own.size(), undefined);
    parser.DefineConst("pi", std::numbers::pi);
    parser.DefineFun("floor", static_cast<double (*)(double)>(std::floor));
    for (std::size_t n = 0; n < variables.size(); ++n) parser.DefineVar(variables[n], &parts_->variables[n]);
    for (std::size_t n = 0; n < own.size(); ++n) parser.DefineVar(own[n], &parts_->scratch[n]);
    parser.SetExpr(text);
    parser.Eval();  // muParser finds faults as it evaluates
  } catch (const mu::ParserError& error) {
    throw UsageError(reason_of(error));
  }
}

Formula::Formula(Formula&&) noexcept = default;
Formula& Formula::operator=(Formula&&) noexcept = default;
Formula::~Formula() = default;

double Formula::operator()(const std::vector<double>& values) {
  std::copy(values.begin(), values.end(), parts_->variables.begin());
  // What an earlier evaluation has left would make the result depend on the order of particles and nodes.
  std::fill(parts_->scratch.begin(), parts_->scratch.end(), undefined);
  try {
    return parts_->parser.Eval();
  } catch (const mu::ParserError&) {
    return undefined;
  }
}

bool Formula::uses(const std::string& name) const { return parts_->parser.GetUsedVar().contains(name); }

VectorField::VectorField(const VectorFormula& formula) : values_(4) {
  for (const std::string& text : formula.text) components_.emplace_back(text, std::vector<std::string>{"x", "y", "z", "t"});
}

Vec3 VectorField::operator()(const Vec3& x, double t) {
  values_ = {x[0], x[1], x[2], t};
  return {components_[0](values_), components_[1](values_), components_[2](values_)};
}

Mat3 VectorField::gradient(const Vec3& x, double t, double step) {
  Mat3 result;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 above = x, below = x;
    above[axis] += step;
    below[axis] -= step;
    // Divided by the distance as it was rounded, which matters far from the origin.
    result.col(axis) = ((*this)(above, t) - (*this)(below, t)) / (above[axis] - below[axis]);
  }
  return result;
}

namespace config {

std::string Codec<VectorFormula>::allowed(const Rule& rule) { return fmt::format("of {}", fmt::join(rule.names, ", ")); }

bool Codec<VectorFormula>::read(const Value& value, const Rule& rule, VectorFormula& out, Faults& faults) {
  const bool three_texts =
      value.is_list() && value.items.size() == 3 &&
      std::all_of(value.items.begin(), value.items.end(), [](const Value& item) { return item.kind == Kind::text; });
  if (!three_texts) {
    faults.add(value.place,
               fmt::format("'{}' must be a list of 3 formulas as texts, such as [\"0\", \"sin(pi*x)\", \"0\"]", value.path));
    return false;
  }
  const std::size_t faults_before = faults.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Value& item = value.items[axis];
    try {
      const Formula read(item.text, rule.names);
      out.text[axis] = item.text;
    } catch (const UsageError& error) {
      faults.add(item.place, fmt::format("'{}' is no formula of {}: \"{}\": {}", item.path, fmt::join(rule.names, ", "),
                                         item.text, error.what()));
    }
  }
  return faults.size() == faults_before;
}

Value Codec<VectorFormula>::write(const VectorFormula& formula) {
  if (!formula.given()) return {};
  return write_texts({formula.text.begin(), formula.text.end()});
}

}  // namespace config
}  // namespace bulkley
