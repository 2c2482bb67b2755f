#pragma once
// Vectors and rotations whose components are drawn one after the other, so that tests have the same numbers whatever order a
// compiler takes the arguments of a call in.

#include <Eigen/Geometry>
#include <random>

namespace bulkley {

template <class Distribution, class Generator>
Eigen::Vector3d random_vector(Distribution& distribution, Generator& generator) {
  const double z = distribution(generator), y = distribution(generator), x = distribution(generator);
  return {x, y, z};
}

/// Any rotation is as likely as any other.
inline Eigen::Matrix3d random_rotation(std::mt19937_64& generator) {
  std::normal_distribution<double> normal(0.0, 1.0);
  const Eigen::Vector3d v = random_vector(normal, generator);
  const double w = normal(generator);
  return Eigen::Quaterniond(w, v.x(), v.y(), v.z()).normalized().toRotationMatrix();
}

}  // namespace bulkley
