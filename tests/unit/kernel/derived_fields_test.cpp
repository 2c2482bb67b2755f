#include "kernel/derived_fields.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

namespace bulkley::derived_fields_test {
namespace {

ParticleSet one_particle() {
  ParticleSet particles({Field::kirchhoff_stress}, Densities(std::array{1.0, 6.0}));
  particles.resize(1);
  const double tau[6] = {1.0, 2.0, 6.0, 0.5, 0.25, -0.5};
  for (int c = 0; c < 6; ++c) particles.real(Field::kirchhoff_stress, c)[0] = tau[c];
  particles.real(Field::volume_ratio)[0] = 2.0;
  particles.material()[0] = 1;
  particles.real(Field::reference_volume)[0] = 0.5;
  return particles;
}

std::vector<double> value_of(const std::string& name) {
  const ParticleSet particles = one_particle();
  for (const DerivedField& field : derived_fields()) {
    if (field.name != name) continue;
    std::vector<double> values(static_cast<std::size_t>(field.n_components));
    field.evaluate({particles, {}, 0, 5}, values.data());
    return values;
  }
  return {};
}

TEST(DerivedFields, Values) {
  EXPECT_EQ(value_of("pressure"), std::vector{-1.5});
  EXPECT_NEAR(value_of("deviatoric_stress").at(0), 0.5 * std::sqrt(4.0 + 1.0 + 9.0 + 2.0 * (0.25 + 0.0625 + 0.25)), 1e-14);
  EXPECT_EQ(value_of("cauchy_stress"), (std::vector{0.5, 0.25, -0.25, 0.25, 1.0, 0.125, -0.25, 0.125, 3.0}));
  EXPECT_EQ(value_of("mass"), std::vector{3.0});
  EXPECT_EQ(value_of("density"), std::vector{3.0});
  EXPECT_EQ(value_of("rank"), std::vector{5.0});
}

TEST(DerivedFields, NamesAreUniqueAlsoAmongTheStoredFields) {
  std::set<std::string> names;
  for (const FieldInfo& field : field_table) EXPECT_TRUE(names.insert(field.name).second) << field.name;
  for (const DerivedField& field : derived_fields()) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
    EXPECT_GE(field.n_components, 1);
    EXPECT_LE(field.n_components, DerivedField::most_components);
  }
}

}  // namespace
}  // namespace bulkley::derived_fields_test
