#include "rheometer/film.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bulkley::film_test {
namespace {

// Volume under the profile that ends at `radius`, from h dh/dr = -height integrated inwards in small steps; round or, per
// width, on both sides of a ridge.
double volume_under(double radius, double height, bool is_round) {
  constexpr int n = 200000;
  const double dr = radius / n;
  double h_squared = 0.0, volume = 0.0;
  for (int i = n; i-- > 0;) {
    h_squared += 2.0 * height * dr;  // d(h^2) = 2 h dh
    const double h = std::sqrt(h_squared - height * dr), r = (i + 0.5) * dr;
    volume += (is_round ? 2.0 * std::numbers::pi * r : 2.0) * h * dr;
  }
  return volume;
}

TEST(Film, RoundHeapsHaveTheirVolume) {
  for (const double height : {1e-4, 3e-3})
    for (const double volume : {1e-6, 4e-3}) {
      const Film film{volume, height, 100.0, 100.0};
      const double radius = film.radius();
      EXPECT_NEAR(volume_under(radius, height, true), volume, 1e-5 * volume);
      EXPECT_NEAR(film.middle() * film.middle(), 2.0 * height * radius, 1e-12);
      EXPECT_NEAR(film.mean_height(), volume / (std::numbers::pi * radius * radius), 1e-12);
      EXPECT_NEAR(film.mean_height(), 8.0 / 15.0 * film.middle(), 1e-12);
    }
}

// Between walls 2 cm apart the heap is a ridge from wall to wall.
TEST(Film, StripsHaveTheirVolume) {
  const Film film{1e-3, 2e-3, 100.0, 0.02};
  const double covered = film.volume / film.mean_height() / 0.02;  // length
  EXPECT_GT(2.0 * film.radius(), 0.02);
  EXPECT_NEAR(0.02 * volume_under(0.5 * covered, film.height, false), film.volume, 1e-5 * film.volume);
}

TEST(Film, CoversTheFloorBetweenAllWalls) {
  const Film film{1e-3, 1e-6, 0.1, 0.2};
  EXPECT_NEAR(film.mean_height(), 0.05, 1e-15);
}

}  // namespace
}  // namespace bulkley::film_test
