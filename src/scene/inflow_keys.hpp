#pragma once
// [[inflows]] of a scene: { name = "nozzle", section = { type = "disc", radius = 0.01 }, ... }.

#include "bulkley/config/keys.hpp"
#include "particle/inflow.hpp"

namespace bulkley {

struct Scene;

const config::Keys<DiscSection>& keys(config::Of<DiscSection>);
const config::Keys<RectangleSection>& keys(config::Of<RectangleSection>);
const config::Keys<ShapeSection>& keys(config::Of<ShapeSection>);
config::Names<FeedProfile> names(config::Of<FeedProfile>);
/// Leaves material_index, density, volume_ratio, motion and open_ends to join_inflows.
const config::Keys<Inflow>& keys(config::Of<Inflow>);

/// What inflows, materials, colliders and the integrator have to agree on. One fault a contradiction. Not collective.
void join_inflows(const config::Value& root, Scene& scene, config::Faults& faults);

namespace config {

/// A number, or a text: a formula of t.
template <>
struct Codec<TimeFormula> : PlainCodec {
  static std::string type(const Rule&) { return "number or formula"; }
  static std::string allowed(const Rule& rule) { return allowed_numbers(rule) + "; formula of t"; }
  static bool read(const Value& value, const Rule& rule, TimeFormula& out, Faults& faults);
  static Value write(const TimeFormula& formula);
};

/// A number, or "measured".
template <>
struct Codec<FeedPressure> : PlainCodec {
  static std::string type(const Rule&) { return "number or \"measured\""; }
  static std::string allowed(const Rule& rule) { return allowed_numbers(rule) + "; \"measured\""; }
  static bool read(const Value& value, const Rule& rule, FeedPressure& out, Faults& faults);
  static Value write(const FeedPressure& pressure);
};

template <>
struct Codec<Section> : PlainCodec {
  static std::string type(const Rule&) { return "section"; }
  static bool read(const Value& value, const Rule& rule, Section& out, Faults& faults);
  static Value write(const Section& section);
  static void describe(const std::string& path, std::vector<TableText>& out);
};

/// A list of lists of five numbers.
template <>
struct Codec<std::vector<FeedFrame>> : PlainCodec {
  static std::string type(const Rule&) { return "list of [t, x, y, z, e]"; }
  static bool read(const Value& value, const Rule& rule, std::vector<FeedFrame>& out, Faults& faults);
  static Value write(const std::vector<FeedFrame>& frames);
};

}  // namespace config
}  // namespace bulkley
