#include "distribution/cell_grid.hpp"

#include <algorithm>
#include <map>

#include "bulkley/base/error.hpp"
#include "distribution/message_sizes.hpp"

namespace bulkley {

namespace {

constexpr int tag = 5;

// Node a of the stencil of the cell at `place` of a tile: which of the tiles at {0, 1}^3 above it, and the place there.
struct StencilNode {
  std::uint8_t above, place;
};

template <int s>
constexpr auto make_stencils() {
  std::array<std::array<StencilNode, s * s * s>, tile_nodes> table{};
  for (int place = 0; place < tile_nodes; ++place)
    for (int a = 0; a < s * s * s; ++a) {
      const int at[3] = {place / 16 + a / (s * s), place / 4 % 4 + a / s % s, place % 4 + a % s};
      int above = 0, in_tile = 0;
      for (const int i : at) {
        above = 2 * above + i / tile_width;
        in_tile = tile_width * in_tile + i % tile_width;
      }
      table[static_cast<std::size_t>(place)][static_cast<std::size_t>(a)] = {static_cast<std::uint8_t>(above),
                                                                             static_cast<std::uint8_t>(in_tile)};
    }
  return table;
}
constexpr auto stencils_3 = make_stencils<3>();
constexpr auto stencils_4 = make_stencils<4>();

std::span<const StencilNode> stencil_of(SplineOrder order, int place) {
  const auto p = static_cast<std::size_t>(place);
  return order == SplineOrder::quadratic ? std::span<const StencilNode>(stencils_3[p])
                                         : std::span<const StencilNode>(stencils_4[p]);
}

Int3 in_tile(const Int3& tile, int place) {
  return {tile[0] * tile_width + place / 16, tile[1] * tile_width + place / 4 % 4, tile[2] * tile_width + place % 4};
}

}  // namespace

CellGrid::CellGrid(const Comm& comm, const ParticleGrid& particles, const Faces& faces) : grid_(particles.grid()) {
  tiles_ = particles.layout().tiles();
  n_own_ids_ = static_cast<LocalIndex>(tiles_.size()) * tile_nodes;
  collective_guard(comm, [&] { find_nodes(particles, faces); });
  ask_for_cells(comm, particles);
  for (const TileIndex tile : tiles_) above_.push_back(node_tiles_above(grid_.tile_coordinates(tile)));
  sort_cells();
}

LocalIndex CellGrid::node_tile(TileIndex tile) const {
  const auto found = std::lower_bound(node_tiles_.begin(), node_tiles_.end(), tile);
  return found != node_tiles_.end() && *found == tile ? static_cast<LocalIndex>(found - node_tiles_.begin()) : -1;
}

std::array<LocalIndex, 8> CellGrid::node_tiles_above(const Int3& tile) const {
  std::array<LocalIndex, 8> above;
  for (int b = 0; b < 8; ++b) {
    const TileIndex there = grid_.neighbour(tile, {b / 4, b / 2 % 2, b % 2});
    above[static_cast<std::size_t>(b)] = there < 0 ? -1 : node_tile(there);
  }
  return above;
}

LocalIndex CellGrid::node_number(const Int3& node) const {
  return node_tile(grid_.tile_of_node(node)) * tile_nodes + node[0] % 4 * 16 + node[1] % 4 * 4 + node[2] % 4;
}

Int3 CellGrid::node_position(LocalIndex node) const {
  return in_tile(grid_.tile_coordinates(node_tiles_[static_cast<std::size_t>(node / tile_nodes)]), node % tile_nodes);
}

// Whether it was not among the complete nodes before.
bool CellGrid::need(LocalIndex node) {
  std::uint64_t& bits = needed_[static_cast<std::size_t>(node / tile_nodes)];
  const std::uint64_t bit = std::uint64_t{1} << (node % tile_nodes);
  const bool is_new = !(bits & bit);
  bits |= bit;
  return is_new;
}

// The nodes that are complete: those that this rank's cells may reach, those that it owns, and those of which they are images.
void CellGrid::find_nodes(const ParticleGrid& particles, const Faces& faces) {
  const std::vector<Int3> active = particles.exchange().active_positions();
  const auto add_tiles_above = [&](TileIndex tile) {
    for (int b = 0; b < 8; ++b)
      if (const TileIndex there = grid_.neighbour(grid_.tile_coordinates(tile), {b / 4, b / 2 % 2, b % 2}); there >= 0)
        node_tiles_.push_back(there);
  };
  std::vector<TileIndex> reached = tiles_;
  for (const Int3& node : active) reached.push_back(grid_.tile_of_node(node));
  std::sort(reached.begin(), reached.end());
  reached.erase(std::unique(reached.begin(), reached.end()), reached.end());
  for (const TileIndex tile : reached) add_tiles_above(tile);
  // A node behind an upper wall may be in the tile after that of its image.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (behaviour(faces[2 * axis + 1].kind).behind == NodesBehind::free) continue;
    const int wall = grid_.node_offset(static_cast<int>(axis)) + grid_.n_cells[axis];
    for (std::size_t t = 0, n = node_tiles_.size(); t < n; ++t) {
      Int3 tile = grid_.tile_coordinates(node_tiles_[t]);
      if (tile[axis] != (wall - 1) / tile_width) continue;
      tile[axis] = (wall + 1) / tile_width;
      node_tiles_.push_back(grid_.tile_index(tile));
    }
  }
  std::sort(node_tiles_.begin(), node_tiles_.end());
  node_tiles_.erase(std::unique(node_tiles_.begin(), node_tiles_.end()), node_tiles_.end());
  needed_.assign(node_tiles_.size(), 0);

