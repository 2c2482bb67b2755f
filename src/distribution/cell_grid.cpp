#include "distribution/cell_grid.hpp"

#include <algorithm>
#include <bit>
#include <map>

#include "bulkley/base/error.hpp"
#include "distribution/message_tags.hpp"
#include "distribution/rank_messages.hpp"

namespace bulkley {

namespace {

constexpr const char* pools = "pools of version";  // what messages say that they belong to

// -1 where it is not.
LocalIndex place_in(const std::vector<TileIndex>& ascending, TileIndex tile) {
  const auto found = std::lower_bound(ascending.begin(), ascending.end(), tile);
  return found != ascending.end() && *found == tile ? static_cast<LocalIndex>(found - ascending.begin()) : -1;
}

void make_set(std::vector<TileIndex>& tiles) {
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
}

// Of all places in a tile. Along the axis of a plane flow the nodes of a stencil are one.
CellGrid::Stencils stencils_of(const GridGeometry& grid) {
  const int s = stencil_width(grid.order);
  CellGrid::Stencils stencils{};
  for (int place = 0; place < tile_nodes; ++place)
    for (int a = 0; a < s * s * s; ++a) {
      const Int3 at{place / 16 + a / (s * s), place / 4 % 4 + a / s % s, place % 4 + a % s};
      int above = 0, in_tile = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const int along = grid.is_plane(axis) ? 0 : at[static_cast<std::size_t>(axis)];
        above = 2 * above + along / tile_width;
        in_tile = tile_width * in_tile + along % tile_width;
      }
      CellGrid::Stencil& stencil = stencils[static_cast<std::size_t>(place)];
      stencil.nodes[static_cast<std::size_t>(above)] |= std::uint64_t{1} << in_tile;
      if (a % s == 0)
        stencil.rows[static_cast<std::size_t>(a / s)] = {static_cast<std::uint8_t>(above),
                                                         static_cast<std::uint8_t>(in_tile)};
    }
  return stencils;
}

Int3 in_tile(const Int3& tile, int place) {
  return {tile[0] * tile_width + place / 16, tile[1] * tile_width + place / 4 % 4, tile[2] * tile_width + place % 4};
}

}  // namespace

CellGrid::CellGrid(const Comm& comm, const ParticleGrid& particles, const Faces& faces)
    : version_(particles.version()), grid_(particles.grid()), stencils_(stencils_of(grid_)) {
  tiles_ = particles.layout().tiles();
  n_own_ids_ = static_cast<LocalIndex>(tiles_.size()) * tile_nodes;
  collective_guard(comm, [&] { find_nodes(particles, faces); });
  ask_for_cells(comm, particles);
  sort_cells();
  number_nodes();
}

LocalIndex CellGrid::node_tile(TileIndex tile) const { return place_in(node_tiles_, tile); }

// The tiles at {0, 1}^3 above a tile, as far as there are any.
void CellGrid::add_tiles_above(TileIndex tile, std::vector<TileIndex>& tiles) const {
  for (int b = 0; b < 8; ++b)
    if (const TileIndex there = grid_.neighbour(grid_.tile_coordinates(tile), {b / 4, b / 2 % 2, b % 2}); there >= 0)
      tiles.push_back(there);
}

// Their places in `tiles`, which ascend; -1 for those that are not among them.
std::array<LocalIndex, 8> CellGrid::tiles_above(TileIndex tile, const std::vector<TileIndex>& tiles) const {
  std::array<LocalIndex, 8> above;
  for (int b = 0; b < 8; ++b) {
    const TileIndex there = grid_.neighbour(grid_.tile_coordinates(tile), {b / 4, b / 2 % 2, b % 2});
    above[static_cast<std::size_t>(b)] = there < 0 ? -1 : place_in(tiles, there);
  }
  return above;
}

