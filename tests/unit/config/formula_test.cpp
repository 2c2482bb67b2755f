#include "config/formula.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/scene_text.hpp"

namespace bulkley::scene_test::formula_test {
namespace {

const std::vector<std::string> position{"x", "y", "z"};

double value_of(const std::string& text, double x = 0.3) { return Formula(text, position)({x, 2.0, 5.0}); }

std::string reason(const std::string& text) {
  try {
    Formula(text, position);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(Formula, KnowsVariablesConstantsAndFunctions) {
  EXPECT_EQ(value_of("x + 10*y + 100*z"), 0.3 + 20.0 + 500.0);
  EXPECT_EQ(value_of("cos(pi)"), -1.0);
  EXPECT_DOUBLE_EQ(value_of("sin(2*pi*x)"), std::sin(2.0 * std::numbers::pi * 0.3));
  EXPECT_EQ(value_of("x > 0.5 ? 1 : 2"), 2.0);
  EXPECT_EQ(value_of("x > 0.5 ? 1 : 2", 0.6), 1.0);
  EXPECT_DOUBLE_EQ(value_of("atan2(y, x) + min(x, y) + rint(2.7) + floor(2.7)"), std::atan2(2.0, 0.3) + 0.3 + 3.0 + 2.0);
}

TEST(Formula, AssignsNamesOfItsOwn) {
  EXPECT_DOUBLE_EQ(value_of("r = sqrt(x*x + y*y), r*r"), 0.09 + 4.0);
  EXPECT_EQ(value_of("a = 1,\n a = a + y,\n a == 3 ? z : 0"), 5.0);
}

TEST(Formula, RemembersNothing) {
  // The first evaluation assigns `a` after its use; the second must not find it.
  Formula formula("a*0 + (a = x)", position);
  EXPECT_TRUE(std::isnan(formula({1.0, 0.0, 0.0})));
  EXPECT_TRUE(std::isnan(formula({1.0, 0.0, 0.0})));
}

TEST(Formula, IsNaNWithoutAValue) { EXPECT_TRUE(std::isnan(value_of("sqrt(-1)"))); }

TEST(Formula, SaysWhatIsWrong) {
  EXPECT_EQ(reason("sin(q)"), "unexpected token \"q\" found at position 4");
  EXPECT_EQ(reason("x +"), "unexpected end of expression at position 4");
  EXPECT_EQ(reason(""), "expression is empty");
  EXPECT_EQ(reason("t*x"), "unexpected token \"t\" found at position 0");
  EXPECT_EQ(reason("x = 2, x"), "'x' is given and cannot be assigned");
  EXPECT_EQ(reason("pi = 3, pi"), "'pi' is given and cannot be assigned");
  EXPECT_EQ(reason("x > 0.5 ? 1 : 2"), "");
}

TEST(VectorField, HasItsGradient) {
  VectorField field(VectorFormula{{"sin(2*x)*y", "exp(z) + t", "x*y*z"}});
  const Vec3 x(0.4, 1.2, -0.7);
  EXPECT_NEAR((field(x, 0.25) - Vec3(std::sin(0.8) * 1.2, std::exp(-0.7) + 0.25, 0.4 * 1.2 * -0.7)).norm(), 0.0, 1e-15);
  Mat3 truth;
  truth << 2.4 * std::cos(0.8), std::sin(0.8), 0.0, 0.0, 0.0, std::exp(-0.7), 1.2 * -0.7, 0.4 * -0.7, 0.4 * 1.2;
  EXPECT_LE((field.gradient(x, 0.0, 1e-5) - truth).norm(), 1e-9);
  EXPECT_LE((field.gradient(x + Vec3(0, 0, 0), 1.0, 1e-5) - truth).norm(), 1e-9);
}

const std::string fields = "velocity_field = [\"sin(pi*x)\", \"r = y*y, r\", \"0\"]\n";

TEST(SceneFormulas, AreReadAndWrittenBack) {
  const std::string text = "acceleration_field = [\"t\", \"0\", \"x > 0 ? 1 : \\\"\\\"\"]\n" + small_scene;
  EXPECT_NE(faults_of(text), "");
  const Scene scene = parsed("acceleration_field = [\"t*x\", \"0\", \"x > 0.2 ? 1 :\\n 2\"]\n" + small_scene + fields);
  EXPECT_EQ(scene.acceleration_field.text[2], "x > 0.2 ? 1 :\n 2");
  EXPECT_EQ(scene.bodies[0].velocity_field.text[1], "r = y*y, r");
  const Scene again = parse_scene(scene.effective_text, "effective.toml", {});
  EXPECT_EQ(again.effective_text, scene.effective_text);
  EXPECT_EQ(again.acceleration_field.text, scene.acceleration_field.text);
  EXPECT_EQ(again.bodies[0].velocity_field.text, scene.bodies[0].velocity_field.text);
  EXPECT_FALSE(parsed(small_scene).acceleration_field.given());
  EXPECT_FALSE(parsed(small_scene).bodies[0].velocity_field.given());
}

TEST(SceneFormulas, AreRefusedWithPlaceAndReason) {
  EXPECT_EQ(
      faults_of(small_scene + "velocity_field = [\"x\", \"sin(q)\", \"0\"]\n"),
      "s.toml:13:24: 'bodies.0.velocity_field.1' is no formula of x, y, z: \"sin(q)\": unexpected token \"q\" found at "
      "position 4");
  EXPECT_EQ(faults_of(small_scene + "velocity_field = [\"0\", \"0\", \"t\"]\n"),
            "s.toml:13:29: 'bodies.0.velocity_field.2' is no formula of x, y, z: \"t\": unexpected token \"t\" found at "
            "position 0");
  const std::string list_wanted = "must be a list of 3 formulas as texts, such as [\"0\", \"sin(pi*x)\", \"0\"]";
  EXPECT_EQ(faults_of(small_scene, {"acceleration_field=[0, 0, 1]"}),
            "--set acceleration_field=[0, 0, 1]: 'acceleration_field' " + list_wanted);
  EXPECT_EQ(faults_of(small_scene, {"acceleration_field=x"}),
            "--set acceleration_field=x: 'acceleration_field' " + list_wanted);
}

TEST(SceneFormulas, NeedAValueAtEveryParticle) {
  const Scene scene = parsed(small_scene + "velocity_field = [\"0\", \"x < 0.6 ? y : sqrt(-x)\", \"0\"]\n");
  try {
    check_bodies(scene);
    FAIL() << "a body without a velocity was accepted";
  } catch (const UsageError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find("s.toml:9:1: body 'ball' has a velocity_field without a finite value or gradient at (0.6125, "), 0u)
        << text;
  }
  EXPECT_NO_THROW(check_bodies(parsed(small_scene + fields)));
}

}  // namespace
}  // namespace bulkley::scene_test::formula_test
