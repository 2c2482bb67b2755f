#pragma once
// Sums whose bits depend neither on the order of their addends nor on how ranks share them, for addends whose magnitude is known
// roughly: integers of 128 bits times one power of two. Adding such integers is exact.

#include <cstdint>
#include <span>
#include <vector>

namespace bulkley {

class ExactSums {
 public:
  ExactSums() = default;
  /// `magnitude`: about that of the addends; the unit is 2^-70 of it, with room for 2^57 of them. The same on every rank.
  ExactSums(std::size_t n_sums, double magnitude);

  std::size_t size() const { return sums_.size(); }
  void clear() { sums_.assign(sums_.size(), 0); }
  /// Adds to sum `n`, rounded to the unit. What is not finite is left out: the step that it belongs to fails.
  void add(std::size_t n, double value);
  /// Adds sums of the same number and unit.
  void add(const ExactSums& other);
  double value(std::size_t n) const;

  /// All sums as 64-bit words, low and high of each in turn; `set_words` takes them back.
  std::vector<std::int64_t> words() const;
  void set_words(std::span<const std::int64_t> words);

 private:
  __extension__ using Integer = __int128;

  std::vector<Integer> sums_;
  int exponent_ = 0;
};

}  // namespace bulkley
