#include "integrator/pressure_matrix.hpp"

#include <algorithm>
#include <cmath>

namespace bulkley {

void PressureMatrix::number_rows(const Comm& comm, CellHalo& halo, std::span<const LocalIndex> own, LocalIndex n_cells) {
  const auto n_own = static_cast<GlobalIndex>(own.size());
  const GlobalIndex before = exclusive_sum(comm, n_own);
  n_rows_ = sum_global(comm, n_own);
  std::vector<double> rows(static_cast<std::size_t>(n_cells), 0.0);  // exact below 2^53
  for (std::size_t k = 0; k < own.size(); ++k)
    rows[static_cast<std::size_t>(own[k])] = static_cast<double>(before + static_cast<GlobalIndex>(k));
  halo.exchange(comm, rows.data(), 1);
  row_of_.assign(rows.begin(), rows.end());
}

// G, node by node: what `PressureContact::spread` does, as a square root.
void PressureMatrix::fill_entries(const PressureTerms& terms) {
  const PressureRows& B = terms.rows;
  const std::vector<PressureContact::Source> sources = terms.contact.sources(terms.scale.size());
  const auto width = static_cast<std::size_t>(B.width);
  const auto source_of = [&](std::size_t a) -> const PressureContact::Source& {
    return sources[static_cast<std::size_t>(B.first[a / width]) + a % width];
  };
  first_.assign(sources.size() + 1, 0);
  for (std::size_t a = 0; a < B.gradient.size(); ++a) ++first_[static_cast<std::size_t>(source_of(a).node) + 1];
  for (std::size_t n = 1; n < first_.size(); ++n) first_[n] += first_[n - 1];
  entries_.resize(B.gradient.size());
  place_.resize(B.gradient.size());
  std::vector<std::size_t> end(first_.begin(), first_.end() - 1);  // of those that are in place
  for (std::size_t a = 0; a < B.gradient.size(); ++a) {
    const PressureContact::Source& source = source_of(a);
    const auto n = static_cast<std::size_t>(source.node);
    const double factor = terms.dt * std::sqrt(terms.scale[n]);
    place_[a] = end[n]++;
    Entry& entry = entries_[place_[a]];
    entry.cell = static_cast<LocalIndex>(a / static_cast<std::size_t>(B.n_stencil()));
    entry.node = source.node;
    for (int k = 0; k < 3; ++k) entry.c[k] = factor * source.sign[k] * B.gradient[a].c[k];
  }
  terms.contact.for_each_projection([&](LocalIndex node, const Mat3& projection) {
    const auto n = static_cast<std::size_t>(node);
    for (std::size_t e = first_[n]; e < first_[n + 1]; ++e) {
      const Vec3 rest = projection * Vec3(entries_[e].c[0], entries_[e].c[1], entries_[e].c[2]);
      std::copy_n(rest.data(), 3, entries_[e].c);
    }
  });
}

void PressureMatrix::add(LocalIndex cell, double value) {
  const auto d = static_cast<std::size_t>(cell);
  if (!is_in_row_[d]) {
    is_in_row_[d] = true;
    sums_[d] = 0.0;
    in_row_.push_back(cell);
  }
  sums_[d] += value;
}

// Row k of A + G G^T + Z: the cells that share a node or a block with this rank's k-th.
void PressureMatrix::sum_row(const PressureTerms& terms, std::size_t k) {
  const auto n_stencil = static_cast<std::size_t>(terms.rows.n_stencil());
  const auto first = static_cast<std::size_t>(terms.own[k]) * n_stencil, b = static_cast<std::size_t>(terms.block_of[k]);
  const double z = terms.within_block[k];
  in_row_.clear();
  add(terms.own[k], terms.compliance[k] + z);
  for (const LocalIndex other : blocks_[b])
    if (other >= 0) {
      const auto m = static_cast<std::size_t>(other);
      add(terms.own[m], -z * terms.volume[m] / terms.block_volume[b]);
    }
  for (std::size_t a = first; a < first + n_stencil; ++a) {
    const Entry mine = entries_[place_[a]];
    const auto n = static_cast<std::size_t>(mine.node);
    if (terms.scale[n] == 0.0) continue;
    for (std::size_t e = first_[n]; e < first_[n + 1]; ++e) {
      const Entry& other = entries_[e];
      add(other.cell, (mine.c[0] * other.c[0] + mine.c[1] * other.c[1]) + mine.c[2] * other.c[2]);
    }
  }
}

void PressureMatrix::group_by_block(const PressureTerms& terms) {
  std::array<LocalIndex, 8> none;
  none.fill(-1);
  blocks_.assign(terms.block_volume.size(), none);
  for (std::size_t k = 0; k < terms.own.size(); ++k)
    *std::ranges::find(blocks_[static_cast<std::size_t>(terms.block_of[k])], -1) = static_cast<LocalIndex>(k);
}

const SparseRows& PressureMatrix::assemble(const Comm& comm, CellHalo& halo, const PressureTerms& terms) {
  std::vector<double> parted(row_of_.size(), 0.0);
  for (std::size_t k = 0; k < terms.own.size(); ++k) parted[static_cast<std::size_t>(terms.own[k])] = terms.parted[k];
  halo.exchange(comm, parted.data(), 1);
  fill_entries(terms);
  group_by_block(terms);
  sums_.resize(row_of_.size());
  is_in_row_.assign(row_of_.size(), false);
  rows_.first.assign(1, 0);
  rows_.column.clear();
  rows_.value.clear();
  for (std::size_t k = 0; k < terms.own.size(); ++k) {
    sum_row(terms, k);
    std::ranges::sort(in_row_);
    for (const LocalIndex cell : in_row_) {
      const auto d = static_cast<std::size_t>(cell);
      is_in_row_[d] = false;
      if (cell != terms.own[k] && (terms.parted[k] || parted[d] > 0.0)) continue;
      rows_.column.push_back(row_of_[d]);
      rows_.value.push_back(sums_[d]);
    }
    rows_.first.push_back(static_cast<PetscInt>(rows_.column.size()));
  }
  return rows_;
}

std::size_t PressureMatrix::memory() const {
  return row_of_.capacity() * sizeof(PetscInt) + entries_.capacity() * sizeof(Entry) +
         (first_.capacity() + place_.capacity()) * sizeof(std::size_t) + blocks_.capacity() * sizeof blocks_[0] +
         sums_.capacity() * sizeof(double) + is_in_row_.capacity() + in_row_.capacity() * sizeof(LocalIndex) +
         (rows_.first.capacity() + rows_.column.capacity()) * sizeof(PetscInt) + rows_.value.capacity() * sizeof(double);
}

}  // namespace bulkley
