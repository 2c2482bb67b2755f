#pragma once
// Lists of numbers from all ranks to the root, however long.

#include <functional>
#include <vector>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// The ranks' values one after the other, in rank order, on the root; nothing elsewhere. Any number of values: they travel
/// in messages that an int can count. Number: a plain type without padding. Collective.
template <class Number>
std::vector<Number> gather_values(const Comm& comm, const std::vector<Number>& local);

/// The root's `values` on every rank; of the right size already. Collective.
template <class Number>
void broadcast_values(const Comm& comm, std::vector<Number>& values);

namespace detail {
/// On the root: the bytes of all ranks one after the other, resized by `room(bytes)`, which returns where they go.
void gather_bytes(const Comm& comm, const void* from, std::size_t size, const std::function<void*(std::size_t)>& room);
void broadcast_bytes(const Comm& comm, void* bytes, std::size_t size);
}  // namespace detail

template <class Number>
std::vector<Number> gather_values(const Comm& comm, const std::vector<Number>& local) {
  std::vector<Number> all;
  detail::gather_bytes(comm, local.data(), local.size() * sizeof(Number), [&](std::size_t bytes) {
    all.resize(bytes / sizeof(Number));
    return static_cast<void*>(all.data());
  });
  return all;
}

template <class Number>
void broadcast_values(const Comm& comm, std::vector<Number>& values) {
  detail::broadcast_bytes(comm, values.data(), values.size() * sizeof(Number));
}

}  // namespace bulkley
