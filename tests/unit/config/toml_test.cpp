#include "bulkley/config/toml.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bulkley/base/error.hpp"

namespace bulkley::config::toml_test {
namespace {

std::string fault_of(const std::string& text) {
  try {
    parse_toml(text, "f.toml");
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

/// The tree of `text` with one override, printed; or the fault.
std::string overridden(const std::string& text, const std::string& assignment) {
  Value root = parse_toml(text, "f.toml");
  Faults faults;
  apply_override(root, assignment, faults);
  try {
    faults.throw_if_any();
  } catch (const UsageError& error) {
    return error.what();
  }
  return print_inline(root);
}

TEST(ParseToml, RemembersOrderPathAndPlace) {
  const Value root = parse_toml("z = 1\n[t]\n  y = [1.5, \"x\"]\na = true\n", "f.toml");
  ASSERT_EQ(root.items.size(), 2u);
  EXPECT_EQ(root.items[0].key, "z");  // not sorted by name
  const Value& y = *root.find("t")->find("y");
  EXPECT_EQ(y.path, "t.y");
  EXPECT_EQ(y.key_place.text(), "f.toml:3:3");
  EXPECT_EQ(y.place.text(), "f.toml:3:7");
  EXPECT_EQ(y.items[1].path, "t.y.1");
  EXPECT_EQ(y.items[1].place.text(), "f.toml:3:13");
  EXPECT_EQ(root.find("t")->items[1].boolean, true);
  EXPECT_EQ(root.find("nothing"), nullptr);
}

TEST(ParseToml, TellsRepeatedKeys) {
  EXPECT_EQ(fault_of("a = 1\na = 2\n"), "f.toml:2:5: key 'a' is given twice");
  EXPECT_EQ(fault_of("[t]\nx = 1\n[t]\n"), "f.toml:3:1: table 't' is given twice");
  EXPECT_EQ(fault_of("x = { a = 1, a = 2 }\n"), "f.toml:1:18: key 'a' is given twice");
}

TEST(ParseToml, TellsWhereItIsNotToml) {
  EXPECT_EQ(fault_of("a = 1\nb = [1, 2\nc = 3\n"),
            "f.toml:3:1: this is not valid TOML: array: expected comma or closing ']', saw 'c'");
  EXPECT_EQ(fault_of("a = cream\n"),
            "f.toml:1:5: this is not valid TOML: value: could not determine value type "
            "(a text needs quotes, a number a digit on both sides of its point)");
  EXPECT_EQ(fault_of("\xff\xfe"), "f.toml:1:1: this is not valid TOML: Encountered invalid utf-8 sequence");
}

TEST(Override, ReplacesAndAdds) {
  EXPECT_EQ(overridden("a = 1", "a=2"), "{ a = 2 }");
  EXPECT_EQ(overridden("a = 1", "b.c=[1, 2]"), "{ a = 1, b = { c = [1, 2] } }");
  EXPECT_EQ(overridden("[t]\na = 1", "t.a=\"x\""), "{ t = { a = \"x\" } }");
  EXPECT_EQ(overridden("[t]\na = 1", "t={b=1}"), "{ t = { b = 1 } }");
  EXPECT_EQ(overridden("[m.\"a.b\"]\nx = 1", "m.\"a.b\".x=2"), "{ m = { \"a.b\" = { x = 2 } } }");
}

TEST(Override, TakesBareWordsAsText) {
  EXPECT_EQ(overridden("", "a=pie"), "{ a = \"pie\" }");
  EXPECT_EQ(overridden("", "a=1h30m"), "{ a = \"1h30m\" }");
  EXPECT_EQ(overridden("", "a="), "{ a = \"\" }");
  EXPECT_EQ(overridden("", "a=x=y"), "{ a = \"x=y\" }");
  EXPECT_EQ(overridden("", "a=true"), "{ a = true }");
  EXPECT_EQ(overridden("", "a=1\nb=2"), "{ a = \"1\\nb=2\" }");  // one key, never two
}

TEST(Override, FindsEntriesByIndexAndName) {
  const std::string two = "[[b]]\nname = \"x\"\n[[b]]\nname = \"y\"\n";
  EXPECT_EQ(overridden(two, "b.1.v=3"), "{ b = [{ name = \"x\" }, { name = \"y\", v = 3 }] }");
  EXPECT_EQ(overridden(two, "b.x.v=3"), "{ b = [{ name = \"x\", v = 3 }, { name = \"y\" }] }");
  EXPECT_EQ(overridden("g = [1, 2, 3]", "g.2=9"), "{ g = [1, 2, 9] }");
}

TEST(Override, RefusesWhatItCannotReach) {
  const std::string two = "[[b]]\nname = \"x\"\n[[b]]\nname = \"y\"\n";
  EXPECT_EQ(overridden(two, "b.2.v=3"), "--set b.2.v=3: 'b' has no entry '2'; it has 2 entries ('x', 'y')");
  EXPECT_EQ(overridden(two, "b.z.v=3"), "--set b.z.v=3: 'b' has no entry 'z'; it has 2 entries ('x', 'y')");
  EXPECT_EQ(overridden("a = 1", "a.b.c=3"), "--set a.b.c=3: 'a' is the integer 1, it has no entry 'b'");
  for (const char* wrong : {"a", "", "=", "=3", "a b=3", "a.=3", ".a=3", "a..b=3"})
    EXPECT_EQ(overridden("a = 1", wrong), std::string("--set ") + wrong + ": an override has the form key.path=value");
}

TEST(PrintToml, GivesBackTheSameBits) {
  const double tricky[] = {
      0.1, 1.0 / 3.0, 1e300, 5e-324, -0.0, 1e22, 123456789.0, 2.5e-7, std::numeric_limits<double>::max()};
  for (const double x : tricky) {
    Value root = make_table();
    add_entry(root, "x", make_number(x));
    const Value again = parse_toml(print_toml(root), "f.toml");
    EXPECT_EQ(again.items[0].kind, Kind::number);
    EXPECT_EQ(std::signbit(again.items[0].number), std::signbit(x));
    EXPECT_EQ(again.items[0].number, x);
  }
}

TEST(PrintToml, QuotesTextAndKeys) {
  const std::string nasty = "a \"b\" \\ \n \t \x01 \x7f \xc3\xa4 # [";
  Value root = make_table();
  add_entry(root, "x y.z", make_text(nasty));
  add_entry(root, "", make_text(""));
  const Value again = parse_toml(print_toml(root), "f.toml");
  ASSERT_NE(again.find("x y.z"), nullptr);
  EXPECT_EQ(again.find("x y.z")->text, nasty);
  EXPECT_NE(again.find(""), nullptr);
}

TEST(PrintToml, WritesTablesAsSections) {
  const std::string text =
      "a = 1\nl = []\n\n[t]\nb = 2.0  # m\n\n[m.x]\nc = 1\n\n[m.y]\nc = 2\n\n[[k]]\nd = { e = 1 }\n\n[[k]]\nd = {}\n";
  Value root = parse_toml(text, "f.toml");
  root.find("t")->items[0].comment = "m";
  EXPECT_EQ(print_toml(root), text);
}

TEST(ParseToml, TellsRepetitionsOfAnotherKind) {
  EXPECT_TRUE(fault_of("a = 1\na.b = 2\n").starts_with("f.toml:2:1: a key is given twice"));
}

// What a text may ask of the parser is bounded before it is parsed.
TEST(ParseToml, RefusesDepthAndSizeWithTheirPlace) {
  EXPECT_EQ(fault_of("a = 1\nb = " + std::string(33, '[')), "f.toml:2:37: brackets are nested more than 32 deep here");
  EXPECT_EQ(fault_of("a" + std::string(17, '.')), "f.toml:1:18: a key has more than 16 parts with dots between them");
  EXPECT_EQ(fault_of("a = [" + std::string(500'000, ',')), "f.toml:1:500004: the text holds more than 500000 values");
  EXPECT_EQ(fault_of("#" + std::string(largest_text, ' ')), "f.toml: the text is larger than 16 MiB");
  std::string nested = "a = 1";
  for (int n = 0; n < 30; ++n) nested = "a = { " + nested + " }";
  EXPECT_EQ(fault_of(nested), "");
}

TEST(ParseToml, CountsNoBracketsAndDotsOfTextsAndComments) {
  const std::string brackets(40, '['), dots(40, '.'), three_quotes = "\"\"\"";
  const std::string text = "a = \"\\\"" + brackets + dots + "\"\nb = '" + dots + "'\nc = " + three_quotes + "x\n\\\"" +
                           brackets + "\n" + three_quotes + "\nd = '''" + brackets + "\n" + dots + "'''  # " + brackets +
                           "\n";
  const Value root = parse_toml(text, "f.toml");
  ASSERT_EQ(root.items.size(), 4u);
  EXPECT_EQ(root.items[1].text, dots);
}

TEST(Faults, PrintOnOneLineOfBoundedLength) {
  EXPECT_EQ(printable("a\nb\x1b[m\tc"), "a\\nb?[m?c");
  EXPECT_LT(printable(std::string(1'000'000, 'x')).size(), 3000u);
  std::string euros;
  for (int n = 0; n < 2000; ++n) euros += "\xe2\x82\xac";
  EXPECT_TRUE(is_utf8(printable(euros))) << "cut between characters";
  for (const char* wrong : {"\xff", "\xc0\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82", "\x80", "a\xc3"})
    EXPECT_FALSE(is_utf8(wrong));
  Faults faults;
  for (int n = 0; n < 1000; ++n) faults.add({"f", n + 1, 1}, "wrong");
  EXPECT_EQ(faults.size(), 1000u);
  std::string text;
  try {
    faults.throw_if_any();
  } catch (const UsageError& error) {
    text = error.what();
  }
  EXPECT_TRUE(text.ends_with("f:100:1: wrong\n... and 900 more faults")) << text;
}

}  // namespace
}  // namespace bulkley::config::toml_test
