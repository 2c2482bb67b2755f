#pragma once
// A sum of doubles of any magnitudes whose bits depend neither on their order nor on how they are divided (docs/theory.md,
// "Order-free sums"; the bins are those of Demmel & Nguyen 2015, indexed summation).
//
// The exponents of doubles are divided into bins of 40 bits, whose borders are fixed. Every addend is cut into slices, one a
// bin: bin t keeps multiples of its quantum 2^(40 t). A slice depends on the addend alone. The slices of the three bins
// below the largest addend are summed in integers of 128 bits, which is exact; smaller bins are dropped.
//
// Accuracy: |value - sum| <= n 2^-80 max|addend| + 2^-53 |sum|. A plain loop guarantees n 2^-53 sum|addend|.
// Cost: one pass. Blocks of 1024 addends are read into the first-level cache, measured and then cut; 14 vector operations a
// pack.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bulkley {

class BinnedSum {
 public:
  /// Adds numbers, or the rounded products a[i] b[i]. Precondition: spans of one size.
  void add(std::span<const double> values);
  void add_products(std::span<const double> a, std::span<const double> b);
  void merge(const BinnedSum& other);
  /// Takes away what `other` has summed, exactly, like adding the negatives of its addends.
  void subtract(const BinnedSum& other);

  /// The sum of the slices, rounded once; never -0. A NaN, or infinities of both signs, give NaN; infinities of one sign,
  /// that infinity. A finite sum beyond the largest double gives infinity, but no partial sum does. At most 2^47 addends.
  double value() const;

  /// The sum as 64-bit words, from which `of_words` makes it again, bit for bit. For checkpoints.
  static constexpr std::size_t n_words = 7;
  std::array<std::int64_t, n_words> words() const;
  static BinnedSum of_words(std::span<const std::int64_t, n_words> words);

 private:
  __extension__ using Integer = __int128;
  static constexpr int n_bins = 3;
  static constexpr std::int32_t lowest_bin = -28;  // below the smallest subnormal's

  template <class Addends>
  void add_blocks(std::size_t size, Addends at);
  void add_block(std::span<double> addends, double largest);
  void add_special(std::span<const double> addends);
  void raise_to(std::int32_t bin);

  std::array<Integer, n_bins> sums_{};  ///< of slices, in quanta of bins top_, top_ - 1, top_ - 2
  std::int32_t top_ = lowest_bin;
  bool nan_ = false, positive_infinity_ = false, negative_infinity_ = false;
};

}  // namespace bulkley
