#pragma once
// Lists of numbers from all ranks to the root, however long.

#include <vector>

#include "bulkley/base/parallel.hpp"

namespace bulkley {

/// The ranks' values one after the other, in rank order, on the root; nothing elsewhere. Any number of values: they travel in
/// messages that an int can count. Number: a plain type without padding. Collective.
template <class Number>
std::vector<Number> gather_values(const Comm& comm, const std::vector<Number>& local);

/// The root's `values` on every rank; of the right size already. Collective.
template <class Number>
void broadcast_values(const Comm& comm, std::vector<Number>& values);

namespace detail {
/// Bytes of all ranks on the root, at `to` (room for the sum of `sizes`, which the root knows by rank). Collective.
void gather_bytes(const Comm& comm, const void* from, std::size_t size, void* to, const std::vector<GlobalIndex>& sizes);
std::vector<GlobalIndex> gather_sizes(const Comm& comm, std::size_t size);
void broadcast_bytes(const Comm& comm, void* bytes, std::size_t size);
}  // namespace detail

template <class Number>
std::vector<Number> gather_values(const Comm& comm, const std::vector<Number>& local) {
  const std::size_t bytes = local.size() * sizeof(Number);
  const std::vector<GlobalIndex> sizes = detail::gather_sizes(comm, bytes);
  std::size_t total = 0;
  for (const GlobalIndex size : sizes) total += static_cast<std::size_t>(size);
  std::vector<Number> all(total / sizeof(Number));
  detail::gather_bytes(comm, local.data(), bytes, all.data(), sizes);
  return all;
}

template <class Number>
void broadcast_values(const Comm& comm, std::vector<Number>& values) {
  detail::broadcast_bytes(comm, values.data(), values.size() * sizeof(Number));
}

}  // namespace bulkley
