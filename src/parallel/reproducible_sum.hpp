#pragma once
// Order-free sums over ranks, all of them: the same bits on any number of ranks and for any division of the data
// (docs/theory.md, "Order-free sums").
//
//   reproducible_sum, _dot   numbers of any magnitudes, one reduction: scalars of solvers
//   merge_global             BinnedSums that ranks have kept: history.csv
//   sum_global (128 bits)    integers: the impulses on colliders, the momenta that rigid bodies share with nodes
//
// Nodal sums of a step have machinery of their own for their speed (kernel/p2g.hpp, kernel/scalar_deposit.hpp).

#include <span>

#include "base/binned_sum.hpp"
#include "bulkley/parallel/comm.hpp"
#include "grid/contact_impulse.hpp"
#include "grid/exact_sums.hpp"

namespace bulkley {

/// Merges each of the sums over ranks, in one reduction of 64 bytes a sum. Collective.
void merge_global(const Comm& comm, std::span<BinnedSum> sums);

/// The sum of all ranks' values, and of a[i] b[i], each product rounded to a double. Error, n being the number of addends of
/// all ranks: at most n 2^-80 max|addend| + 2^-53 |sum| beyond the rounding of the products, less than a plain loop's for n
/// < 2^27 even if one addend outweighs all others. Time: 1.1 to 1.7 of a vectorised plain dot product's for arrays that no
/// cache holds; one reduction. Numbers that are not finite: BinnedSum::value. Not -0. Preconditions: a and b of one size.
/// Collective.
double reproducible_sum(const Comm& comm, std::span<const double> values);
double reproducible_dot(const Comm& comm, std::span<const double> a, std::span<const double> b);

/// The sums of all ranks. Exact. Precondition: made the same on every rank. Collective.
ContactImpulses sum_global(const Comm& comm, const ContactImpulses& local);
ExactSums sum_global(const Comm& comm, const ExactSums& local);

}  // namespace bulkley
