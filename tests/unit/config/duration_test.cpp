#include "config/duration.hpp"

#include <gtest/gtest.h>

#include "bulkley/base/error.hpp"

namespace bulkley::duration_test {
namespace {

TEST(Duration, ReadsUnitsInFallingOrder) {
  EXPECT_EQ(parse_duration("90s"), 90.0);
  EXPECT_EQ(parse_duration("10m"), 600.0);
  EXPECT_EQ(parse_duration("1h55m"), 6900.0);
  EXPECT_EQ(parse_duration("1d2h3m4.5s"), 86400.0 + 7200.0 + 180.0 + 4.5);
  EXPECT_EQ(parse_duration("1.5h"), 5400.0);
  EXPECT_EQ(parse_duration("0s"), 0.0);
}

TEST(Duration, ReadsAPlainNumberAsSeconds) {
  EXPECT_EQ(parse_duration("90"), 90.0);
  EXPECT_EQ(parse_duration("0.25"), 0.25);
}

TEST(Duration, RefusesWhatIsNone) {
  for (const char* text : {"", "m", "10x", "-5m", "-0", "1m1h", "1h1h", "1h30", "10 m", "inf", "nan", "1h-5m", "h10", " 5"})
    EXPECT_THROW(parse_duration(text), UsageError) << "'" << text << "'";
}

TEST(Duration, SaysHowToWriteOne) {
  try {
    parse_duration("10x");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "'10x' is not a duration; write for example 90s, 10m, 1h55m, 2d or a number of seconds");
  }
}

TEST(Duration, WritesWhatItReads) {
  EXPECT_EQ(duration_text(6900.0), "1h55m");
  EXPECT_EQ(duration_text(0.0), "0s");
  EXPECT_EQ(duration_text(1.25), "1.25s");
  EXPECT_EQ(duration_text(59.9999), "1m");
  for (const double seconds : {1.0, 61.0, 3600.0, 86400.0, 90061.5})
    EXPECT_EQ(parse_duration(duration_text(seconds)), seconds);
}

}  // namespace
}  // namespace bulkley::duration_test