LocalIndex CellGrid::node_number(const Int3& node) const {
  return node_tile(grid_.tile_of_node(node)) * tile_nodes + node[0] % 4 * 16 + node[1] % 4 * 4 + node[2] % 4;
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
  std::vector<TileIndex> reached = tiles_;
  for (const Int3& node : active)  // neighbours mostly share a tile
    if (const TileIndex tile = grid_.tile_of_node(node); reached.empty() || reached.back() != tile) reached.push_back(tile);
  make_set(reached);
  for (const TileIndex tile : reached) add_tiles_above(tile, node_tiles_);
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
  make_set(node_tiles_);
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
            int& along = node[static_cast<std::size_t>(a)];
            along = grid_.wrapped(a, along);
            exists = exists && along < grid_.n_nodes(a);
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
    for (std::size_t t = 0; t < node_tiles_.size(); ++t) {
      const Int3 tile = grid_.tile_coordinates(node_tiles_[t]);
      if (tile[axis] != (wall + inwards) / tile_width) continue;
      for (std::uint64_t bits = needed_[t]; bits != 0; bits &= bits - 1) {
        Int3 position = in_tile(tile, std::countr_zero(bits));
        if (position[axis] != wall + inwards) continue;
        position[axis] = wall - inwards;
        need(node_number(position));
      }
    }
  }
}

// Of the cells of a tile, a bit for each that reaches a complete node.
std::uint64_t CellGrid::cells_at_complete_nodes(TileIndex tile) const {
  const std::array<LocalIndex, 8> above = tiles_above(tile, node_tiles_);
  std::uint64_t mask = 0;
  for (int place = 0; place < tile_nodes; ++place) {
    const std::array<std::uint64_t, 8>& nodes = stencils_[static_cast<std::size_t>(place)].nodes;
    bool reaches = false;
    for (std::size_t b = 0; b < 8; ++b)
      reaches = reaches || (above[b] >= 0 && (nodes[b] & needed_[static_cast<std::size_t>(above[b])]));
    mask |= std::uint64_t{reaches} << place;
  }
  return mask;
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
    make_set(below);
    for (const TileIndex tile : below) {
      const Wish wish{particles.partition().map.owner(tile), tile, cells_at_complete_nodes(tile)};
      if (wish.mask != 0) wishes.push_back(wish);
    }
    std::stable_sort(wishes.begin(), wishes.end(), [](const Wish& a, const Wish& b) { return a.rank < b.rank; });
  });
  std::vector<RankMessage> asked;
  for (const Wish& wish : wishes) {
    if (asked.empty() || asked.back().rank != wish.rank) asked.push_back({wish.rank, {version_}});
    asked.back().words.push_back(wish.tile);
    asked.back().words.push_back(std::bit_cast<std::int64_t>(wish.mask));
  }
  std::map<int, Neighbour> by_rank;
  const auto neighbour = [&](int rank) -> Neighbour& {
    return by_rank.try_emplace(rank, Neighbour{rank, {}, {}}).first->second;
  };
  const auto add_ids = [](LocalIndex tile, std::uint64_t mask, std::vector<LocalIndex>& ids) {
    for (int place = 0; place < tile_nodes; ++place)
      if (mask >> place & 1) ids.push_back(tile * tile_nodes + place);
  };
  std::vector<RankMessage> answers, slots;
  for (const RankMessage& wanted : sparse_exchange(comm, asked)) {
    expect_number(comm, pools, wanted.rank, wanted.words.front(), version_);
    RankMessage& answer = answers.emplace_back(RankMessage{wanted.rank, {version_}});
    for (std::size_t at = 1; at < wanted.words.size(); at += 2) {
      const LocalIndex slot = particles.layout().slot(static_cast<TileIndex>(wanted.words[at]));
      answer.words.push_back(slot);
      if (slot >= 0) add_ids(slot, std::bit_cast<std::uint64_t>(wanted.words[at + 1]), neighbour(wanted.rank).wanted);
    }
  }
  for (const RankMessage& message : asked)
    slots.push_back({message.rank, std::vector<std::int64_t>(1 + (message.words.size() - 1) / 2)});
  exchange_messages(comm, message_tag::slots, answers, slots);
  auto wish = wishes.begin();
  for (const RankMessage& message : slots) {
    expect_number(comm, pools, message.rank, message.words.front(), version_);
    for (std::size_t at = 1; at < message.words.size(); ++at, ++wish) {
      if (message.words[at] < 0) continue;
      add_ids(static_cast<LocalIndex>(tiles_.size()), wish->mask, neighbour(message.rank).received);
      tiles_.push_back(wish->tile);
    }
  }
  for (auto& [rank, known] : by_rank) neighbours_.push_back(std::move(known));
}

