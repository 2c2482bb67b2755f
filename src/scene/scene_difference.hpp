#pragma once
// Differences between the scene of a checkpoint and the scene that continues from it.

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace bulkley {

/// Keys in which the effective scene `before` differs from `now`, in the order of `now`, each as "key: old -> new". Left out
/// are those that a run may change between its parts: title, time.end, [output], [checkpoint] and [partition]. A key that is
/// newer than `before` counts with its default. Not collective.
std::vector<std::string> scene_differences(const std::string& before, const Scene& now);

}  // namespace bulkley