  const std::span<const LocalIndex> places = particles.exchange().active_nodes();
  for (std::size_t n = 0; n < active.size(); ++n) {
    const LocalIndex node = node_number(active[n]);
    owned_.push_back({node, places[n]});
    need(node);
  }
  const int w = footprint_width(grid_.order);
  const std::span<const LocalIndex> rows = particles.layout().row_offsets();
  std::size_t row = 0;
  for (const TileIndex tile : particles.layout().tiles()) {
    const Int3 first = grid_.tile_coordinates(tile);
    for (int i = 0; i < w; ++i)
      for (int j = 0; j < w; ++j, ++row)
        for (int k = 0; k < w; ++k) {
          Int3 node{first[0] * tile_width + i, first[1] * tile_width + j, first[2] * tile_width + k};
          bool exists = true;
          for (int a = 0; a < 3; ++a) {
            const int n = grid_.n_nodes(a);
            if (grid_.periodic[static_cast<std::size_t>(a)] && node[static_cast<std::size_t>(a)] >= n)
              node[static_cast<std::size_t>(a)] -= n;
            exists = exists && node[static_cast<std::size_t>(a)] < n;
          }
          if (!exists) continue;
          if (const LocalIndex here = node_number(node); need(here)) in_pool_.push_back({here, rows[row] + k});
        }
  }
  add_images(faces);
  for (std::size_t t = 0; t < needed_.size(); ++t)
    for (int place = 0; place < tile_nodes; ++place)
      if (needed_[t] >> place & 1) complete_.push_back(static_cast<LocalIndex>(t) * tile_nodes + place);
}

// What a node behind a wall receives goes to its image in front of it. Axis after axis, for images in edges and corners.
void CellGrid::add_images(const Faces& faces) {
  for (int f = 0; f < 6; ++f) {
    if (behaviour(faces[static_cast<std::size_t>(f)].kind).behind == NodesBehind::free) continue;
    const auto axis = static_cast<std::size_t>(f / 2);
    const int wall = grid_.node_offset(f / 2) + (f % 2 == 0 ? 0 : grid_.n_cells[axis]);
    const int inwards = f % 2 == 0 ? 1 : -1;
    for (LocalIndex node = 0; node < n_nodes(); ++node) {
      if (!(needed_[static_cast<std::size_t>(node / tile_nodes)] >> (node % tile_nodes) & 1)) continue;
      Int3 position = node_position(node);
      if (position[axis] != wall + inwards) continue;
      position[axis] = wall - inwards;
      need(node_number(position));
    }
  }
}

bool CellGrid::reaches_complete_node(const Int3& tile, int place) const {
  const std::array<LocalIndex, 8> above = node_tiles_above(tile);
  for (const StencilNode node : stencil_of(grid_.order, place))
    if (const LocalIndex t = above[node.above]; t >= 0 && (needed_[static_cast<std::size_t>(t)] >> node.place & 1))
      return true;
  return false;
}

