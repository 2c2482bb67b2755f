// Every documented key with every kind of wrong value: a sentence with place and key, or a scene that is sound.
//
// The keys, types and ranges are those of the reference page, hence of the declarations: a new key is tested without a line here,
// a new table needs an entry in key_contexts.hpp. Old names of keys are tested like their present ones.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <optional>
#include <regex>
#include <set>
#include <sstream>

#include "bulkley/config/toml.hpp"
#include "support/scene_text.hpp"
#include "unit/scene/key_contexts.hpp"

namespace bulkley::scene_test::every_key_test {
namespace {

using config::Value;

// --- what the page says --------------------------------------------------------------------------------------------------

struct Key {
  std::string section, name, type, allowed;
  bool required = false;
  std::string condition;  ///< `scheme = "blend"`: the key applies only with this
};

std::vector<Key> documented_keys() {
  std::istringstream page(input_reference());
  std::string line, section;
  std::vector<Key> keys;
  while (std::getline(page, line)) {
    if (line.starts_with("## ")) section = line.substr(3);
    if (!line.starts_with("| `")) continue;
    std::vector<std::string> cells;
    for (std::size_t at = 2; at < line.size();) {
      const std::size_t end = line.find(" |", at);
      cells.push_back(line.substr(at, end - at));
      at = end + 3;
    }
    Key key{section, cells.at(0).substr(1, cells[0].size() - 2), cells.at(1), cells.at(4), cells.at(3) == "**required**",
            {}};
    std::smatch only;
    if (std::regex_search(cells.at(5), only, std::regex("Only with `(\\w+ = [^`]+)`"))) key.condition = only[1];
    keys.push_back(key);
  }
  return keys;
}

/// The keys of the page and, as keys of their own, the old names that are still accepted.
std::vector<Key> accepted_keys() {
  std::vector<Key> keys = documented_keys();
  const std::vector<Key> documented = keys;
  for (const config::TableText& table : input_tables())
    for (const config::KeyText& text : table.keys)
      for (const Key& key : documented) {
        if (text.old_name.empty() || key.section != table.title || key.name != text.name) continue;
        keys.push_back(key);
        keys.back().name = text.old_name;
        keys.back().required = false;  // its absence is reported by the present name
      }
  return keys;
}

// --- where a key is ------------------------------------------------------------------------------------------------------

const std::string mark = "@@";

Value* at_path(Value& root, const std::string& path) {
  Value* at = &root;
  std::istringstream parts(path);
  for (std::string part; at && std::getline(parts, part, '.');)
    at = at->is_list() ? &at->items.at(std::stoul(part)) : at->find(part);
  return at;
}

/// The scene in which `key` has the value `mark`, a text.
Value marked_scene(const Key& key) {
  Value root = config::parse_toml(base, "base.toml");
  config::Faults faults;
  std::string table;
  for (const auto& [path, value] : setting(key.section)) {
    table = path;
    if (!value.empty()) config::apply_override(root, path + "=" + value, faults);
  }
  const std::string prefix = table.empty() ? "" : table + ".";
  // What else the table needs for the key to count, and what would contradict it.
  if (!key.condition.empty() && !key.condition.starts_with("no ")) {
    // `scheme = "a" or "b", time = 0`: several settings, the first of several values
    const std::regex setting("(\\w+) = ([^,` ]+)");
    for (std::sregex_iterator at(key.condition.begin(), key.condition.end(), setting), end; at != end; ++at)
      config::apply_override(root, prefix + at->str(1) + "=" + at->str(2), faults);
    if (key.condition == "mode = \"fixed\"" && key.name != "dt" && key.name != "step")
      config::apply_override(root, prefix + "dt=0.1", faults);
  }
  Value* holder = at_path(root, table);
  const auto drop = [&](const std::set<std::string>& names) {
    std::erase_if(holder->items, [&](const Value& entry) { return names.contains(entry.key); });
  };
  if (key.name == "youngs_modulus" || key.name == "poisson_ratio") {
    drop({"bulk_modulus", "shear_modulus"});
    config::apply_override(root, prefix + "youngs_modulus=1e5", faults);
    config::apply_override(root, prefix + "poisson_ratio=0.3", faults);
  }
  if (key.name == "flow_rate" || key.name.starts_with("key_frames")) drop({"speed"});
  if (key.section == "[[inflows]]" && key.name.starts_with("key_frames")) drop({"position"});
  if (key.name == "yield_stress" || key.name == "consistency" || key.name == "flow_index") {
    holder = at_path(root, table);
    drop({"sigma_Y", "eta", "h"});
    for (const char* name : {"yield_stress=10", "consistency=5", "flow_index=0.5"})
      config::apply_override(root, prefix + name, faults);
  }
  config::apply_override(root, prefix + key.name + "=\"" + mark + "\"", faults);
  faults.throw_if_any();
  return root;
}

// --- the values ----------------------------------------------------------------------------------------------------------

const std::vector<std::string> numbers{"0",
                                       "0.0",
                                       "-0.0",
                                       "1",
                                       "-1",
                                       "0.3",
                                       "3",
                                       "27",
                                       "5e-324",
                                       "1e-300",
                                       "-1e-300",
                                       "1e-20",
                                       "1e20",
                                       "1e99",
                                       "-1e99",
                                       "1e101",
                                       "1e308",
                                       "-1e308",
                                       "1000000000000000000",
                                       "9223372036854775807",
                                       "-9223372036854775808",
                                       "2147483647",
                                       "2147483648",
                                       "4294967296",
                                       "0x7f",
                                       "1_000",
                                       "nan",
                                       "inf",
                                       "-inf"};
const std::vector<std::string> texts{"\"\"",      "\"word\"",         "\"5 mm\"",        "\"1e3\"",
                                     "\"nan\"",   "\"1h30m\"",        "\"1e300d\"",      "\"\\u0000\"",
                                     "\"a\\nb\"", "'''long\ntext'''", "\"builtin:cat\"", "\"periodic\""};
const std::vector<std::string> others{"true",
                                      "false",
                                      "1979-05-27",
                                      "07:32:00",
                                      "1979-05-27T07:32:00Z",
                                      "[]",
                                      "[1]",
                                      "[1, 2]",
                                      "[1, 2, 3]",
                                      "[1, 2, 3, 4]",
                                      "[0, 0, 0]",
                                      "[0.1, 0.1, 0.1]",
                                      "[nan, 0, 0]",
                                      "[0, inf, 0]",
                                      "[1e308, 1e308, 1e308]",
                                      "[-1e99, -1e99, -1e99]",
                                      "[1e99, 1e99, 1e99]",
                                      "[1e-320, 0, 0]",
                                      "[1e-170, 1e-170, 1e-170]",
                                      "[1000000000000000000, 1, 1]",
                                      "[true, 1, 2]",
                                      "[\"1\", \"2\", \"3\"]",
                                      "[\"x\", \"y\", \"z\"]",
                                      "[\"x\", \"y +\", \"\"]",
                                      "[\"x/0\", \"(\", \"sqrt(-1)\"]",
                                      "[\"velocity\"]",
                                      "[\"velocity\", \"velocity\"]",
                                      "[[1, 2, 3]]",
                                      "[[1], [2], [3]]",
                                      "[[], [], []]",
                                      "{ }",
                                      "{ a = 1 }",
                                      "[{ }]",
                                      "[{ }, { }]",
                                      "[{ a = 1 }, 1]",
                                      "{ type = \"sphere\" }",
                                      "{ type = \"cat\" }",
                                      "{ type = 1 }",
                                      "[{ time = 0 }, { time = 0 }]",
                                      "{ angle = nan }",
                                      "{ axis = [0, 0, 0], angle = 1 }"};
/// No TOML: refused with the place, by a parser that knows no keys.
const std::vector<std::string> no_toml{"5 mm",   "1.2.3", "",       "0.5.", "1e400x", "99999999999999999999",
                                       "\"open", "[1, 2", "{ a = ", "tru",  "0b2",    "'a' 'b'",
                                       "\\",     "[1,,2]"};

bool is_number(const std::string& raw) {
  return std::find(numbers.begin(), numbers.end(), raw) != numbers.end() && raw != "nan" && raw != "inf" && raw != "-inf";
}
bool is_integer(const std::string& raw) {
  return is_number(raw) && (raw.find_first_of(".e") == std::string::npos || raw[1] == 'x');
}
bool is_text(const std::string& raw) { return raw.starts_with('"') || raw.starts_with('\''); }

double number_of(const std::string& raw) {
  std::string digits = raw;
  std::erase(digits, '_');
  return std::strtod(digits.c_str(), nullptr);
}

/// Whether the page's range, such as "> 0, <= 0.5" or "one of 1, 8, 27, 64", has the number.
bool in_range(const std::string& allowed, double value) {
  if (allowed.starts_with("one of ")) {
    std::istringstream choices(allowed.substr(7));
    for (std::string choice; std::getline(choices, choice, ',');)
      if (std::stod(choice) == value) return true;
    return false;
  }
  std::istringstream bounds(allowed);
  for (std::string bound; std::getline(bounds, bound, ',');) {
    std::istringstream words(bound);
    std::string sign;
    double limit = 0.0;
    if (!(words >> sign >> limit)) continue;
    if ((sign == ">" && !(value > limit)) || (sign == ">=" && !(value >= limit)) || (sign == "<" && !(value < limit)) ||
        (sign == "<=" && !(value <= limit)))
      return false;
  }
  return true;
}

/// Whether the declaration of the key alone says that this value is wrong.
bool is_wrong(const Key& key, const std::string& raw) {
  if (key.type == "number")
    return !is_number(raw) || std::abs(number_of(raw)) > 1e100 || !in_range(key.allowed, number_of(raw));
  if (key.type == "integer") return !is_integer(raw) || !in_range(key.allowed, number_of(raw));
  if (key.type == "boolean") return raw != "true" && raw != "false";
  if (key.type == "text") return !is_text(raw);
  if (key.type == "name") return !is_text(raw) || key.allowed.find(raw) == std::string::npos;
  if (key.type == "3 numbers") return !std::regex_match(raw, std::regex("\\[[-0-9.e]+, [-0-9.e]+, [-0-9.e]+\\]"));
  if (key.type == "3 formulas") return !raw.starts_with("[\"") || raw.find("velocity") != std::string::npos;
  if (key.type == "table" || key.type == "shape") return !raw.starts_with('{');
  if (key.type == "list of tables") return !raw.starts_with('[') || raw.find_first_of("0123456789\"") == 1;
  if (key.type == "number or \"measured\"")
    return is_number(raw) ? std::abs(number_of(raw)) > 1e100 || !in_range(key.allowed, number_of(raw)) : raw != "\"measured\"";
  if (key.type == "number or formula") return is_number(raw) && !in_range(key.allowed, number_of(raw));
  return is_number(raw) && key.type != "number or duration";
}

// --- the judge -----------------------------------------------------------------------------------------------------------

std::string what_runs;
void on_alarm(int) {
  if (::write(STDERR_FILENO, what_runs.data(), what_runs.size()) < 0) ::_exit(2);
  ::_exit(1);
}

struct Outcome {
  bool accepted = false;
  std::string sentence;
};

Outcome outcome_of(const std::string& text) {
  what_runs = "hangs for more than 10 s:\n" + text;
  ::signal(SIGALRM, on_alarm);
  ::alarm(10);
  Outcome outcome;
  try {
    const Scene scene = parse_scene(text, "s.toml", {});
    outcome.accepted = true;
    EXPECT_EQ(parse_scene(scene.effective_text, "/e.toml", {}).effective_text, scene.effective_text);
    if (text.find("mesh") == std::string::npos && text.find("key_frames_file") == std::string::npos) {
      check_bodies(scene);
      check_colliders(scene);
      check_rigid_bodies(scene);
      check_gauges(scene);
    }
  } catch (const UsageError& error) {
    outcome.sentence = error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "not a UsageError: " << error.what() << "\n" << text;
  }
  ::alarm(0);
  return outcome;
}

/// "file:line", where the mark is.
std::string place_of_mark(const std::string& text) {
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find(mark)), '\n');
  return fmt::format("s.toml:{}:", line);
}

