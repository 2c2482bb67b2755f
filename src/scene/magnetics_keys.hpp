#pragma once
// [magnetics] of a scene and its sources, [[magnetics.sources]]: { kind = "coil", center = [0, 0, 1], radius = 0.1, ... }.

#include "config/choice.hpp"
#include "magnetics/magnetics_settings.hpp"

namespace bulkley {

struct Scene;

const config::Keys<UniformField>& keys(config::Of<UniformField>);
const config::Keys<Dipole>& keys(config::Of<Dipole>);
const config::Keys<BoxMagnet>& keys(config::Of<BoxMagnet>);
const config::Keys<CylinderMagnet>& keys(config::Of<CylinderMagnet>);
const config::Keys<Coil>& keys(config::Of<Coil>);
const config::Keys<FieldFormula>& keys(config::Of<FieldFormula>);
const config::Keys<MagneticsSettings>& keys(config::Of<MagneticsSettings>);

config::Names<FarField> names(config::Of<FarField>);
config::Names<Mixing> names(config::Of<Mixing>);
config::Names<EdgeMean> names(config::Of<EdgeMean>);
config::Names<FieldSolver> names(config::Of<FieldSolver>);

/// What sources, materials, colliders and faces have to agree on; gives the sources the motions of their colliders. One fault a
/// contradiction. Not collective.
void join_magnetics(const config::Value& root, Scene& scene, config::Faults& faults);

namespace config {

/// A list of tables, each a kind of source with its keys and those of every source.
template <>
struct Codec<std::vector<FieldSource>> : PlainCodec {
  static std::string type(const Rule&) { return "list of tables"; }
  static bool read(const Value& value, const Rule& rule, std::vector<FieldSource>& out, Faults& faults);
  static Value write(const std::vector<FieldSource>& sources);
  static void describe(const std::string& path, std::vector<TableText>& out);
};

}  // namespace config
}  // namespace bulkley
