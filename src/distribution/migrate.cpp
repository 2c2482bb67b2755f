#include "distribution/migrate.hpp"

#include <petscsys.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <vector>

#include "bulkley/parallel/petsc.hpp"
#include "distribution/message_sizes.hpp"
#include "distribution/message_tags.hpp"

namespace bulkley {

namespace {

constexpr std::size_t message_limit = std::size_t{64} << 20;  // bytes; well below what an int counts

std::size_t bytes_moving(const ParticleSet& particles) {
  std::size_t bytes = 0;
  for (const ParticleSet::Column& column : particles.columns())
    if (column.moves) bytes += column.element_size;
  return bytes;
}

std::vector<MessageSize> messages_of(const std::vector<Departure>& departures) {
  std::vector<MessageSize> messages;
  for (const Departure& d : departures) {
    if (messages.empty() || messages.back().rank != d.rank) messages.push_back({d.rank, 0});
    ++messages.back().count;
  }
  return messages;
}

template <std::size_t size>
void gather_elements(const std::byte* column, std::span<const Departure> message, std::byte* to) {
  for (const Departure& d : message) {
    std::memcpy(to, column + static_cast<std::size_t>(d.particle) * size, size);
    to += size;
  }
}

// A message is one column after the other, in the order of the field table.
std::vector<std::byte> pack(const ParticleSet& particles, std::span<const Departure> departures,
                            const std::vector<MessageSize>& messages) {
  std::vector<std::byte> buffer(departures.size() * bytes_moving(particles));
  std::byte* to = buffer.data();
  for (const MessageSize& message : messages) {
    const auto here = departures.first(static_cast<std::size_t>(message.count));
    departures = departures.subspan(here.size());
    for (std::size_t c = 0; c < particles.columns().size(); ++c) {
      const ParticleSet::Column& column = particles.columns()[c];
      if (!column.moves) continue;
      if (column.element_size == 1)
        gather_elements<1>(particles.data(c), here, to);
      else
        gather_elements<8>(particles.data(c), here, to);
      to += here.size() * column.element_size;
    }
  }
  return buffer;
}

void unpack(const std::vector<std::byte>& buffer, const std::vector<MessageSize>& messages, LocalIndex first,
            ParticleSet& particles) {
  const std::byte* from = buffer.data();
  std::size_t at = static_cast<std::size_t>(first);
  for (const MessageSize& message : messages) {
    for (std::size_t c = 0; c < particles.columns().size(); ++c) {
      const ParticleSet::Column& column = particles.columns()[c];
      if (!column.moves) continue;
      const std::size_t bytes = static_cast<std::size_t>(message.count) * column.element_size;
      std::memcpy(particles.data(c) + at * column.element_size, from, bytes);
      from += bytes;
    }
    at += static_cast<std::size_t>(message.count);
  }
}

// Posts `post(start, bytes, rank)` for every message; both sides split alike, and MPI keeps their order.
template <class Post>
void for_each_message(const std::vector<MessageSize>& messages, std::size_t bytes_per_particle, std::byte* buffer,
                      Post post) {
  for (const MessageSize& message : messages) {
    std::size_t left = static_cast<std::size_t>(message.count) * bytes_per_particle;
    while (left > 0) {
      const std::size_t bytes = std::min(left, message_limit);
      post(buffer, static_cast<int>(bytes), message.rank);
      buffer += bytes;
      left -= bytes;
    }
  }
}

void remove(std::span<const Departure> departures, ParticleSet& particles) {
  std::vector<LocalIndex> gone;
  gone.reserve(departures.size());
  for (const Departure& d : departures) gone.push_back(d.particle);
  std::sort(gone.begin(), gone.end());
  BULKLEY_ASSERT(std::adjacent_find(gone.begin(), gone.end()) == gone.end());
  particles.remove(gone);
}

LocalIndex exchange_particles(const Comm& comm, std::span<const Departure> departures, ParticleSet& particles) {
  std::vector<Departure> leaving(departures.begin(), departures.end());
  std::stable_sort(leaving.begin(), leaving.end(), [](const Departure& a, const Departure& b) { return a.rank < b.rank; });
  const std::vector<MessageSize> outgoing = messages_of(leaving);
  const std::vector<MessageSize> incoming = exchange_counts(comm, outgoing);
  if (outgoing.empty() && incoming.empty()) return 0;

  GlobalIndex n_arriving = 0;
  for (const MessageSize& message : incoming) n_arriving += message.count;
  const LocalIndex n_after =
      ParticleSet::checked_size(particles.size() - static_cast<GlobalIndex>(leaving.size()) + n_arriving);

  const std::size_t bytes_per_particle = bytes_moving(particles);
  std::vector<std::byte> sent = pack(particles, leaving, outgoing);
  std::vector<std::byte> received(static_cast<std::size_t>(n_arriving) * bytes_per_particle);
  std::vector<MPI_Request> requests;
  for_each_message(incoming, bytes_per_particle, received.data(), [&](std::byte* start, int bytes, int rank) {
    BULKLEY_MPI(MPI_Irecv(start, bytes, MPI_BYTE, rank, message_tag::migrants, comm.get(), &requests.emplace_back()));
  });
  for_each_message(outgoing, bytes_per_particle, sent.data(), [&](std::byte* start, int bytes, int rank) {
    BULKLEY_MPI(MPI_Isend(start, bytes, MPI_BYTE, rank, message_tag::migrants, comm.get(), &requests.emplace_back()));
  });
  remove(leaving, particles);
  const LocalIndex first_arrival = particles.size();
  particles.resize(n_after);
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  unpack(received, incoming, first_arrival, particles);
  return static_cast<LocalIndex>(n_arriving);
}

}  // namespace

LocalIndex migrate(const Comm& comm, std::span<const Departure> departures, ParticleSet& particles) {
  // What goes wrong on one rank in the middle of an exchange cannot be told to the others, which wait for its messages.
  try {
    return exchange_particles(comm, departures, particles);
  } catch (const std::bad_alloc&) {
    abort_all_ranks("out of memory while particles migrate", __FILE__, __LINE__);
  } catch (const RunError& error) {
    abort_all_ranks(error.what(), __FILE__, __LINE__);
  }
}

}  // namespace bulkley