void CellGrid::sort_cells() {
  struct Place {
    GlobalIndex number;
    LocalIndex id;
  };
  std::vector<Place> places;
  // The last tile along an axis may reach beyond the cells that particles can be in.
  const auto add = [&](LocalIndex id) {
    const Int3 base = position(id);
    for (int a = 0; a < 3; ++a) {
      const int reach = grid_.periodic[static_cast<std::size_t>(a)] ? 1 : width();
      if (base[static_cast<std::size_t>(a)] + reach > grid_.n_nodes(a)) return;
    }
    places.push_back({grid_.node_number(base), id});
  };
  for (LocalIndex id = 0; id < n_own_ids_; ++id) add(id);
  for (const Neighbour& known : neighbours_)
    for (const LocalIndex id : known.received) add(id);
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.number < b.number; });
  order_.reserve(places.size());
  for (const Place& place : places) order_.push_back(place.id);
}

// So far nodes go by tile and place. From here on they go by numbers that follow each other along z.
void CellGrid::number_nodes() {
  std::vector<TileIndex> tiles = node_tiles_;
  for (const TileIndex tile : tiles_) add_tiles_above(tile, tiles);
  make_set(tiles);
  std::vector<LocalIndex> place_of;  // among `tiles`, by tile with complete nodes
  for (const TileIndex tile : node_tiles_) place_of.push_back(place_in(tiles, tile));
  std::vector<std::uint64_t> reached(tiles.size(), 0);
  for (std::size_t t = 0; t < node_tiles_.size(); ++t) reached[static_cast<std::size_t>(place_of[t])] = needed_[t];
  std::vector<std::array<LocalIndex, 8>> above;
  for (const TileIndex tile : tiles_) above.push_back(tiles_above(tile, tiles));
  for (const LocalIndex id : order_) {
    const std::array<std::uint64_t, 8>& nodes = stencils_[static_cast<std::size_t>(id % tile_nodes)].nodes;
    for (std::size_t b = 0; b < 8; ++b)
      if (const LocalIndex tile = above[static_cast<std::size_t>(id / tile_nodes)][b]; tile >= 0)
        reached[static_cast<std::size_t>(tile)] |= nodes[b];
  }
  const std::vector<LocalIndex> numbers = number_columns(tiles, reached);
  find_rows(above, numbers);
  const auto number = [&](LocalIndex node) {
    const LocalIndex tile = place_of[static_cast<std::size_t>(node / tile_nodes)];
    return numbers[static_cast<std::size_t>(tile * tile_nodes + node % tile_nodes)];
  };
  for (LocalIndex& node : complete_) node = number(node);
  for (std::vector<Copy>* copies : {&owned_, &in_pool_})
    for (Copy& copy : *copies) copy.node = number(copy.node);
}

