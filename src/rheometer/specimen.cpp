#include "rheometer/specimen.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "bulkley/base/error.hpp"
#include "kernel/stress_update.hpp"
#include "rheometer/root.hpp"

namespace bulkley::rheometer {

namespace {

constexpr double volume = 1.0;  // m^3; no stress depends on it

void copy_state(const ParticleSet& from, ParticleSet& to) {
  for (std::size_t c = 0; c < from.columns().size(); ++c)
    std::memcpy(to.data(c), from.data(c), from.columns()[c].element_size);
}

Tensor<double> diagonal(double xx, double yy, double zz) { return {{xx, 0, 0, 0, yy, 0, 0, 0, zz}}; }

}  // namespace

Tensor<double> step_gradient(Flow flow, double increment, double dt) {
  switch (flow) {
    case Flow::simple_shear:
      return {{0, increment / dt, 0, 0, 0, 0, 0, 0, 0}};
    case Flow::uniaxial_extension: {
      const double across = std::expm1(-0.5 * increment) / dt;
      return diagonal(std::expm1(increment) / dt, across, across);
    }
    case Flow::planar_extension:
      return diagonal(std::expm1(increment) / dt, std::expm1(-increment) / dt, 0.0);
  }
  return {};
}

ParticleSet make_specimen(const Material& material) {
  const NamedMaterial named{.name = {}, .material = material};
  OptionalFields fields = internal_fields({&named, 1});
  fields.insert(Field::velocity_gradient);
  fields.insert(Field::kirchhoff_stress);
  ParticleSet particles(fields, densities_of({&named, 1}));
  particles.resize(1);
  for (int c = 0; c < 3; ++c) particles.real(Field::left_cauchy_green, c)[0] = 1.0;
  particles.real(Field::volume_ratio)[0] = 1.0;
  particles.real(Field::reference_volume)[0] = volume;
  particles.material()[0] = 0;
  particles.id()[0] = 0;
  set_internal_variables(material, 0, particles);
  return particles;
}

Specimen::Specimen(const Material& material)
    : material_(std::make_shared<const Material>(material)), particles_(make_specimen(material)) {}

Specimen::Specimen(const Specimen& other) : material_(other.material_), particles_(make_specimen(*other.material_)) {
  copy_state(other.particles_, particles_);
}

Specimen& Specimen::operator=(const Specimen& other) {
  BULKLEY_ASSERT(material_ == other.material_);
  if (this != &other) copy_state(other.particles_, particles_);
  return *this;
}

bool Specimen::try_advance(const Tensor<double>& velocity_gradient, double dt) {
  for (int c = 0; c < 9; ++c) particles_.real(Field::velocity_gradient, c)[0] = velocity_gradient.c[c];
  StepBounds bounds;
  stress_update(*material_, 0, Field::velocity_gradient, dt, particles_, bounds);
  return !bounds.failed();
}

void Specimen::advance(Flow flow, double strain_increment, double dt) {
  if (!try_advance(step_gradient(flow, strain_increment, dt), dt))
    throw RunError(fmt::format(
        "the material point fails in a step of strain {:g} in {:g} s: its stress is no longer a finite number; a "
        "smaller --strain-per-step may help",
        strain_increment, dt));
}

Reading Specimen::read() const {
  double cauchy[6];
  for (int c = 0; c < 6; ++c) cauchy[c] = particles_.real(Field::kirchhoff_stress, c)[0] / volume_ratio();
  return {cauchy[symmetric_index(0, 1)], cauchy[0] - cauchy[1], cauchy[1] - cauchy[2],
          0.0 - (cauchy[0] + cauchy[1] + cauchy[2]) / 3.0};
}

double Specimen::volume_ratio() const { return particles_.real(Field::volume_ratio)[0]; }

std::optional<double> Specimen::structure() const {
  if (!particles_.has(Field::structure)) return std::nullopt;
  return particles_.real(Field::structure)[0];
}

Specimen loaded_specimen(const Material& material, double pressure) {
  Specimen specimen(material);
  if (pressure == 0.0) return specimen;
  constexpr double dt = 1e-9;         // s: at once, so that what heals or relaxes with time does not
  constexpr double largest = 0.9;     // of the edge
  constexpr double first_try = 1e-9;  // of the edge
  Specimen trial(specimen);
  const auto excess = [&](double squeeze) {
    trial = specimen;
    const double rate = -squeeze / dt;
    if (squeeze >= largest || !trial.try_advance(diagonal(rate, rate, rate), dt)) return not_a_number;
    return trial.read().pressure - pressure;
  };
  const RootSearch search{.start = 0.0, .first_step = first_try, .largest = largest, .tolerance = 1e-10 * pressure};
  if (!find_root(search, excess)) throw UsageError(fmt::format("--pressure {:g}: the material cannot take it", pressure));
  return trial;
}

}  // namespace bulkley::rheometer
