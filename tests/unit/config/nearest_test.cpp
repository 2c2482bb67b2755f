#include "config/nearest.hpp"

#include <gtest/gtest.h>

namespace bulkley::config::nearest_test {
namespace {

const std::vector<std::string> words{"density", "viscosity", "end", "mode", "elastic_cfl"};

TEST(Nearest, FindsSlipsOfThePen) {
  EXPECT_EQ(nearest("viscocity", words), "viscosity");
  EXPECT_EQ(nearest("desntiy", words), "density");  // a swap of neighbours is one slip, here there are two
  EXPECT_EQ(nearest("density", words), "density");
  EXPECT_EQ(nearest("elastic-clf", words), "elastic_cfl");
  EXPECT_EQ(nearest("ned", words), "end");
}

TEST(Nearest, DoesNotGuessWildly) {
  EXPECT_EQ(nearest("gravity", words), std::nullopt);
  EXPECT_EQ(nearest("xyz", words), std::nullopt);
  EXPECT_EQ(nearest("", words), std::nullopt);
  EXPECT_EQ(nearest(std::string(100000, 'x'), words), std::nullopt);
  EXPECT_EQ(nearest("end", {}), std::nullopt);
}

TEST(Nearest, ListsTheKnownWordsWhereNoneIsNear) {
  EXPECT_EQ(suggestion("densty", words), "; did you mean 'density'?");
  EXPECT_EQ(suggestion("gravity", {"a", "b"}), "; known: 'a', 'b'");
  EXPECT_EQ(suggestion("gravity", {}), "");
}

}  // namespace
}  // namespace bulkley::config::nearest_test
