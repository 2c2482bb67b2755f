#pragma once
// Index and vector types used everywhere. SI units throughout.

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace bulkley {

using LocalIndex = std::int32_t;   ///< counts and positions within one rank
using GlobalIndex = std::int64_t;  ///< counts over all ranks, particle ids, byte sizes

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Int3 = std::array<int, 3>;

}  // namespace bulkley
