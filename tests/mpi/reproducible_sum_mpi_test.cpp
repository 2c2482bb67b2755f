// ranks: 1 2 3 5 8
// Sums over ranks whose bits depend neither on the number of ranks nor on who holds what.
#include "parallel/reproducible_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "bulkley/parallel/petsc.hpp"

namespace bulkley::reproducible_sum_mpi_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Pairs {
  std::vector<double> a, b;
  void push_back(double x, double y) {
    a.push_back(x);
    b.push_back(y);
  }
};

// Factors of the exponents' ranges that dot products meet, and of those that they should not.
std::vector<Pairs> cases() {
  std::mt19937_64 generator(3);
  const auto number = [&](double lowest, double highest) {
    const double exponent = std::uniform_real_distribution<double>(lowest, highest)(generator);
    const double mantissa = std::uniform_real_distribution<double>(1.0, 2.0)(generator);
    return (generator() % 2 ? 1.0 : -1.0) * std::ldexp(mantissa, static_cast<int>(exponent));
  };
  std::vector<Pairs> result(7);
  for (int i = 0; i < 20000; ++i) {
    result[0].push_back(number(-3.0, 3.0), number(-3.0, 3.0));
    result[1].push_back(number(-498.0, 498.0), number(-498.0, 498.0));    // 1e-300 to 1e300
    result[2].push_back(number(-600.0, -480.0), number(-600.0, -480.0));  // normal, subnormal and lost
    result[3].push_back(number(480.0, 510.0), number(480.0, 510.0));      // partial sums of a loop would overflow
    const double x = number(-20.0, 20.0), y = number(-20.0, 20.0);        // all cancels but one
    result[4].push_back(x, y);
    result[4].push_back(-x, y);
    result[5].push_back(i % 2 ? 0.0 : -0.0, number(-3.0, 3.0));
    result[6].push_back(number(-1074.0, -1022.0), 1.0);
  }
  result[4].push_back(0x1p-30, 3.0);
  return result;
}

class ReproducibleSumTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD}, self{MPI_COMM_SELF};

  // This rank's share of the pairs, in an order of its own. Everyone draws the same owners.
  Pairs share_of(const Pairs& all, unsigned seed) const {
    std::mt19937 owners(seed), order(seed + 1000u * static_cast<unsigned>(comm.rank() + 1));
    std::vector<std::size_t> mine;
    const unsigned n_owners = seed % 3 == 0 ? 1 : comm.size();  // all on one rank, too
    for (std::size_t i = 0; i < all.a.size(); ++i)
      if (static_cast<int>((owners() % n_owners + seed) % comm.size()) == comm.rank()) mine.push_back(i);
    std::shuffle(mine.begin(), mine.end(), order);
    Pairs share;
    for (const std::size_t i : mine) share.push_back(all.a[i], all.b[i]);
    return share;
  }
};

std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

TEST_F(ReproducibleSumTest, DotsHaveTheSameBitsHoweverTheDataIsDivided) {
  for (const Pairs& all : cases()) {
    const double alone = reproducible_dot(self, all.a, all.b), sum_alone = reproducible_sum(self, all.a);
    EXPECT_TRUE(std::isfinite(alone));
    for (unsigned seed = 0; seed < 8; ++seed) {
      const Pairs mine = share_of(all, seed);
      EXPECT_EQ(bits(reproducible_dot(comm, mine.a, mine.b)), bits(alone)) << alone;
      EXPECT_EQ(bits(reproducible_sum(comm, mine.a)), bits(sum_alone));
    }
  }
}

TEST_F(ReproducibleSumTest, CancellationLeavesTheRest) {
  const Pairs all = cases()[4], mine = share_of(all, 1);
  EXPECT_EQ(reproducible_dot(comm, mine.a, mine.b), 0x3p-30);
}

TEST_F(ReproducibleSumTest, NoRankNeedsToHaveAny) {
  EXPECT_EQ(bits(reproducible_sum(comm, {})), bits(0.0));
  const std::vector<double> one{-2.5};
  EXPECT_EQ(reproducible_sum(comm, comm.rank() == comm.size() - 1 ? one : std::vector<double>{}), -2.5);
}

TEST_F(ReproducibleSumTest, WhatIsNotFiniteReachesEveryRank) {
  std::vector<double> values(2000, 1.0);
  const bool last = comm.rank() == comm.size() - 1;
  if (last) values[1500] = -infinity;
  EXPECT_EQ(reproducible_sum(comm, values), -infinity);
  if (comm.rank() == 0) values[7] = infinity;
  EXPECT_TRUE(std::isnan(reproducible_sum(comm, values)));
  values.assign(2000, 0.0);
  if (last) values[3] = std::nan("");
  EXPECT_TRUE(std::isnan(reproducible_sum(comm, values)));
}

TEST_F(ReproducibleSumTest, SeveralSumsTakeOneReduction) {
  const std::vector<Pairs> all = cases();
  std::vector<BinnedSum> sums(all.size());
  for (std::size_t n = 0; n < all.size(); ++n) {
    const Pairs mine = share_of(all[n], 4);
    sums[n].add_products(mine.a, mine.b);
  }
  merge_global(comm, sums);
  for (std::size_t n = 0; n < all.size(); ++n)
    EXPECT_EQ(bits(sums[n].value()), bits(reproducible_dot(self, all[n].a, all[n].b)));
}

// --- impulses on colliders -------------------------------------------------------------------------------------------

// Large, small and of both signs, so that carries run through all words.
TEST_F(ReproducibleSumTest, ContactImpulsesAreAddedExactly) {
  std::mt19937_64 generator(9);
  ContactImpulses all(3, 1.0, 2.0), mine = all;
  const auto random_vector = [&] {
    Vec3 v;
    for (int a = 0; a < 3; ++a)
      v[a] =
          std::ldexp(std::uniform_real_distribution<double>(-1.0, 1.0)(generator), static_cast<int>(generator() % 110) - 65);
    return v;
  };
  for (int i = 0; i < 3000; ++i) {
    const Vec3 impulse = random_vector(), arm = random_vector();
    all.add(i % 3, impulse, arm);
    if (static_cast<int>(generator() % static_cast<unsigned>(comm.size())) == comm.rank()) mine.add(i % 3, impulse, arm);
  }
  EXPECT_EQ(sum_global(comm, mine).words(), all.words());

  // -1 unit on every rank but the first, which has them all: a borrow through 128 bits and back.
  ContactImpulses units(1, 1.0, 1.0);
  const std::int64_t n_others = comm.size() - 1;
  std::vector<std::int64_t> words(12, 0);
  for (std::size_t w = 0; w < words.size(); w += 2) {
    words[w] = comm.is_root() ? n_others : -1;
    words[w + 1] = comm.is_root() ? 0 : -1;
  }
  units.set_words(words);
  EXPECT_EQ(sum_global(comm, units).words(), std::vector<std::int64_t>(12, 0));
}

TEST_F(ReproducibleSumTest, NoCollidersNoImpulses) {
  const ContactImpulses none(0, 1.0, 1.0);
  EXPECT_EQ(sum_global(comm, none).n_colliders(), 0u);
}

}  // namespace
}  // namespace bulkley::reproducible_sum_mpi_test