// Owners of tiles learn which of their cells others want, as tile and mask, and answer where the tile is in their pool.
void CellGrid::ask_for_cells(const Comm& comm, const ParticleGrid& particles) {
  struct Wish {
    int rank;
    TileIndex tile;
    std::uint64_t mask;
  };
  std::vector<Wish> wishes;
  collective_guard(comm, [&] {
    std::vector<TileIndex> below;
    for (const TileIndex tile : node_tiles_)
      for (int b = 0; b < 8; ++b) {
        const TileIndex there = grid_.neighbour(grid_.tile_coordinates(tile), {-(b / 4), -(b / 2 % 2), -(b % 2)});
        if (there >= 0 && particles.partition().map.owner(there) != comm.rank()) below.push_back(there);
      }
    std::sort(below.begin(), below.end());
    below.erase(std::unique(below.begin(), below.end()), below.end());
    for (const TileIndex tile : below) {
      Wish wish{particles.partition().map.owner(tile), tile, 0};
      for (int place = 0; place < tile_nodes; ++place)
        if (reaches_complete_node(grid_.tile_coordinates(tile), place)) wish.mask |= std::uint64_t{1} << place;
      if (wish.mask != 0) wishes.push_back(wish);
    }
    std::stable_sort(wishes.begin(), wishes.end(), [](const Wish& a, const Wish& b) { return a.rank < b.rank; });
  });
  constexpr int n_words = 3;
  std::vector<MessageSize> to;
  std::vector<std::int32_t> asked;
  for (const Wish& wish : wishes) {
    if (to.empty() || to.back().rank != wish.rank) to.push_back({wish.rank, 0});
    ++to.back().count;
    asked.push_back(wish.tile);
    asked.push_back(static_cast<std::int32_t>(wish.mask));
    asked.push_back(static_cast<std::int32_t>(wish.mask >> 32));
  }
  const std::vector<MessageSize> from = exchange_counts(comm, to);
  const std::vector<std::int32_t> wanted = trade(comm, to, asked, from, n_words);
  std::map<int, Neighbour> by_rank;
  const auto neighbour = [&](int rank) -> Neighbour& {
    return by_rank.try_emplace(rank, Neighbour{rank, {}, {}}).first->second;
  };
  const auto add_ids = [](LocalIndex tile, std::uint64_t mask, std::vector<LocalIndex>& ids) {
    for (int place = 0; place < tile_nodes; ++place)
      if (mask >> place & 1) ids.push_back(tile * tile_nodes + place);
  };
  std::vector<std::int32_t> answers;
  std::size_t at = 0;
  for (const MessageSize& message : from)
    for (GlobalIndex k = 0; k < message.count; ++k, at += n_words) {
      const LocalIndex slot = particles.layout().slot(wanted[at]);
      answers.push_back(slot);
      if (slot < 0) continue;
      const std::uint64_t mask = std::uint64_t{static_cast<std::uint32_t>(wanted[at + 1])} |
                                 std::uint64_t{static_cast<std::uint32_t>(wanted[at + 2])} << 32;
      add_ids(slot, mask, neighbour(message.rank).wanted);
    }
  const std::vector<std::int32_t> slots = trade(comm, from, answers, to, 1);
  for (std::size_t w = 0; w < wishes.size(); ++w) {
    if (slots[w] < 0) continue;
    add_ids(static_cast<LocalIndex>(tiles_.size()), wishes[w].mask, neighbour(wishes[w].rank).received);
    tiles_.push_back(wishes[w].tile);
  }
  for (auto& [rank, known] : by_rank) neighbours_.push_back(std::move(known));
}

void CellGrid::sort_cells() {
  struct Place {
    GlobalIndex number;
    LocalIndex id;
  };
  std::vector<Place> places;
  const auto add = [&](LocalIndex id) {
    const Int3 tile = grid_.tile_coordinates(tiles_[static_cast<std::size_t>(id / tile_nodes)]);
    places.push_back({grid_.node_number(in_tile(tile, id % tile_nodes)), id});
  };
  for (LocalIndex id = 0; id < n_own_ids_; ++id) add(id);
  for (const Neighbour& known : neighbours_)
    for (const LocalIndex id : known.received) add(id);
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.number < b.number; });
  order_.reserve(places.size());
  for (const Place& place : places) order_.push_back(place.id);
}

void CellGrid::stencil(LocalIndex id, LocalIndex* nodes) const {
  const std::array<LocalIndex, 8>& above = above_[static_cast<std::size_t>(id / tile_nodes)];
  for (const StencilNode node : stencil_of(grid_.order, id % tile_nodes)) {
    const LocalIndex tile = above[node.above];
    *nodes++ = tile < 0 ? n_nodes() : tile * tile_nodes + node.place;
  }
}

std::vector<Int3> CellGrid::complete_positions() const {
  std::vector<Int3> positions;
  positions.reserve(complete_.size());
  for (const LocalIndex node : complete_) positions.push_back(node_position(node));
  return positions;
}

