#include "base/text.hpp"

#include <gtest/gtest.h>

#include "base/hash.hpp"

namespace bulkley::text_test {
namespace {

using Words = std::vector<std::string>;

TEST(Text, PartsBetweenSeparators) {
  EXPECT_EQ(split("a,b", ','), (Words{"a", "b"}));
  EXPECT_EQ(split(",a,", ','), (Words{"", "a", ""}));
  EXPECT_EQ(split("", ','), (Words{""}));
}

TEST(Text, AShellReadsOneWord) {
  EXPECT_EQ(shell_word("out/a-1.5=b"), "out/a-1.5=b");
  EXPECT_EQ(shell_word("it's $HOME"), "'it'\\''s $HOME'");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("\xC3\xA4"), "'\xC3\xA4'");
}

TEST(Text, StringsOfToml) { EXPECT_EQ(toml_string("a \"b\\\n\t\x01\x7f"), R"("a \"b\\\n\t\u0001\u007F")"); }

TEST(Text, ExcerptsCanBePrinted) {
  EXPECT_EQ(excerpt("a\n\xff"), "'a?" "?'");
  EXPECT_EQ(excerpt(std::string(50, 'x')), "'" + std::string(40, 'x') + "'");
}

TEST(Hash, IsTheFirstValueOfSplitmix64) {
  EXPECT_EQ(splitmix64(0), 0xe220a8397b1dcdafu);
  EXPECT_EQ(splitmix64(0x9e3779b97f4a7c15u), 0x6e789e6aa1b965f4u);  // the second value of the seed 0
}

}  // namespace
}  // namespace bulkley::text_test
