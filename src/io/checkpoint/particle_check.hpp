#pragma once
// Requirements on particles in a checkpoint, beyond its checksums: a complete file may be wrong.

#include <string>
#include <vector>

#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"

namespace bulkley {

/// Checks the rows of a rank's part as they are read or written.
class ParticleCheck {
 public:
  /// `what`: how sentences begin. `n_materials`: indices of materials must be below it.
  ParticleCheck(std::string what, std::size_t n_materials) : what_(std::move(what)), n_materials_(n_materials) {}

  /// `rows`: `n` rows of a field, of which the first is particle `first` of the file. Not collective.
  void look_at(const FieldInfo& field, GlobalIndex first, GlobalIndex n, const std::byte* rows);

  /// Throws RunError with the first fault that this rank has seen. Not collective.
  void throw_if_seen() const;

 private:
  void refuse(const FieldInfo& field, GlobalIndex particle, const std::string& fault);
  std::string what_;
  std::size_t n_materials_;
  std::string fault_;
};

/// Throws RunError, a sentence that begins with `what` and names an id that several of the ranks' particles have, if there is one.
/// Ids meet by hash on ranks, in rounds of bounded memory, and every rank sends to every other. Collective.
void expect_unique(const Comm& comm, const std::string& what, const std::vector<GlobalIndex>& ids);

}  // namespace bulkley
