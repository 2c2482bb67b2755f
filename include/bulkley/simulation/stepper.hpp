#pragma once
// A scene that a program steps by itself: no files, no stops, no changes of the partition. Whole runs: bulkley/program.hpp.

#include <memory>
#include <string>
#include <vector>

#include "bulkley/integrator/diagnostics.hpp"
#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"

namespace bulkley {

class Stepper {
 public:
  /// Parses the text of a scene (the same on every rank), loads its meshes, and seeds its particles. `file_name`: for
  /// messages, and where relative paths start. `overrides`: "key.path=value". `comm` must outlive it. Throws UsageError and
  /// RunError, alike on every rank. Collective.
  Stepper(const Comm& comm, const std::string& scene_text, const std::string& file_name,
          const std::vector<std::string>& overrides = {});
  ~Stepper();
  Stepper(Stepper&&) noexcept;

  double time() const;          ///< s
  GlobalIndex n_steps() const;  ///< taken so far
  double dt() const;            ///< of the last step, s; 0 before the first
  double end_time() const;      ///< as the scene says, s
  /// Takes steps until `duration` seconds have passed. Throws RunError, the same on every rank, when particles fail.
  /// Collective.
  void advance(double duration);

  /// Those of this rank. Not collective.
  const ParticleSet& particles() const;
  /// Over all ranks; the same bits on any number of them. Collective.
  Diagnostics diagnostics() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace bulkley
