#pragma once
// Fields on a regular box of nodes, as frames show them and checkpoints keep them.

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "bulkley/base/types.hpp"

namespace bulkley {

/// A rank's part of a box of nodes with fields on them; its arrays run over its own nodes, z fastest, and may be empty.
struct BoxFields {
  struct Field {
    std::string name, unit, meaning;
    std::vector<std::vector<double>> components;  ///< one or three, each by own node
  };

  std::string name;           ///< of the group in files, [a-z_], and none of theirs
  Vec3 origin;                ///< of node (0, 0, 0), m
  double spacing = 0.0;       ///< m
  Int3 n_nodes{0, 0, 0};      ///< of the whole box
  Int3 first{0, 0, 0};        ///< first own node along each axis
  Int3 count{0, 0, 0};        ///< own nodes along each axis
  std::vector<Field> fields;  ///< the same names on every rank
};

/// Fills the components of a box's fields from where they are kept; false, and nothing, where they are not. Collective.
using BoxSource = std::function<bool(BoxFields& box)>;

}  // namespace bulkley
