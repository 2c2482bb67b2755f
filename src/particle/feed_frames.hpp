#pragma once
// Key frames of an inflow: rows of t, x, y, z, e.

#include <string>
#include <vector>

#include "particle/inflow.hpp"

namespace bulkley {

/// What is wrong with key frames, a sentence that continues after their name; empty when nothing is. Not collective.
std::string key_frames_fault(const std::vector<FeedFrame>& frames);

/// Rows of five numbers, separated by commas: t, s; x, y, z, m; e, m^3. Lines that are empty or begin with # are left out, and so is
/// a first line of names. Throws UsageError, "line N ...". Not collective.
std::vector<FeedFrame> parse_key_frames(const std::string& text);

}  // namespace bulkley
