#pragma once
// One hash for everything that needs numbers without a pattern.

#include <cstdint>

namespace bulkley {

/// One round of the splitmix64 generator (Steele, Lea & Flood 2014): a well-mixed hash of 64 bits. Seeding and the choice of
/// particles for output depend on its values. Not collective.
constexpr std::uint64_t splitmix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

}  // namespace bulkley
