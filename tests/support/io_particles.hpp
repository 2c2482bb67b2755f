#pragma once
// Particles and folders for the tests of the io module. A particle's fields follow from its id alone.

#include <petscsys.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "io/arrays/hdf5_file.hpp"

namespace bulkley {

/// Bits of a finite double in [1, 2), different for every (id, column).
inline std::uint64_t bits_of(GlobalIndex id, std::size_t column) {
  const std::uint64_t mixed = (static_cast<std::uint64_t>(id) * 64 + column + 1) * 0x9E3779B97F4A7C15ull;
  return 0x3FF0000000000000ull | (mixed >> 12);
}

inline void fill_particle(ParticleSet& particles, LocalIndex p, GlobalIndex id) {
  for (std::size_t c = 0; c < particles.columns().size(); ++c) {
    if (particles.columns()[c].element_size != 8) continue;
    const std::uint64_t bits = bits_of(id, c);
    std::memcpy(particles.data(c) + static_cast<std::size_t>(p) * 8, &bits, 8);
  }
  particles.id()[p] = id;
  particles.material()[p] = static_cast<std::uint8_t>(id % 2);
}

/// Particles with ids first .. first + n - 1.
inline ParticleSet make_particles(GlobalIndex first, GlobalIndex n) {
  ParticleSet particles(OptionalFields{}, Densities(std::array{1.25, 1.5}));
  particles.resize(static_cast<LocalIndex>(n));
  for (LocalIndex p = 0; p < particles.size(); ++p) fill_particle(particles, p, first + p);
  return particles;
}

/// `total` particles over the ranks: uneven, and none on rank 1 where there is one.
inline ParticleSet make_uneven_particles(const Comm& comm, GlobalIndex total) {
  std::vector<GlobalIndex> weights;
  GlobalIndex sum = 0;
  for (int r = 0; r < comm.size(); ++r) weights.push_back(r == 1 ? 0 : 1 + r * r);
  for (const GlobalIndex weight : weights) sum += weight;
  GlobalIndex before = 0;
  for (int r = 0; r < comm.rank(); ++r) before += weights[static_cast<std::size_t>(r)];
  const GlobalIndex first = total * before / sum;
  return make_particles(first, total * (before + weights[static_cast<std::size_t>(comm.rank())]) / sum - first);
}

/// A fresh folder that all ranks share and the root removes at the end.
class SharedFolder {
 public:
  explicit SharedFolder(const Comm& comm) : comm_(comm) {
    std::string name;
    root_guard(comm, [&] {
      std::string pattern = (std::filesystem::temp_directory_path() / "bulkley_io_XXXXXX").string();
      if (!::mkdtemp(pattern.data())) throw RunError("no temporary folder");
      name = pattern;
    });
    path_ = broadcast_text(comm, name);
  }
  ~SharedFolder() {
    MPI_Barrier(comm_.get());
    std::error_code error;
    if (comm_.is_root()) std::filesystem::remove_all(path_, error);
  }
  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const { return (std::filesystem::path(path_) / name).string(); }
  /// As seen by the root. Collective.
  bool has(const std::string& name) const {
    int found = comm_.is_root() && std::filesystem::exists(file(name));
    MPI_Bcast(&found, 1, MPI_INT, 0, comm_.get());
    return found != 0;
  }

 private:
  const Comm& comm_;
  std::string path_;
};

/// What `work` throws: the sentence, or "nothing thrown". To be the same on every rank.
template <class Error, class Work>
std::string sentence_of(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing thrown";
}

inline std::string whole_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void replace_file(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

/// All of a dataset.
template <class Number>
std::vector<Number> whole_array(const Hdf5Reader& file, const std::string& path) {
  const ArrayInfo array = file.array(path);
  std::vector<Number> values(static_cast<std::size_t>(n_elements(array.shape)));
  file.read(array, Extents(array.shape.size(), 0), array.shape, values.data());
  return values;
}

/// How often `part` occurs in `text`.
inline int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

}  // namespace bulkley
