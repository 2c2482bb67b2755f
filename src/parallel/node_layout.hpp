#pragma once
// Which ranks share a node of the machine.

#include <string>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

struct NodeLayout {
  /// Ranks 0 .. ranks_per_node - 1 share a node, the next so many another, and so on; the last node may have fewer. 1 where it is otherwise.
  int ranks_per_node = 1;
  bool in_order = true;  ///< the ranks of every node follow each other
};

/// As MPI says who shares memory; the same on every rank. Collective; takes a communicator for each node while it lasts.
NodeLayout node_layout(const Comm& comm);

/// A sentence for users whose ranks are not in order; empty if they are. Not collective.
std::string placement_fault(const NodeLayout& layout);

}  // namespace bulkley
