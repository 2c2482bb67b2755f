#include "bulkley/config/keys.hpp"

#include <gtest/gtest.h>

#include "bulkley/base/error.hpp"
#include "config/choice.hpp"

namespace bulkley::config_test::keys_test {

enum class Mode { calm, wild };
struct Gust {
  double strength = 1.0;
};
struct Wind {
  double speed = 2.5;
  int layers = 3;
  std::uint8_t small = 7;
  Mode mode = Mode::calm;
  Vec3 direction = Vec3::UnitX();
  std::string name;
  double pause = 60.0;
  double ratio = 0.5;
  std::vector<Gust> gusts;
};
struct Ball {
  double radius = 0.0;
};
struct Cube {
  double edge = 0.0;
};
using Solid = std::variant<Ball, Cube>;

config::Names<Mode> names(config::Of<Mode>) { return {{"calm", Mode::calm}, {"wild", Mode::wild}}; }

const config::Keys<Gust>& keys(config::Of<Gust>) {
  static const auto table =
      config::Keys<Gust>("A gust.").key("strength", &Gust::strength, {.about = "How hard.", .unit = "Pa", .required = true});
  return table;
}

const config::Keys<Wind>& keys(config::Of<Wind>) {
  static const auto table =
      config::Keys<Wind>("The air.")
          .key("speed", &Wind::speed, {.about = "How fast.", .unit = "m/s", .range = config::above_to(0.0, 10.0)})
          .key("layers", &Wind::layers, {.about = "How many.", .choices = {1, 3, 9}})
          .formerly("stratification")
          .key("small", &Wind::small, {.about = "A byte."})
          .key("mode", &Wind::mode, {.about = "Its mood."})
          .key("direction", &Wind::direction, {.about = "Where to."})
          .key("name", &Wind::name, {.about = "Its name.", .required = true})
          .key("pause", &Wind::pause, {.about = "Rest.", .unit = "s", .range = config::at_least(0.0), .duration = true})
          .key("ratio", &Wind::ratio, {.about = "Wildness."})
          .only_with("mode = \"wild\"", [](const Wind& w) { return w.mode == Mode::wild; })
          .key("gusts", &Wind::gusts, {.about = "Gusts | squalls."})
          .check([](const config::Value& value, Wind& w, config::Faults& faults) {
            if (w.speed > 9.0 && w.layers == 1) faults.add(value.place, "too fast for one layer");
          });
  return table;
}

const config::Keys<Ball>& keys(config::Of<Ball>) {
  static const auto table =
      config::Keys<Ball>("A ball.").key("radius", &Ball::radius, {.about = "Radius.", .required = true});
  return table;
}
const config::Keys<Cube>& keys(config::Of<Cube>) {
  static const auto table = config::Keys<Cube>("A cube.").key("edge", &Cube::edge, {.about = "Edge.", .required = true});
  return table;
}

namespace {

using config::Faults;
using config::parse_toml;

/// The faults of a text, one per line; "" if there are none.
std::string read(const std::string& text, Wind& wind) {
  Faults faults;
  const bool sound = keys(config::Of<Wind>{}).read(parse_toml(text, "f"), wind, faults);
  EXPECT_EQ(sound, faults.size() == 0);
  try {
    faults.throw_if_any();
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}
std::string faults_of(const std::string& text) {
  Wind wind;
  return read(text, wind);
}

TEST(Keys, FillTheStructAndKeepItsDefaults) {
  Wind wind;
  EXPECT_EQ(read("name = \"bora\"\nspeed = 4\nmode = \"wild\"\ndirection = [0, 1, 2.5]\npause = \"1m30s\"\n"
                 "gusts = [{ strength = 3 }, { strength = 4.5 }]\n",
                 wind),
            "");
  EXPECT_EQ(wind.name, "bora");
  EXPECT_EQ(wind.speed, 4.0);  // an integer will do for a number
  EXPECT_EQ(wind.mode, Mode::wild);
  EXPECT_EQ(wind.direction, Vec3(0.0, 1.0, 2.5));
  EXPECT_EQ(wind.pause, 90.0);
  EXPECT_EQ(wind.layers, 3);
  ASSERT_EQ(wind.gusts.size(), 2u);
  EXPECT_EQ(wind.gusts[1].strength, 4.5);
}

TEST(Keys, TellUnknownAndMissingKeys) {
  EXPECT_EQ(faults_of("sped = 1"),
            "f:1:1: unknown key 'sped' at the top level; did you mean 'speed'?\n"
            "f:1:1: required key 'name' is missing at the top level");
  EXPECT_EQ(faults_of("name = \"x\"\ngusts = [{ strenght = 1 }]"),
            "f:2:10: required key 'strength' is missing in [gusts.0]\n"
            "f:2:12: unknown key 'strenght' in [gusts.0]; did you mean 'strength'?");
}

TEST(Keys, TellMistypedValues) {
  EXPECT_EQ(faults_of("name = 3"), "f:1:8: 'name' must be text, not the integer 3");
  const std::string named = "name = \"x\"\n";
  EXPECT_EQ(faults_of(named + "speed = \"fast\""), "f:2:9: 'speed' must be a number, not the text \"fast\"");
  EXPECT_EQ(faults_of(named + "speed = true"), "f:2:9: 'speed' must be a number, not the boolean true");
  EXPECT_EQ(faults_of(named + "layers = 3.0"), "f:2:10: 'layers' must be an integer, not the number 3.0");
  EXPECT_EQ(faults_of(named + "mode = 1"), "f:2:8: 'mode' must be one of \"calm\", \"wild\", not the integer 1");
  EXPECT_EQ(faults_of(named + "direction = 1"), "f:2:13: 'direction' must be a list of 3 numbers, not the integer 1");
  EXPECT_EQ(faults_of(named + "direction = [1, [2], 3]"), "f:2:17: 'direction.1' must be a number, not a list");
  EXPECT_EQ(faults_of(named + "gusts = {}"), "f:2:9: 'gusts' must be a list of tables, not a table");
  EXPECT_EQ(faults_of(named + "gusts = [1]"), "f:2:10: 'gusts.0' must be a table, not the integer 1");
  EXPECT_EQ(faults_of(named + "speed = 1979-05-27"), "f:2:9: 'speed' must be a number, not a date or time");
  EXPECT_EQ(faults_of(named + "pause = true"),
            "f:2:9: 'pause' must be a number of seconds or a duration such as \"10m\", not the boolean true");
}

TEST(Keys, TellValuesOutOfRange) {
  const std::string named = "name = \"x\"\n";
  EXPECT_EQ(faults_of(named + "speed = 0"), "f:2:9: 'speed' is 0; it must be greater than 0 and at most 10");
  EXPECT_EQ(faults_of(named + "speed = 10.5"), "f:2:9: 'speed' is 10.5; it must be greater than 0 and at most 10");
  EXPECT_EQ(faults_of(named + "speed = 10"), "");
  EXPECT_EQ(faults_of(named + "speed = nan"),
            "f:2:9: 'speed' is nan; it must be a finite number, greater than 0 and at most 10");
  EXPECT_EQ(faults_of(named + "ratio = inf\nmode = \"wild\""), "f:2:9: 'ratio' is inf; it must be a finite number");
  EXPECT_EQ(faults_of(named + "direction = [1, -inf, 3]"), "f:2:17: 'direction.1' is -inf; it must be a finite number");
  EXPECT_EQ(faults_of(named + "direction = [1, 2]"), "f:2:13: 'direction' has 2 entries; it must be a list of 3 numbers");
  EXPECT_EQ(faults_of(named + "layers = 2"), "f:2:10: 'layers' is 2; it must be one of 1, 3, 9");
  EXPECT_EQ(faults_of(named + "small = 256"), "f:2:9: 'small' is 256; it must be at most 255");
  EXPECT_EQ(faults_of(named + "small = -1"), "f:2:9: 'small' is -1; it must be at least 0");
  EXPECT_EQ(faults_of(named + "mode = \"clam\""),
            "f:2:8: 'mode' is \"clam\"; it must be one of \"calm\", \"wild\"; did you mean \"calm\"?");
  EXPECT_EQ(faults_of(named + "pause = -1"), "f:2:9: 'pause' is -1; it must be at least 0");
  EXPECT_EQ(faults_of("name = \"\""), "f:1:8: 'name' is \"\"; it must be a text of at least one letter");
}

/// Faults, or the layers read and the warnings, a line each.
std::string layers_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  Wind wind;
  Faults faults;
  config::Value root = parse_toml(text, "f");
  for (const std::string& assignment : overrides) apply_override(root, assignment, faults);
  keys(config::Of<Wind>{}).read(root, wind, faults);
  try {
    faults.throw_if_any();
  } catch (const UsageError& error) {
    return error.what();
  }
  std::string result = std::to_string(wind.layers);
  for (const std::string& warning : faults.warnings()) result += '\n' + warning;
  return result;
}

TEST(Keys, AcceptAnOldNameWithAWarning) {
  const std::string warning = "'stratification' is now called 'layers'; the old name is accepted in this version only";
  EXPECT_EQ(layers_of("name = \"x\"\nlayers = 9"), "9");
  EXPECT_EQ(layers_of("name = \"x\"\nstratification = 9"), "9\nf:2:1: " + warning);
  EXPECT_EQ(layers_of("name = \"x\"", {"stratification=1"}), "1\n--set stratification=1: " + warning);
  EXPECT_EQ(layers_of("name = \"x\"\nstratification = 2"), "f:2:18: 'stratification' is 2; it must be one of 1, 3, 9");
}

TEST(Keys, AnOverrideReplacesAValueOfEitherName) {
  EXPECT_EQ(layers_of("name = \"x\"\nlayers = 9", {"stratification=1"}).substr(0, 1), "1");
  EXPECT_EQ(layers_of("name = \"x\"\nstratification = 9", {"layers=1"}).substr(0, 1), "1");
}

TEST(Keys, RefuseBothNamesOfAKey) {
  const std::string sentence =
      "'stratification' and 'layers' are both given; the first is the old name of the second: give 'layers' alone";
  EXPECT_EQ(layers_of("name = \"x\"\nlayers = 9\nstratification = 9"), "f:3:1: " + sentence);
  EXPECT_EQ(layers_of("name = \"x\"", {"layers=1", "stratification=1"}), "--set stratification=1: " + sentence);
}

TEST(Keys, RecogniseAMisspeltOldName) {
  EXPECT_EQ(faults_of("name = \"x\"\nstratifcation = 3"),
            "f:2:1: unknown key 'stratifcation' at the top level; did you mean 'layers', formerly 'stratification'?");
}

TEST(Keys, WriteAndDescribeThePresentNameOnly) {
  Wind wind;
  EXPECT_EQ(print_toml(keys(config::Of<Wind>{}).write(wind)).find("stratification"), std::string::npos);
  std::vector<config::TableText> sections;
  keys(config::Of<Wind>{}).describe("[wind]", "wind", sections);
  EXPECT_EQ(config::print_reference(sections).find("stratification"), std::string::npos);
  EXPECT_EQ(sections.at(0).keys.at(1).old_name, "stratification");
}

TEST(Keys, RefuseKeysThatDoNotCount) {
  EXPECT_EQ(faults_of("name = \"x\"\nratio = 1"), "f:2:1: 'ratio' is given but applies only with mode = \"wild\"");
  EXPECT_EQ(faults_of("name = \"x\"\nratio = 1\nmode = \"wild\""), "");
}

TEST(Keys, CheckSeveralKeysTogether) {
  EXPECT_EQ(faults_of("name = \"x\"\nspeed = 9.5\nlayers = 1"), "f:1:1: too fast for one layer");
  EXPECT_EQ(faults_of("name = \"x\"\nspeed = 9.5\nlayers = 1\nmode = 3"),  // not with other faults in the way
            "f:4:8: 'mode' must be one of \"calm\", \"wild\", not the integer 3");
}

TEST(Keys, CollectAllFaultsInTheOrderOfTheFile) {
  EXPECT_EQ(
      faults_of("name = \"x\"\nmode = 1\nspeed = 0\nbad = 1"),
      "f:2:8: 'mode' must be one of \"calm\", \"wild\", not the integer 1\n"
      "f:3:9: 'speed' is 0; it must be greater than 0 and at most 10\n"
      "f:4:1: unknown key 'bad' at the top level; known: 'speed', 'layers', 'small', 'mode', 'direction', 'name', 'pause', "
      "'ratio', 'gusts'");
}

TEST(Keys, WriteWhatTheyRead) {
  Wind wind;
  wind.name = "föhn";
  wind.speed = 0.1;
  wind.mode = Mode::wild;
  wind.gusts = {{1.0}, {2.0}};
  const std::string text = print_toml(keys(config::Of<Wind>{}).write(wind));
  Wind again;
  EXPECT_EQ(read(text, again), "");
  EXPECT_EQ(print_toml(keys(config::Of<Wind>{}).write(again)), text);
  EXPECT_NE(text.find("speed = 0.1  # m/s\n"), std::string::npos);
  EXPECT_NE(text.find("ratio = 0.5\n"), std::string::npos);
  wind.mode = Mode::calm;  // ratio does not count any more, and giving it would be a fault
  EXPECT_EQ(print_toml(keys(config::Of<Wind>{}).write(wind)).find("ratio"), std::string::npos);
}

TEST(Keys, DescribeThemselves) {
  std::vector<config::TableText> sections;
  keys(config::Of<Wind>{}).describe("[wind]", "wind", sections);
  EXPECT_EQ(config::print_reference(sections),
            "## [wind]\n\nThe air.\n\n"
            "| Key | Type | Unit | Default | Allowed | Meaning |\n|---|---|---|---|---|---|\n"
            "| `speed` | number | m/s | `2.5` | > 0, <= 10 | How fast. |\n"
            "| `layers` | integer |  | `3` | one of 1, 3, 9 | How many. |\n"
            "| `small` | integer |  | `7` |  | A byte. |\n"
            "| `mode` | name |  | `\"calm\"` | `\"calm\"`, `\"wild\"` | Its mood. |\n"
            "| `direction` | 3 numbers |  | `[1.0, 0.0, 0.0]` |  | Where to. |\n"
            "| `name` | text |  | **required** |  | Its name. |\n"
            "| `pause` | number or duration | s | `60.0` | >= 0 | Rest. |\n"
            "| `ratio` | number |  | `0.5` |  | Wildness. Only with `mode = \"wild\"`. |\n"
            "| `gusts` | list of tables |  | `[]` |  | Gusts \\| squalls. |\n\n"
            "## [[wind.gusts]]\n\nA gust.\n\n"
            "| Key | Type | Unit | Default | Allowed | Meaning |\n|---|---|---|---|---|---|\n"
            "| `strength` | number | Pa | **required** |  | How hard. |\n");
}

TEST(Choice, FillsTheAlternativeThatTheTagNames) {
  const auto choice = config::Choice<Solid>("type").add<Ball>("ball").add<Cube>("cube");
  Solid solid;
  Faults faults;
  EXPECT_TRUE(choice.read(parse_toml("type = \"cube\"\nedge = 2", "f"), solid, faults));
  EXPECT_EQ(std::get<Cube>(solid).edge, 2.0);
  EXPECT_EQ(print_inline(choice.write(solid)), "{ type = \"cube\", edge = 2.0 }");
}

TEST(Choice, TellsItsFaults) {
  const auto choice = config::Choice<Solid>("type").add<Ball>("ball").add<Cube>("cube");
  const auto fault = [&](const std::string& text) -> std::string {
    Solid solid;
    Faults faults;
    EXPECT_FALSE(choice.read(parse_toml(text, "f"), solid, faults, {"extra"}));
    try {
      faults.throw_if_any();
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(fault("edge = 2"), "f:1:1: required key 'type' is missing at the top level");
  EXPECT_EQ(fault("type = \"bal\""),
            "f:1:8: 'type' is \"bal\"; it must be one of \"ball\", \"cube\"; did you mean \"ball\"?");
  EXPECT_EQ(fault("type = \"ball\"\nedge = 2\nextra = 1"),
            "f:1:1: required key 'radius' is missing at the top level\n"
            "f:2:1: unknown key 'edge' at the top level; known: 'radius', 'extra', 'type'");
}

}  // namespace
}  // namespace bulkley::config_test::keys_test