std::string replaced(std::string text, const std::string& old, const std::string& by) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old << " is not in\n" << text;
  return at == std::string::npos ? text : text.replace(at, old.size(), by);
}

void expect_sentence(const Key& key, const std::string& text, const std::string& sentence, const std::string& named) {
  EXPECT_TRUE(sentence.starts_with("s.toml:")) << sentence << "\n" << text;
  EXPECT_NE(sentence.find(named), std::string::npos) << key.section << " " << key.name << ": " << sentence << "\n" << text;
  EXPECT_EQ(std::count_if(sentence.begin(), sentence.end(),
                          [](char c) { return c != '\n' && static_cast<unsigned char>(c) < 0x20; }),
            0)
      << sentence;
}

// --- the tests -----------------------------------------------------------------------------------------------------------

TEST(EveryKey, HasAContext) {
  EXPECT_EQ(accepted_keys().size(), documented_keys().size() + 4u) << "old names of [time]";
  std::set<std::string> sections;
  for (const Key& key : documented_keys()) sections.insert(key.section);
  EXPECT_GT(sections.size(), 30u);
  for (const std::string& section : sections) EXPECT_FALSE(setting(section).empty()) << "no context for " << section;
}

TEST(EveryKey, RefusesWrongValuesWithPlaceAndKey) {
  std::size_t n = 0, n_refused = 0;
  std::vector<std::string> values = numbers;
  values.insert(values.end(), texts.begin(), texts.end());
  values.insert(values.end(), others.begin(), others.end());
  values.push_back('"' + std::string(100'000, 'x') + '"');
  for (const Key& key : accepted_keys()) {
    const std::string marked = config::print_toml(marked_scene(key));
    for (const std::string& raw : values) {
      const std::string text = replaced(marked, "\"" + mark + "\"", raw);
      const Outcome outcome = outcome_of(text);
      ++n;
      n_refused += outcome.sentence.empty() ? 0 : 1;
      if (is_wrong(key, raw)) {
        EXPECT_FALSE(outcome.accepted) << key.section << " " << key.name << " = " << raw.substr(0, 200);
        if (!outcome.accepted) {
          expect_sentence(key, text, outcome.sentence, key.name);
          // A list of tables on lines of its own, and what several keys say together, have another line.
          if (!raw.starts_with('[') && !raw.starts_with('{') && !is_text(raw)) {
            EXPECT_NE(outcome.sentence.find(place_of_mark(marked)), std::string::npos) << outcome.sentence << "\n" << text;
          }
        }
      }
      if (!outcome.sentence.empty()) {
        EXPECT_TRUE(outcome.sentence.starts_with("s.toml:")) << outcome.sentence;
      }
    }
  }
  fmt::print("{} values of {} keys, {} refused\n", n, accepted_keys().size(), n_refused);
  EXPECT_GT(n_refused, n / 2);
  EXPECT_LT(n_refused, n);
}

TEST(EveryKey, RefusesWhatIsNoToml) {
  std::size_t n = 0;
  for (const Key& key : accepted_keys()) {
    const std::string marked = config::print_toml(marked_scene(key));
    for (const std::string& raw : no_toml) {
      const Outcome outcome = outcome_of(replaced(marked, "\"" + mark + "\"", raw));
      EXPECT_FALSE(outcome.accepted) << key.name << " = " << raw;
      EXPECT_TRUE(outcome.sentence.starts_with("s.toml:")) << outcome.sentence;
      ++n;
    }
  }
  fmt::print("{} texts\n", n);
}

TEST(EveryKey, IsMissedMisspeltAndRefusedTwice) {
  std::size_t n = 0;
  for (const Key& key : accepted_keys()) {
    const Value scene = marked_scene(key);
    const std::string marked = config::print_toml(scene);
    const std::string entry = key.name + " = \"" + mark + "\"";
    const bool is_inline = marked.find(entry + "\n") == std::string::npos && marked.find(entry + "  #") == std::string::npos;

    const std::string misspelt = replaced(marked, entry, key.name + "_ = \"" + mark + "\"");
    Outcome outcome = outcome_of(misspelt);
    EXPECT_FALSE(outcome.accepted) << misspelt;
    expect_sentence(key, misspelt, outcome.sentence, "'" + key.name + "_'");

    const std::string twice = replaced(marked, entry, entry + (is_inline ? ", " : "\n") + entry);
    outcome = outcome_of(twice);
    EXPECT_FALSE(outcome.accepted) << twice;
    expect_sentence(key, twice, outcome.sentence, "'" + key.name + "'");
    EXPECT_NE(outcome.sentence.find("twice"), std::string::npos) << outcome.sentence;
    n += 2;
    if (!key.required) continue;
    const std::string missing = replaced(marked, entry, "");
    outcome = outcome_of(is_inline ? replaced(marked, entry, "unknown = 1") : missing);
    EXPECT_FALSE(outcome.accepted) << missing;
    expect_sentence(key, missing, outcome.sentence, key.name);
    ++n;
  }
  fmt::print("{} texts\n", n);
}

TEST(EveryKey, TakesLittleMemory) {
  struct rusage usage = {};
  ::getrusage(RUSAGE_SELF, &usage);
  EXPECT_LT(usage.ru_maxrss, 1 << 20) << "KiB, of all tests so far";
}

}  // namespace
}  // namespace bulkley::scene_test::every_key_test
