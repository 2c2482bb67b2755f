#include "grid/tile_map.hpp"

#include <algorithm>
#include <utility>

#include "bulkley/base/error.hpp"

namespace bulkley {

TileMap::TileMap(int n_ranks, std::vector<std::int32_t> owners) : n_ranks_(n_ranks), stored_(std::move(owners)) {
  BULKLEY_ASSERT(n_ranks >= 1);
  const Owners& all = std::get<Owners>(stored_);
  BULKLEY_ASSERT(std::all_of(all.begin(), all.end(), [&](std::int32_t rank) { return rank >= 0 && rank < n_ranks; }));
}

TileMap::TileMap(CutTree tree) : n_ranks_(tree.n_ranks()), stored_(std::move(tree)) {}

TileMap::TileMap(BoxOwners boxes) : n_ranks_(boxes.n_ranks), stored_(std::move(boxes)) {
  [[maybe_unused]] const auto largest = [](const std::vector<std::int32_t>& of) {
    return *std::max_element(of.begin(), of.end());
  };
  [[maybe_unused]] const auto& [x, y, z] = std::get<BoxOwners>(stored_).of;
  BULKLEY_ASSERT(!x.empty() && !y.empty() && !z.empty());
  BULKLEY_ASSERT(largest(x) + largest(y) + largest(z) < n_ranks_);
}

TileIndex TileMap::n_tiles() const {
  if (const auto* owners = std::get_if<Owners>(&stored_)) return static_cast<TileIndex>(owners->size());
  if (const auto* boxes = std::get_if<BoxOwners>(&stored_)) {
    const auto& [x, y, z] = boxes->of;
    return static_cast<TileIndex>(x.size() * y.size() * z.size());
  }
  const Int3& n = std::get<CutTree>(stored_).n_tiles();
  return n[0] * n[1] * n[2];
}

bool TileMap::operator==(const TileMap& other) const {
  if (n_ranks_ != other.n_ranks_ || n_tiles() != other.n_tiles()) return false;
  if (stored_ == other.stored_) return true;
  for (TileIndex tile = 0; tile < n_tiles(); ++tile)
    if (owner(tile) != other.owner(tile)) return false;
  return true;
}

std::uint64_t TileMap::fingerprint() const {
  constexpr std::uint64_t prime = 1099511628211u;  // FNV-1a, a number at a time
  std::uint64_t hash = 14695981039346656037u;
  const auto add = [&hash](std::uint64_t number) { hash = (hash ^ number) * prime; };
  add(static_cast<std::uint32_t>(n_ranks_));
  if (const auto* owners = std::get_if<Owners>(&stored_)) {
    for (const std::int32_t rank : *owners) add(static_cast<std::uint32_t>(rank));
  } else if (const auto* boxes = std::get_if<BoxOwners>(&stored_)) {
    for (const auto& of : boxes->of)
      for (const std::int32_t rank : of) add(static_cast<std::uint32_t>(rank));
  } else {
    const auto& cuts = std::get<CutTree>(stored_);
    for (const int n : cuts.n_tiles()) add(static_cast<std::uint32_t>(n));
    add(static_cast<std::uint64_t>(cuts.cutting()));
    add(static_cast<std::uint64_t>(cuts.halves().ranks_per_node));
    for (const Cut cut : cuts.cuts()) {
      add(cut.bits() >> 32);
      add(cut.bits() & 0xffffffffu);
    }
  }
  add(static_cast<std::uint64_t>(n_tiles()));
  return hash;
}

// The last number of a packed map says what the others are.
constexpr std::int32_t of_tiles = 0, of_tree = 1, of_boxes = 2;

std::vector<std::int32_t> TileMap::pack() && {
  std::vector<std::int32_t> packed;
  if (auto* owners = std::get_if<Owners>(&stored_)) {
    packed = std::exchange(*owners, {});
    packed.push_back(of_tiles);
    return packed;
  }
  if (const auto* boxes = std::get_if<BoxOwners>(&stored_)) {
    for (const auto& of : boxes->of) packed.insert(packed.end(), of.begin(), of.end());
    for (const auto& of : boxes->of) packed.push_back(static_cast<std::int32_t>(of.size()));
    packed.push_back(of_boxes);
    return packed;
  }
  const auto tree = std::exchange(std::get<CutTree>(stored_), {});
  packed.reserve(2 * tree.cuts().size() + 6);
  for (const Cut cut : tree.cuts()) {
    packed.push_back(static_cast<std::int32_t>(cut.bits() >> 32));
    packed.push_back(static_cast<std::int32_t>(cut.bits() & 0xffffffffu));
  }
  packed.push_back(tree.halves().ranks_per_node);
  packed.push_back(static_cast<std::int32_t>(tree.cutting()));
  packed.insert(packed.end(), tree.n_tiles().begin(), tree.n_tiles().end());
  packed.push_back(of_tree);
  return packed;
}

TileMap TileMap::unpack(int n_ranks, std::vector<std::int32_t> packed) {
  const std::int32_t kind = packed.back();
  packed.pop_back();
  if (kind == of_tiles) return {n_ranks, std::move(packed)};
  Int3 n_tiles;
  std::copy_n(packed.end() - 3, 3, n_tiles.begin());
  if (kind == of_boxes) {
    BoxOwners boxes{n_ranks, {}};
    const std::int32_t* from = packed.data();
    for (int axis = 0; axis < 3; from += n_tiles[axis++]) boxes.of[axis].assign(from, from + n_tiles[axis]);
    return TileMap(std::move(boxes));
  }
  const auto cutting = static_cast<Cutting>(packed.end()[-4]);
  const RankHalves halves{packed.end()[-5]};
  std::vector<Cut> cuts;
  for (std::size_t n = 0; n + 5 < packed.size(); n += 2)
    cuts.push_back(Cut::of_bits(std::uint64_t{static_cast<std::uint32_t>(packed[n])} << 32 |
                                static_cast<std::uint32_t>(packed[n + 1])));
  BULKLEY_ASSERT(static_cast<int>(cuts.size()) + 1 == n_ranks);
  return TileMap(CutTree(n_tiles, std::move(cuts), cutting, halves));
}

std::size_t TileMap::memory() const {
  if (const auto* owners = std::get_if<Owners>(&stored_)) return owners->capacity() * sizeof(std::int32_t);
  if (const auto* boxes = std::get_if<BoxOwners>(&stored_))
    return (boxes->of[0].capacity() + boxes->of[1].capacity() + boxes->of[2].capacity()) * sizeof(std::int32_t);
  return std::get<CutTree>(stored_).cuts().capacity() * sizeof(Cut);
}

Int3 separable_tiles(const GridGeometry& grid) {
  Int3 n;
  for (int axis = 0; axis < 3; ++axis) {
    const int behind = grid.n_cells[axis] + grid.node_offset(axis) + 1;
    const bool apart = !grid.periodic[axis] && behind / tile_width != (behind - 2) / tile_width;
    n[axis] = grid.n_tiles(axis) - (apart ? 1 : 0);
  }
  return n;
}

}  // namespace bulkley
