// Which cells and nodes take part in the implicit pressure of a step, and what particles give to them (docs/theory.md, "Implicit
// pressure").

#include <algorithm>

#include "integrator/implicit_pressure.hpp"

namespace bulkley {

// Which cells have particles, here and on the ranks around.
void ImplicitPressure::count_cells() {
  const ParticleSet& particles = parts_.particles.particles();
  counts_.assign(static_cast<std::size_t>(grid_->n_ids()), 0);
  const std::uint8_t* const material = particles.material();
  const std::vector<LocalIndex>& cell_of = cells();
  for (LocalIndex p = 0; p < particles.size(); ++p)
    if (const LocalIndex cell = cell_of[static_cast<std::size_t>(p)]; laws_[material[p]] && cell < grid_->n_own_ids())
      ++counts_[static_cast<std::size_t>(cell)];
  exchange_counts(parts_.comm(), *grid_, counts_);
}

void ImplicitPressure::fetch(const Node* nodes) { parts_.particles.exchange().get(nodes, pool_.data()); }

// Nodes that an occupied cell reaches or that have a mass. The rest of a tile is empty.
void ImplicitPressure::select_nodes(const GridUpdate& update, const Node* nodes) {
  takes_part_.assign(static_cast<std::size_t>(grid_->n_nodes()), 0);
  const auto mark = [&](std::span<const CellGrid::Copy> copies, const Node* from) {
    for (const CellGrid::Copy& copy : copies)
      if (from[copy.other].c[3] > update.smallest_mass) takes_part_[static_cast<std::size_t>(copy.node)] = 1;
  };
  mark(grid_->owned(), nodes);
  mark(grid_->in_pool(), pool_.data());
  for (const LocalIndex id : grid_->order())
    if (counts_[static_cast<std::size_t>(id)] > 0)
      for (const LocalIndex first : grid_->rows(id)) std::fill_n(takes_part_.begin() + first, grid_->width(), char{1});
  contact_.select(*grid_, takes_part_);
  const auto n = static_cast<std::size_t>(contact_.nodes().size());
  for (NodeVector* values : {&free_, &held_, &impulses_}) values->assign(n, Node{});
  scale_.assign(n, 0.0);
}

void ImplicitPressure::number_cells() {
  number_of_.assign(static_cast<std::size_t>(grid_->n_ids()), -1);
  place_of_.assign(static_cast<std::size_t>(grid_->n_own_ids()) + 1, -1);
  own_.clear();
  others_.clear();
  block_of_.clear();
  wave_of_own_.clear();
  LocalIndex n = 0;
  const CellWaves& waves = contact_.waves();
  end_of_plane_.assign(static_cast<std::size_t>(waves.size()) + 1, 0);
  std::size_t place_in_order = 0;
  for (const LocalIndex id : grid_->order()) {
    const auto plane = static_cast<std::size_t>(waves.planes()[place_in_order++]);
    end_of_plane_[plane + 1] = n;
    if (counts_[static_cast<std::size_t>(id)] == 0) continue;
    if (id < grid_->n_own_ids()) {
      place_of_[static_cast<std::size_t>(id)] = static_cast<LocalIndex>(own_.size());
      own_.push_back(n);
      wave_of_own_.push_back(waves.of_cell(id));
      const LocalIndex place = id % tile_nodes;
      block_of_.push_back(id / tile_nodes * 8 + place / 32 * 4 + place / 8 % 2 * 2 + place / 2 % 2);
    } else {
      others_.push_back(n);
    }
    number_of_[static_cast<std::size_t>(id)] = n++;
    end_of_plane_[plane + 1] = n;
  }
  sort_own_by_wave();
  halo_.connect(*grid_, number_of_);

  rows_.width = stencil_width(parts_.physics.grid.order);
  rows_.resize(n);
  LocalIndex* first = rows_.first.data();
  for (const LocalIndex id : grid_->order())
    if (counts_[static_cast<std::size_t>(id)] > 0)
      for (const LocalIndex node : grid_->rows(id)) *first++ = contact_.nodes().number(node);
}

void ImplicitPressure::sort_own_by_wave() {
  const auto wave = [&](std::size_t k) { return wave_of_own_[k]; };
  own_ranges_.assign(contact_.waves().size(), own_.size(), wave);
  own_by_wave_.resize(own_.size());
  std::vector<std::size_t> next(static_cast<std::size_t>(contact_.waves().size()));
  for (std::size_t w = 0; w < next.size(); ++w) next[w] = own_ranges_.begin(static_cast<LocalIndex>(w));
  for (std::size_t k = 0; k < own_.size(); ++k) own_by_wave_[next[static_cast<std::size_t>(wave(k))]++] = own_[k];
}

void ImplicitPressure::fill_cells() {
  const Physics& physics = parts_.physics;
  const ParticleSet& particles = parts_.particles.particles();
  const auto n = static_cast<std::size_t>(rows_.size());
  group_by_cell(laws_, particles, cells(), place_of_, static_cast<LocalIndex>(own_.size()), members_);
  for (std::vector<double>* values : {&volume_, &compliance_, &target_}) values->resize(own_.size());
  for (std::vector<char>* states : {&may_part_, &parted_}) states->resize(own_.size());
  for (std::vector<double>* values : {&pressure_, &right_, &residual_, &direction_, &product_, &scaled_, &inverse_diagonal_})
    values->assign(n, 0.0);
  const auto n_blocks = static_cast<std::size_t>(grid_->n_own_ids()) / 8;
  for (std::vector<double>* sums : {&block_volume_, &block_mass_, &block_sum_, &inverse_block_volume_})
    sums->assign(n_blocks, 0.0);
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const auto c = static_cast<std::size_t>(own_[k]);
    PressureCell cell;
    fill_cell(physics.grid, physics.transfer.gradient, laws_, particles, members_.of(static_cast<LocalIndex>(k)), cell,
              rows_.gradient_of(own_[k]));
    rows_.round(own_[k]);
    pressure_[c] = cell.start;
    volume_[k] = cell.volume;
    compliance_[k] = cell.compliance;
    target_[k] = cell.target;
    if (!carried_.empty()) account_for_carried(k);
    may_part_[k] = cell.parts;
    parted_[k] = cell.parts && 2.0 * cell.parted_volume > cell.volume;
    if (parted_[k]) pressure_[c] = 0.0;
    block_volume_[static_cast<std::size_t>(block_of_[k])] += cell.volume;
    block_mass_[static_cast<std::size_t>(block_of_[k])] += cell.mass;
  }
  halo_.exchange(parts_.comm(), reinterpret_cast<double*>(rows_.gradient.data()), 4 * rows_.n_stencil());
  for (const LocalIndex c : others_) rows_.round(c);
}

}  // namespace bulkley