// Numbers of the `reached` nodes of `tiles`, by tile and place; -1 for others. They ascend with x, then with y, then with z.
// Around a periodic z axis a column ends with repetitions of its first nodes, so that rows of stencils that cross the end are
// in one piece.
std::vector<LocalIndex> CellGrid::number_columns(const std::vector<TileIndex>& tiles,
                                                 const std::vector<std::uint64_t>& reached) {
  std::vector<LocalIndex> numbers(tiles.size() * tile_nodes, -1);
  const TileIndex nz = grid_.n_tiles(2), nyz = grid_.n_tiles(1) * nz;
  const auto end_of = [&](std::size_t first, TileIndex n) {
    std::size_t end = first;
    while (end < tiles.size() && tiles[end] / n == tiles[first] / n) ++end;
    return end;
  };
  for (std::size_t slab = 0, end = 0; slab < tiles.size(); slab = end) {
    end = end_of(slab, nyz);
    for (int x = 0; x < tile_width; ++x)
      for (std::size_t first = slab, last = 0; first < end; first = last) {
        last = end_of(first, nz);
        for (int y = 0; y < tile_width; ++y)
          number_column({tiles.data() + first, last - first}, reached.data() + first, (x * tile_width + y) * tile_width,
                        numbers.data() + first * tile_nodes);
      }
  }
  return numbers;
}

// Of the column that begins at `place` in each of `tiles`, which follow each other along z.
void CellGrid::number_column(std::span<const TileIndex> tiles, const std::uint64_t* reached, int place,
                             LocalIndex* numbers) {
  for (std::size_t t = 0; t < tiles.size(); ++t)
    for (int z = place; z < place + tile_width; ++z)
      if (reached[t] >> z & 1) numbers[t * tile_nodes + static_cast<std::size_t>(z)] = n_nodes_++;
  const TileIndex nz = grid_.n_tiles(2);
  if (!grid_.periodic[2] || tiles.front() % nz != 0 || tiles.back() % nz != nz - 1) return;
  const int n = std::min(grid_.n_cells[2], tile_width);  // nodes of the column in each tile
  if (numbers[(tiles.size() - 1) * tile_nodes + static_cast<std::size_t>(place + n - 1)] < 0) return;
  for (int k = 0; k + 1 < width() && numbers[place + k % n] >= 0; ++k) repeated_.push_back({n_nodes_++, numbers[place + k % n]});
}

// `above`: by tile of cells, places of the tiles of nodes above it among those that `numbers` are of.
void CellGrid::find_rows(const std::vector<std::array<LocalIndex, 8>>& above, const std::vector<LocalIndex>& numbers) {
  const auto n_rows = static_cast<std::size_t>(width() * width());
  rows_.assign(tiles_.size() * tile_nodes * n_rows, -1);
  for (const LocalIndex id : order_) {
    const Stencil& stencil = stencils_[static_cast<std::size_t>(id % tile_nodes)];
    const std::array<LocalIndex, 8>& tiles = above[static_cast<std::size_t>(id / tile_nodes)];
    LocalIndex* const first = rows_.data() + static_cast<std::size_t>(id) * n_rows;
    for (std::size_t r = 0; r < n_rows; ++r)
      first[r] = numbers[static_cast<std::size_t>(tiles[stencil.rows[r].above] * tile_nodes + stencil.rows[r].place)];
  }
}

std::span<const LocalIndex> CellGrid::rows(LocalIndex id) const {
  const auto s = static_cast<std::size_t>(stencil_width(grid_.order));
  return {rows_.data() + static_cast<std::size_t>(id) * s * s, s * s};
}

Int3 CellGrid::position(LocalIndex id) const {
  return in_tile(grid_.tile_coordinates(tiles_[static_cast<std::size_t>(id / tile_nodes)]), id % tile_nodes);
}

void fold_repeated(std::span<const CellGrid::Copy> repeated, Node* sums) {
  for (const CellGrid::Copy& copy : repeated)
    for (int a = 0; a < 3; ++a) sums[copy.other].c[a] += sums[copy.node].c[a];
}

void repeat(std::span<const CellGrid::Copy> repeated, Node* nodes) {
  for (const CellGrid::Copy& copy : repeated) nodes[copy.node] = nodes[copy.other];
}

std::vector<Int3> CellGrid::complete_positions() const {
  std::vector<Int3> positions;
  positions.reserve(complete_.size());
  for (std::size_t t = 0; t < needed_.size(); ++t)
    for (int place = 0; place < tile_nodes; ++place)
      if (needed_[t] >> place & 1) positions.push_back(in_tile(grid_.tile_coordinates(node_tiles_[t]), place));
  return positions;
}

