#pragma once
// Numbers by name: the state in a checkpoint in addition to particles, doubles bit for bit.

#include <map>
#include <string>

#include "bulkley/base/types.hpp"

namespace bulkley {

using Reals = std::map<std::string, double>;
using Integers = std::map<std::string, GlobalIndex>;

}  // namespace bulkley
