#include "parallel/reproducible_sum.hpp"

#include <cstring>
#include <type_traits>
#include <vector>

namespace bulkley {

namespace {

// Reductions of items that are merged in place: `Item` has merge(const Item&).
template <class Item>
void merge_items(void* from, void* into, int* count, MPI_Datatype*) {
  for (int k = 0; k < *count; ++k) {
    Item a, b;
    std::memcpy(&a, static_cast<char*>(from) + static_cast<std::size_t>(k) * sizeof(Item), sizeof a);
    char* const at = static_cast<char*>(into) + static_cast<std::size_t>(k) * sizeof(Item);
    std::memcpy(&b, at, sizeof b);
    b.merge(a);
    std::memcpy(at, &b, sizeof b);
  }
}

template <class Item>
void merge_over_ranks(const Comm& comm, std::span<Item> items) {
  static_assert(std::is_trivially_copyable_v<Item>, "items travel as bytes");
  MPI_Datatype type = MPI_DATATYPE_NULL;
  MPI_Op op = MPI_OP_NULL;
  BULKLEY_MPI(MPI_Type_contiguous(sizeof(Item), MPI_BYTE, &type));
  BULKLEY_MPI(MPI_Type_commit(&type));
  BULKLEY_MPI(MPI_Op_create(merge_items<Item>, /*commutative=*/1, &op));
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, items.data(), static_cast<int>(items.size()), type, op, comm.get()));
  BULKLEY_MPI(MPI_Op_free(&op));
  BULKLEY_MPI(MPI_Type_free(&type));
}

// 128 bits as ContactImpulses::words gives them, low and high.
struct WideInteger {
  std::int64_t low, high;

  void merge(const WideInteger& other) {
    const auto sum = static_cast<std::uint64_t>(low) + static_cast<std::uint64_t>(other.low);
    const std::uint64_t carry = sum < static_cast<std::uint64_t>(low) ? 1 : 0;
    low = static_cast<std::int64_t>(sum);
    high = static_cast<std::int64_t>(static_cast<std::uint64_t>(high) + static_cast<std::uint64_t>(other.high) + carry);
  }
};

}  // namespace

void merge_global(const Comm& comm, std::span<BinnedSum> sums) { merge_over_ranks(comm, sums); }

double reproducible_sum(const Comm& comm, std::span<const double> values) {
  BinnedSum sum;
  sum.add(values);
  merge_global(comm, {&sum, 1});
  return sum.value();
}

double reproducible_dot(const Comm& comm, std::span<const double> a, std::span<const double> b) {
  BinnedSum sum;
  sum.add_products(a, b);
  merge_global(comm, {&sum, 1});
  return sum.value();
}

namespace {

template <class Sums>
Sums sum_words(const Comm& comm, const Sums& local) {
  std::vector<std::int64_t> words = local.words();
  std::vector<WideInteger> sums(words.size() / 2);
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = {words[2 * i], words[2 * i + 1]};
  merge_over_ranks<WideInteger>(comm, sums);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    words[2 * i] = sums[i].low;
    words[2 * i + 1] = sums[i].high;
  }
  Sums total = local;
  total.set_words(words);
  return total;
}

}  // namespace

ContactImpulses sum_global(const Comm& comm, const ContactImpulses& local) { return sum_words(comm, local); }
ExactSums sum_global(const Comm& comm, const ExactSums& local) { return sum_words(comm, local); }

}  // namespace bulkley