std::size_t CellGrid::memory() const {
  std::size_t total = tiles_.capacity() * sizeof(TileIndex) + above_.capacity() * sizeof above_[0] +
                      node_tiles_.capacity() * sizeof(TileIndex) + needed_.capacity() * sizeof(std::uint64_t) +
                      (order_.capacity() + complete_.capacity()) * sizeof(LocalIndex) +
                      (owned_.capacity() + in_pool_.capacity()) * sizeof(Copy);
  for (const Neighbour& known : neighbours_)
    total += (known.wanted.capacity() + known.received.capacity()) * sizeof(LocalIndex);
  return total;
}

void exchange_counts(const Comm& comm, const CellGrid& grid, std::vector<std::int32_t>& counts) {
  std::vector<std::vector<std::int32_t>> out, in;
  std::vector<MPI_Request> requests;
  for (const CellGrid::Neighbour& known : grid.neighbours()) {
    std::vector<std::int32_t>& sent = out.emplace_back();
    for (const LocalIndex id : known.wanted) sent.push_back(counts[static_cast<std::size_t>(id)]);
    in.emplace_back(known.received.size());
  }
  std::size_t k = 0;
  for (const CellGrid::Neighbour& known : grid.neighbours()) {
    BULKLEY_MPI(MPI_Irecv(in[k].data(), static_cast<int>(in[k].size()), MPI_INT32_T, known.rank, tag, comm.get(),
                          &requests.emplace_back()));
    BULKLEY_MPI(MPI_Isend(out[k].data(), static_cast<int>(out[k].size()), MPI_INT32_T, known.rank, tag, comm.get(),
                          &requests.emplace_back()));
    ++k;
  }
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  k = 0;
  for (const CellGrid::Neighbour& known : grid.neighbours()) {
    for (std::size_t n = 0; n < known.received.size(); ++n) counts[static_cast<std::size_t>(known.received[n])] = in[k][n];
    ++k;
  }
}

void CellHalo::connect(const CellGrid& grid, std::span<const LocalIndex> number_of) {
  neighbours_.clear();
  for (const CellGrid::Neighbour& known : grid.neighbours()) {
    Neighbour neighbour{known.rank, {}, {}};
    for (const LocalIndex id : known.wanted)
      if (const LocalIndex n = number_of[static_cast<std::size_t>(id)]; n >= 0) neighbour.sent.push_back(n);
    for (const LocalIndex id : known.received)
      if (const LocalIndex n = number_of[static_cast<std::size_t>(id)]; n >= 0) neighbour.received.push_back(n);
    if (!neighbour.sent.empty() || !neighbour.received.empty()) neighbours_.push_back(std::move(neighbour));
  }
}

void CellHalo::exchange(const Comm& comm, double* values, int width) {
  const auto w = static_cast<std::size_t>(width);
  std::size_t n_out = 0, n_in = 0;
  for (const Neighbour& neighbour : neighbours_) {
    n_out += neighbour.sent.size() * w;
    n_in += neighbour.received.size() * w;
  }
  out_.resize(n_out);
  in_.resize(n_in);
  requests_.clear();
  double *to = out_.data(), *from = in_.data();
  for (const Neighbour& neighbour : neighbours_)
    if (!neighbour.received.empty()) {
      const std::size_t n = neighbour.received.size() * w;
      BULKLEY_MPI(
          MPI_Irecv(from, static_cast<int>(n), MPI_DOUBLE, neighbour.rank, tag, comm.get(), &requests_.emplace_back()));
      from += n;
    }
  for (const Neighbour& neighbour : neighbours_)
    if (!neighbour.sent.empty()) {
      double* const begin = to;
      for (const LocalIndex n : neighbour.sent) to = std::copy_n(values + static_cast<std::size_t>(n) * w, w, to);
      BULKLEY_MPI(MPI_Isend(begin, static_cast<int>(to - begin), MPI_DOUBLE, neighbour.rank, tag, comm.get(),
                            &requests_.emplace_back()));
    }
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE));
  from = in_.data();
  for (const Neighbour& neighbour : neighbours_)
    for (const LocalIndex n : neighbour.received) {
      std::copy_n(from, w, values + static_cast<std::size_t>(n) * w);
      from += w;
    }
}

std::size_t CellHalo::sent_bytes() const {
  std::size_t n = 0;
  for (const Neighbour& neighbour : neighbours_) n += neighbour.sent.size();
  return n * sizeof(double);
}

}  // namespace bulkley
