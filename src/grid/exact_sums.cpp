#include "grid/exact_sums.hpp"

#include <cmath>

#include "bulkley/base/error.hpp"

namespace bulkley {

ExactSums::ExactSums(std::size_t n_sums, double magnitude) : sums_(n_sums, 0), exponent_(std::ilogb(magnitude) - 70) {}

void ExactSums::add(std::size_t n, double value) {
  const double scaled = std::ldexp(value, -exponent_);
  // Beyond 2^120 nothing physical is left; the cast would be undefined beyond 2^127.
  if (std::abs(scaled) < 0x1p120) sums_[n] += static_cast<Integer>(std::nearbyint(scaled));
}

void ExactSums::add(const ExactSums& other) {
  BULKLEY_ASSERT(sums_.size() == other.sums_.size() && exponent_ == other.exponent_);
  for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += other.sums_[i];
}

double ExactSums::value(std::size_t n) const { return std::ldexp(static_cast<double>(sums_[n]), exponent_); }

std::vector<std::int64_t> ExactSums::words() const {
  std::vector<std::int64_t> result;
  for (const Integer sum : sums_) {
    result.push_back(static_cast<std::int64_t>(static_cast<std::uint64_t>(sum)));
    result.push_back(static_cast<std::int64_t>(sum >> 64));
  }
  return result;
}

void ExactSums::set_words(std::span<const std::int64_t> words) {
  BULKLEY_ASSERT(words.size() == 2 * sums_.size());
  for (std::size_t i = 0; i < sums_.size(); ++i)
    sums_[i] =
        (static_cast<Integer>(words[2 * i + 1]) << 64) | static_cast<Integer>(static_cast<std::uint64_t>(words[2 * i]));
}

}  // namespace bulkley
