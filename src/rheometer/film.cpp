#include "rheometer/film.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bulkley {

double Film::radius() const {
  constexpr double pi = std::numbers::pi;
  return std::pow(225.0 * volume * volume / (128.0 * pi * pi * height), 0.2);
}

double Film::middle() const { return std::sqrt(2.0 * height * radius()); }

// The walls make a film thicker, never thinner: the thickest of the three is that of the shape that fits.
double Film::mean_height() const {
  const double round = volume / (std::numbers::pi * radius() * radius());
  const double narrow = std::min(length, width);
  const double half_strip = std::pow(0.75 * volume / (narrow * std::sqrt(2.0 * height)), 2.0 / 3.0);
  return std::max({round, volume / (2.0 * half_strip * narrow), volume / (length * width)});
}

}  // namespace bulkley