std::size_t CellGrid::memory() const {
  std::size_t total = (tiles_.capacity() + node_tiles_.capacity()) * sizeof(TileIndex) +
                      needed_.capacity() * sizeof(std::uint64_t) +
                      (order_.capacity() + complete_.capacity() + rows_.capacity()) * sizeof(LocalIndex) +
                      (owned_.capacity() + in_pool_.capacity() + repeated_.capacity()) * sizeof(Copy);
  for (const Neighbour& known : neighbours_)
    total += (known.wanted.capacity() + known.received.capacity()) * sizeof(LocalIndex);
  return total;
}

void exchange_counts(const Comm& comm, const CellGrid& grid, std::vector<std::int32_t>& counts) {
  std::vector<RankMessage> sent, received;
  for (const CellGrid::Neighbour& known : grid.neighbours()) {
    RankMessage& message = sent.emplace_back(RankMessage{known.rank, {grid.version()}});
    for (const LocalIndex id : known.wanted) message.words.push_back(counts[static_cast<std::size_t>(id)]);
    received.push_back({known.rank, std::vector<std::int64_t>(1 + known.received.size())});
  }
  exchange_messages(comm, message_tag::cells, sent, received);
  auto message = received.begin();
  for (const CellGrid::Neighbour& known : grid.neighbours()) {
    expect_number(comm, pools, known.rank, message->words.front(), grid.version());
    auto count = message++->words.begin() + 1;
    for (const LocalIndex id : known.received) counts[static_cast<std::size_t>(id)] = static_cast<std::int32_t>(*count++);
  }
}

void CellHalo::connect(const CellGrid& grid, std::span<const LocalIndex> number_of) {
  version_ = grid.version();
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

// Each message begins with the version of the grid.
void CellHalo::exchange(const Comm& comm, double* values, int width) {
  const auto w = static_cast<std::size_t>(width);
  const auto size = [&](const std::vector<LocalIndex>& cells) { return cells.empty() ? 0 : 1 + cells.size() * w; };
  std::size_t n_out = 0, n_in = 0;
  for (const Neighbour& neighbour : neighbours_) {
    n_out += size(neighbour.sent);
    n_in += size(neighbour.received);
  }
  out_.resize(n_out);
  in_.resize(n_in);
  requests_.clear();
  double *to = out_.data(), *from = in_.data();
  for (const Neighbour& neighbour : neighbours_)
    if (const std::size_t n = size(neighbour.received); n > 0) {
      BULKLEY_MPI(MPI_Irecv(from, static_cast<int>(n), MPI_DOUBLE, neighbour.rank, message_tag::cells, comm.get(),
                            &requests_.emplace_back()));
      from += n;
    }
  for (const Neighbour& neighbour : neighbours_)
    if (!neighbour.sent.empty()) {
      double* const begin = to;
      *to++ = static_cast<double>(version_);
      for (const LocalIndex n : neighbour.sent) to = std::copy_n(values + static_cast<std::size_t>(n) * w, w, to);
      BULKLEY_MPI(MPI_Isend(begin, static_cast<int>(to - begin), MPI_DOUBLE, neighbour.rank, message_tag::cells, comm.get(),
                            &requests_.emplace_back()));
    }
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE));
  from = in_.data();
  for (const Neighbour& neighbour : neighbours_) {
    if (neighbour.received.empty()) continue;
    expect_number(comm, pools, neighbour.rank, static_cast<GlobalIndex>(*from++), version_);
    for (const LocalIndex n : neighbour.received) {
      std::copy_n(from, w, values + static_cast<std::size_t>(n) * w);
      from += w;
    }
  }
}

std::size_t CellHalo::sent_bytes() const {
  std::size_t n = 0;
  for (const Neighbour& neighbour : neighbours_)
    if (!neighbour.sent.empty()) n += 1 + neighbour.sent.size();
  return n * sizeof(double);
}

}  // namespace bulkley
