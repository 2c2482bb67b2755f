#pragma once
// What tests of kernels and solver build their particles with, and the list of transfers they run through.

#include <cstring>
#include <string>
#include <vector>

#include "bulkley/base/tensor.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "kernel/transfer.hpp"

namespace bulkley {

/// All combinations of scheme, spline order and gradient form.
inline std::vector<TransferSettings> all_transfers() {
  std::vector<TransferSettings> result;
  for (const auto scheme :
       {TransferScheme::pic, TransferScheme::flip, TransferScheme::blend, TransferScheme::apic, TransferScheme::moment_flip})
    for (const auto order : {SplineOrder::quadratic, SplineOrder::cubic})
      for (const auto gradient : {GradientForm::mls, GradientForm::bspline})
        result.push_back({.scheme = scheme,
                          .order = order,
                          .gradient = gradient,
                          .damping_time = scheme == TransferScheme::moment_flip ? 0.01 : 0.0});
  return result;
}

inline std::string describe(const TransferSettings& t) {
  const char* const schemes[] = {"pic", "flip", "blend", "apic", "moment_flip"};
  return std::string(schemes[static_cast<int>(t.scheme)]) + (t.order == SplineOrder::cubic ? " cubic" : " quadratic") +
         (t.gradient == GradientForm::mls ? " mls" : " bspline");
}

inline void set_tensor(ParticleSet& set, Field field, LocalIndex p, const Mat3& value) {
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) set.real(field, 3 * a + b)[p] = value(a, b);
}

inline void set_symmetric(ParticleSet& set, Field field, LocalIndex p, const Mat3& value) {
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b) set.real(field, symmetric_index(a, b))[p] = value(a, b);
}

inline Mat3 tensor(const ParticleSet& set, Field field, LocalIndex p) {
  Mat3 value;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) value(a, b) = set.real(field, 3 * a + b)[p];
  return value;
}

/// A particle at rest and without stress; the caller sets the rest.
inline void place_particle(ParticleSet& set, LocalIndex p, const Vec3& x, double volume) {
  set.set_vector(Field::position, p, x);
  set_symmetric(set, Field::left_cauchy_green, p, Mat3::Identity());
  set.real(Field::volume_ratio)[p] = 1.0;
  set.real(Field::reference_volume)[p] = volume;
  set.id()[p] = p;
}

/// The optional fields of particles that store their stress and have no internal variables.
inline OptionalFields stressed_fields(bool gradient = false) {
  return gradient ? OptionalFields{Field::kirchhoff_stress, Field::velocity_gradient} : OptionalFields{Field::kirchhoff_stress};
}

/// The particles `order[0], order[1], ...` of a set, with the optional fields `fields`, zero where they are new.
inline ParticleSet picked(const ParticleSet& set, const std::vector<LocalIndex>& order, OptionalFields fields) {
  ParticleSet result(fields, set.densities());
  result.resize(static_cast<LocalIndex>(order.size()));
  std::size_t to = 0;
  for (std::size_t from = 0; from < set.columns().size(); ++from) {
    while (result.columns()[to].field < set.columns()[from].field) ++to;
    if (result.columns()[to].field != set.columns()[from].field) continue;
    const std::size_t size = set.columns()[from].element_size;
    for (std::size_t k = 0; k < order.size(); ++k)
      std::memcpy(result.data(to) + k * size, set.data(from) + static_cast<std::size_t>(order[k]) * size, size);
    ++to;
  }
  return result;
}
inline ParticleSet picked(const ParticleSet& set, const std::vector<LocalIndex>& order) {
  return picked(set, order, set.optional_fields());
}

/// Whether two sets of the same fields hold the same bits in the same order.
inline bool same_particles(const ParticleSet& a, const ParticleSet& b) {
  if (a.size() != b.size() || a.columns().size() != b.columns().size()) return false;
  for (std::size_t c = 0; c < a.columns().size(); ++c)
    if (std::memcmp(a.data(c), b.data(c), a.columns()[c].element_size * static_cast<std::size_t>(a.size())) != 0)
      return false;
  return true;
}

}  // namespace bulkley
