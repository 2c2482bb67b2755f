#include "base/binned_sum.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/order_free.hpp"
#include "bulkley/base/pack.hpp"

namespace bulkley {

namespace {

constexpr int bin_bits = 40;
// A slice has at most 2^39 quanta, so that sums of a block are exact in doubles.
constexpr int block_size = 1024;
// From this bin on addends are scaled down by some bins, so that no rounding constant overflows; that changes no slice.
constexpr std::int32_t first_scaled_bin = 20;
constexpr std::int32_t scaled_bins = 8;

// The bin of a number > 0: slices in higher ones are zero, for the number is less than half of their quanta.
std::int32_t bin_of(double magnitude) {
  const int e = std::ilogb(magnitude) + 1;
  return (e >= 0 ? e : e - bin_bits + 1) / bin_bits;
}

// Rounds to multiples of the quantum of a bin. Zero for bins of which doubles are multiples anyway.
double bin_constant(std::int32_t bin) { return std::ldexp(0x1.8p52, bin_bits * bin); }

template <class Real>
Real load_as(const double* from) {
  Real result;
  std::memcpy(&result, from, sizeof result);
  return result;
}

}  // namespace

// `at(i, Real{})`: addend i, or as many from there on as Real holds.
template <class Addends>
void BinnedSum::add_blocks(std::size_t size, Addends at) {
  alignas(sizeof(Pack)) double block[block_size];
  for (std::size_t first = 0; first < size; first += block_size) {
    const std::size_t n = std::min<std::size_t>(block_size, size - first);
    Pack low{}, high{};
    std::size_t i = 0;
    for (; i + n_lanes <= n; i += n_lanes) {
      const Pack x = at(first + i, Pack{});
      store(&block[i], x);
      low = minimum(low, x);
      high = maximum(high, x);
    }
    double largest = 0.0;  // may miss a NaN
    for (int lane = 0; lane < n_lanes; ++lane) largest = std::max({largest, high[lane], -low[lane]});
    for (; i < n; ++i) {
      block[i] = at(first + i, 0.0);
      largest = std::max(largest, std::abs(block[i]));
    }
    for (; i % n_lanes != 0; ++i) block[i] = 0.0;
    add_block({block, i}, largest);
  }
}

void BinnedSum::add(std::span<const double> values) {
  add_blocks(values.size(), [&]<class Real>(std::size_t i, Real) { return load_as<Real>(&values[i]); });
}

void BinnedSum::add_products(std::span<const double> a, std::span<const double> b) {
  BULKLEY_ASSERT(a.size() == b.size());
  add_blocks(a.size(), [&]<class Real>(std::size_t i, Real) { return load_as<Real>(&a[i]) * load_as<Real>(&b[i]); });
}

// Whole packs.
void BinnedSum::add_block(std::span<double> addends, double largest) {
  if (largest == 0.0 || !(largest <= std::numeric_limits<double>::max())) return add_special(addends);
  raise_to(bin_of(largest));
  const bool scaled = top_ >= first_scaled_bin;
  const std::int32_t top = scaled ? top_ - scaled_bins : top_;
  if (scaled)
    for (double& x : addends) x *= 0x1p-320;  // scaled_bins

  Pack packs[n_bins] = {}, constants[n_bins];
  for (int k = 0; k < n_bins; ++k) constants[k] = broadcast<Pack>(bin_constant(top - k));
  for (std::size_t i = 0; i < addends.size(); i += n_lanes) add_slices(load(&addends[i]), constants, packs);
  double sums[n_bins] = {};
  for (int k = 0; k < n_bins; ++k)
    for (int lane = 0; lane < n_lanes; ++lane) sums[k] += packs[k][lane];
  if (!std::isfinite(sums[0] + sums[1] + sums[2])) return add_special(addends);
  for (int k = 0; k < n_bins; ++k)
    sums_[static_cast<std::size_t>(k)] += static_cast<std::int64_t>(std::ldexp(sums[k], -bin_bits * (top - k)));
}

// A block of zeros, or one with numbers that are not finite: finite numbers no longer count then.
void BinnedSum::add_special(std::span<const double> addends) {
  for (const double x : addends) {
    nan_ = nan_ || std::isnan(x);
    positive_infinity_ = positive_infinity_ || x == std::numeric_limits<double>::infinity();
    negative_infinity_ = negative_infinity_ || x == -std::numeric_limits<double>::infinity();
  }
}

void BinnedSum::raise_to(std::int32_t bin) {
  if (bin <= top_) return;
  const std::int32_t shift = bin - top_;
  for (std::int32_t k = n_bins - 1; k >= 0; --k)
    sums_[static_cast<std::size_t>(k)] = k >= shift ? sums_[static_cast<std::size_t>(k - shift)] : 0;
  top_ = bin;
}

void BinnedSum::merge(const BinnedSum& other) {
  BinnedSum raised = other;
  raise_to(other.top_);
  raised.raise_to(top_);
  for (std::size_t k = 0; k < n_bins; ++k) sums_[k] += raised.sums_[k];
  nan_ = nan_ || other.nan_;
  positive_infinity_ = positive_infinity_ || other.positive_infinity_;
  negative_infinity_ = negative_infinity_ || other.negative_infinity_;
}

void BinnedSum::subtract(const BinnedSum& other) {
  BinnedSum negative = other;
  for (Integer& sum : negative.sums_) sum = -sum;
  std::swap(negative.positive_infinity_, negative.negative_infinity_);
  merge(negative);
}

// Bins from the top, low and high word of each; then how far the top bin is above the lowest and, in the three lowest bits,
// what is not finite. All zero for the sum of nothing.
std::array<std::int64_t, BinnedSum::n_words> BinnedSum::words() const {
  std::array<std::int64_t, n_words> result{};
  for (std::size_t k = 0; k < n_bins; ++k) {
    result[2 * k] = static_cast<std::int64_t>(static_cast<std::uint64_t>(sums_[k]));
    result[2 * k + 1] = static_cast<std::int64_t>(sums_[k] >> 64);
  }
  const int special = (nan_ ? 1 : 0) + (positive_infinity_ ? 2 : 0) + (negative_infinity_ ? 4 : 0);
  result[n_words - 1] = 8 * std::int64_t{top_ - lowest_bin} + special;
  return result;
}

BinnedSum BinnedSum::of_words(std::span<const std::int64_t, n_words> words) {
  BinnedSum sum;
  for (std::size_t k = 0; k < n_bins; ++k)
    sum.sums_[k] = static_cast<Integer>(words[2 * k + 1]) * (Integer{1} << 64) +
                   static_cast<Integer>(static_cast<std::uint64_t>(words[2 * k]));
  const std::int64_t last = words[n_words - 1], special = last & 7;
  sum.top_ = lowest_bin + static_cast<std::int32_t>((last - special) / 8);
  sum.nan_ = (special & 1) != 0;
  sum.positive_infinity_ = (special & 2) != 0;
  sum.negative_infinity_ = (special & 4) != 0;
  return sum;
}

double BinnedSum::value() const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (nan_ || (positive_infinity_ && negative_infinity_)) return std::numeric_limits<double>::quiet_NaN();
  if (positive_infinity_ || negative_infinity_) return positive_infinity_ ? infinity : -infinity;

  // Carries: 0 <= low, middle < 2^40.
  constexpr Integer one = 1;
  Integer low = sums_[2], middle = sums_[1], high = sums_[0];
  middle += low >> bin_bits;
  low &= (one << bin_bits) - 1;
  high += middle >> bin_bits;
  middle &= (one << bin_bits) - 1;
  const std::int32_t bottom = bin_bits * (top_ - 2);
  const Integer room = one << 46;
  if (high >= -room && high < room)
    return std::ldexp(static_cast<double>((high << 2 * bin_bits) + (middle << bin_bits) + low), bottom);
  // The lowest bin is beyond 53 bits: it counts only where the rest is halfway between two doubles.
  const Integer upper = (high << bin_bits) + middle;
  return std::ldexp(static_cast<double>(upper | (low != 0 ? 1 : 0)), bottom + bin_bits);
}

}  // namespace bulkley
