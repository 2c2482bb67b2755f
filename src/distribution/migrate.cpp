#include "distribution/migrate.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <vector>

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

template <std::size_t size>
void gather_elements(const std::byte* column, std::span<const Departure> message, std::byte* to) {
  for (const Departure& d : message) {
    std::memcpy(to, column + static_cast<std::size_t>(d.particle) * size, size);
    to += size;
  }
}

// What a message begins with; then one column of its particles after the other, in the order of the field table.
struct Header {
  std::int64_t n_particles;
  std::int64_t generation;  // of the sender's neighbours: of the map that it follows
};

std::vector<std::byte> pack(const ParticleSet& particles, std::span<const Departure> departures, std::int64_t generation,
                            std::size_t bytes_per_particle) {
  std::vector<std::byte> message(sizeof(Header) + departures.size() * bytes_per_particle);
  const Header header{static_cast<std::int64_t>(departures.size()), generation};
  std::memcpy(message.data(), &header, sizeof header);
  std::byte* to = message.data() + sizeof header;
  for (std::size_t c = 0; c < particles.columns().size(); ++c) {
    const ParticleSet::Column& column = particles.columns()[c];
    if (!column.moves) continue;
    if (column.element_size == 1)
      gather_elements<1>(particles.data(c), departures, to);
    else
      gather_elements<8>(particles.data(c), departures, to);
    to += departures.size() * column.element_size;
  }
  return message;
}

void unpack(const std::byte* from, std::size_t n, LocalIndex first, ParticleSet& particles) {
  for (std::size_t c = 0; c < particles.columns().size(); ++c) {
    const ParticleSet::Column& column = particles.columns()[c];
    if (!column.moves) continue;
    const std::size_t bytes = n * column.element_size;
    std::memcpy(particles.data(c) + static_cast<std::size_t>(first) * column.element_size, from, bytes);
    from += bytes;
  }
}

// In parts of at most message_limit, of which MPI keeps the order.
void send(const Comm& comm, const std::vector<std::byte>& message, int rank, std::vector<MPI_Request>& requests) {
  for (std::size_t at = 0; at < message.size(); at += message_limit) {
    const int bytes = static_cast<int>(std::min(message.size() - at, message_limit));
    BULKLEY_MPI(
        MPI_Isend(message.data() + at, bytes, MPI_BYTE, rank, message_tag::migrants, comm.get(), &requests.emplace_back()));
  }
}

// The whole message of a neighbour.
std::vector<std::byte> receive(const Comm& comm, int rank, std::size_t bytes_per_particle) {
  MPI_Message handle;
  MPI_Status status;
  int bytes = 0;
  BULKLEY_MPI(MPI_Mprobe(rank, message_tag::migrants, comm.get(), &handle, &status));
  BULKLEY_MPI(MPI_Get_count(&status, MPI_BYTE, &bytes));
  std::vector<std::byte> message(static_cast<std::size_t>(bytes));
  BULKLEY_MPI(MPI_Mrecv(message.data(), bytes, MPI_BYTE, &handle, MPI_STATUS_IGNORE));
  Header header;
  std::memcpy(&header, message.data(), sizeof header);
  std::size_t at = message.size();
  message.resize(sizeof header + static_cast<std::size_t>(header.n_particles) * bytes_per_particle);
  for (; at < message.size(); at += message_limit) {
    bytes = static_cast<int>(std::min(message.size() - at, message_limit));
    BULKLEY_MPI(MPI_Recv(message.data() + at, bytes, MPI_BYTE, rank, message_tag::migrants, comm.get(), MPI_STATUS_IGNORE));
  }
  return message;
}

void remove(std::span<const Departure> departures, ParticleSet& particles) {
  std::vector<LocalIndex> gone;
  gone.reserve(departures.size());
  for (const Departure& d : departures) gone.push_back(d.particle);
  std::sort(gone.begin(), gone.end());
  BULKLEY_ASSERT(std::adjacent_find(gone.begin(), gone.end()) == gone.end());
  particles.remove(gone);
}

LocalIndex exchange_particles(const Comm& comm, const Neighbours& neighbours, std::span<const Departure> departures,
                              ParticleSet& particles) {
  std::vector<Departure> leaving(departures.begin(), departures.end());
  std::stable_sort(leaving.begin(), leaving.end(), [](const Departure& a, const Departure& b) { return a.rank < b.rank; });
  const std::size_t bytes_per_particle = bytes_moving(particles);
  std::vector<std::vector<std::byte>> sent;
  sent.reserve(neighbours.ranks().size());
  std::vector<MPI_Request> requests;
  std::span<const Departure> left = leaving;
  for (const int rank : neighbours.ranks()) {
    const auto end = std::find_if(left.begin(), left.end(), [&](const Departure& d) { return d.rank != rank; });
    const auto here = left.first(static_cast<std::size_t>(end - left.begin()));
    left = left.subspan(here.size());
    sent.push_back(pack(particles, here, neighbours.generation(), bytes_per_particle));
    send(comm, sent.back(), rank, requests);
  }
  BULKLEY_ASSERT(left.empty());  // all went to neighbours
  if (!leaving.empty()) remove(leaving, particles);
  const LocalIndex n_stayed = particles.size();
  for (const int rank : neighbours.ranks()) {
    const std::vector<std::byte> message = receive(comm, rank, bytes_per_particle);
    Header header;
    std::memcpy(&header, message.data(), sizeof header);
    expect_number(comm, "map", rank, header.generation, neighbours.generation());
    if (header.n_particles == 0) continue;
    const LocalIndex first = particles.size();
    particles.resize(ParticleSet::checked_size(first + header.n_particles));
    unpack(message.data() + sizeof header, static_cast<std::size_t>(header.n_particles), first, particles);
  }
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  return particles.size() - n_stayed;
}

}  // namespace

LocalIndex migrate(const Comm& comm, const Neighbours& neighbours, std::span<const Departure> departures,
                   ParticleSet& particles) {
  // What goes wrong on one rank in the middle of an exchange cannot be told to the others, which wait for its messages.
  try {
    return exchange_particles(comm, neighbours, departures, particles);
  } catch (const std::bad_alloc&) {
    abort_all_ranks("out of memory while particles migrate", __FILE__, __LINE__);
  } catch (const RunError& error) {
    abort_all_ranks(error.what(), __FILE__, __LINE__);
  }
}

}  // namespace bulkley
