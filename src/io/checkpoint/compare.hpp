#pragma once
// Are two checkpoints the same? Particles are matched by id, since their order in a file depends on the ranks.

#include <string>
#include <vector>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

struct FieldDifference {
  std::string name;
  std::string unit;
  GlobalIndex n_different = 0;    ///< values whose bits differ
  double largest_absolute = 0.0;  ///< max |a - b|; infinite where only one is NaN
  GlobalIndex absolute_id = -1;   ///< particle that has it
  double largest_relative = 0.0;  ///< max |a - b| / max(|a|, |b|)
  GlobalIndex relative_id = -1;
  double scale = 0.0;  ///< max |a|, |b| over all particles
};

/// What compare_checkpoints found, the same on every rank.
struct Comparison {
  bool identical = false;  ///< same step and time, same ids, and every field the same bits
  GlobalIndex step_a = 0, step_b = 0;
  double time_a = 0.0, time_b = 0.0;
  GlobalIndex n_a = 0, n_b = 0;
  GlobalIndex n_only_a = 0, n_only_b = 0;            ///< particles that the other file does not have
  GlobalIndex first_only_a = -1, first_only_b = -1;  ///< the smallest such id
  std::vector<FieldDifference>
      fields;  ///< every field of both files, over the particles of both; none if fingerprints agree
  std::vector<std::string> only_in_one;  ///< fields that only one of the files has
};

struct ComparisonOptions {
  bool full = false;  ///< compares every value even if the fingerprints of all fields agree
  GlobalIndex particles_per_round = GlobalIndex{1} << 18;  ///< that a rank sends at a time
};

/// Compares two checkpoints after verifying their checksums and fingerprints. Files whose fingerprints agree are identical. Else
/// each rank reads even shares of both, and particles meet by id on ranks, in rounds; a rank holds its share of one field of both at
/// a time. Throws RunError, also when an id occurs twice in a file. Collective.
Comparison compare_checkpoints(const Comm& comm, const std::string& file_a, const std::string& file_b,
                               const ComparisonOptions& options = {});

/// Same step and ids, and no field (nor the time) differs by more than `tolerance` times its scale. Not collective.
bool within(const Comparison& comparison, double tolerance);

/// "identical", or one line for each difference. Not collective.
std::string comparison_text(const Comparison& comparison);

}  // namespace bulkley
