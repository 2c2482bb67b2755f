#include "kernel/stress_update.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "bulkley/base/error.hpp"
#include "kernel/batch.hpp"
#include "kernel/particle_stress.hpp"

namespace bulkley {

namespace {

// (V5). Particles that a flow mixes surround one another unevenly, by less than a tenth. Of a larger excess no more than a fifth goes in a
// shear of one, or else the pressure that takes it away is noise.
constexpr double tolerated_fullness = 1.1, decay_by_shear = 5.0, fastest_decay = 0.2;
// (V6). An implicit pressure takes it for what a cell has to lose in the step; the explicit step pulls until the cell has lost it.
constexpr double largest_spread = 1.01;

// What one call finds. Plain numbers, apart from StepBounds: the compiler's choice of products to fuse in the loop below, and with it
// the last bits of the stress, depends on all code that is inlined there, and bookkeeping shall not change it.
struct Tally {
  Extreme wave_speed, viscosity;
  double stress_volume = 0.0;
  double smallest_volume_ratio = std::numeric_limits<double>::infinity();
  double largest_volume_ratio = 0.0;
  GlobalIndex n_not_finite = 0, n_inverted = 0;
  GlobalIndex failed_id = std::numeric_limits<GlobalIndex>::max();

  void add_to(StepBounds& bounds) const {
    bounds.motion.wave_speed.merge(wave_speed);
    bounds.motion.viscosity.merge(viscosity);
    bounds.sums.stress_volume.include(stress_volume);
    bounds.totals.smallest_volume_ratio.include(smallest_volume_ratio);
    bounds.totals.largest_volume_ratio.include(largest_volume_ratio);
    bounds.failures.n_not_finite += n_not_finite;
    bounds.failures.n_inverted += n_inverted;
    bounds.failures.failed_id.include(failed_id);
  }
};

// Per-lane extremes, merged over lanes once.
struct LaneExtremes {
  Extreme wave_speed, viscosity;
  Pack stress_volume_squared{};
  Pack smallest_volume_ratio = broadcast<Pack>(std::numeric_limits<double>::infinity());
  Pack largest_volume_ratio{};

  void include(PackMask valid, Pack speed_squared, const GlobalIndex* id, Pack stress_squared, Pack J) {
    include_lanes(wave_speed, select(valid, speed_squared, broadcast<Pack>(-1.0)), id, n_lanes);
    stress_volume_squared = select(valid & (stress_squared > stress_volume_squared), stress_squared, stress_volume_squared);
    smallest_volume_ratio = select(valid & (J < smallest_volume_ratio), J, smallest_volume_ratio);
    largest_volume_ratio = select(valid & (J > largest_volume_ratio), J, largest_volume_ratio);
  }

  void include_viscosity(PackMask valid, Pack value, const GlobalIndex* id) {
    for (int lane = 0; lane < n_lanes; ++lane)
      if (valid[lane] && value[lane] >= viscosity.value) viscosity.include(value[lane], id[lane]);
  }

  void merge_into(Tally& tally) const {
    tally.wave_speed.merge(wave_speed);
    tally.viscosity.merge(viscosity);
    for (int lane = 0; lane < n_lanes; ++lane) {
      tally.stress_volume = std::max(tally.stress_volume, std::sqrt(stress_volume_squared[lane]));
      tally.smallest_volume_ratio = std::min(tally.smallest_volume_ratio, smallest_volume_ratio[lane]);
      tally.largest_volume_ratio = std::max(tally.largest_volume_ratio, largest_volume_ratio[lane]);
    }
  }
};

// The columns of a law's internal variables, in the order of its state.
template <class Law>
struct InternalColumns {
  static constexpr int n = n_internal<Law>;
  double* column[n > 0 ? n : 1];

  explicit InternalColumns([[maybe_unused]] ParticleSet& particles) {
    [[maybe_unused]] int k = 0;
    for (const Field variable : Law::internal)
      for (int c = 0; c < info(variable).n_components; ++c) column[k++] = particles.real(variable, c);
  }
};

// A law whose yield stress depends on the magnetic field at the particle, which it reads as one more internal variable.
template <class Law>
struct InField {
  const Law& law;
  static constexpr bool flows = Law::flows;
  static constexpr int n_own = n_internal<Law>;
  static constexpr auto internal = [] {
    std::array<Field, Law::internal.size() + 1> fields{};
    std::copy(Law::internal.begin(), Law::internal.end(), fields.begin());
    fields.back() = Field::magnetic_field_strength;
    return fields;
  }();
  template <class Real>
  using Whole = State<Real, n_own + 1>;

  double density() const { return law.density(); }
  double viscosity() const { return law.viscosity(); }
  std::array<double, n_own + 1> initial_internal() const {
    std::array<double, n_own + 1> values{};
    if constexpr (n_own > 0) std::ranges::copy(law.initial_internal(), values.begin());
    return values;
  }
  template <class Real>
  Real wave_speed_squared(const Whole<Real>& state) const {
    return law.wave_speed_squared(own(state));
  }
  template <class Real>
  Update<Real> update(Whole<Real>& state, const Tensor<Real>& velocity_gradient, double dt, const Real* fall) const {
    State<Real, n_own> part = own(state);
    const Update<Real> result = law.update(part, velocity_gradient, dt, state.internal[n_own], fall);
    static_cast<State<Real, 0>&>(state) = part;
    if constexpr (n_own > 0) std::copy_n(part.internal, n_own, state.internal);
    return result;
  }

 private:
  // The state without the field.
  template <class Real>
  static State<Real, n_own> own(const Whole<Real>& state) {
    State<Real, n_own> part;
    static_cast<State<Real, 0>&>(part) = state;
    if constexpr (n_own > 0) std::copy_n(state.internal, n_own, part.internal);
    return part;
  }
};

// The law's update, in a layer if it knows layers.
template <class Law, class WholeState>
Update<Pack> updated(const Law& law, WholeState& state, const Tensor<Pack>& L, double dt, [[maybe_unused]] const Pack* fall) {
  if constexpr (requires { law.update(state, L, dt, fall); })
    return law.update(state, L, dt, fall);
  else
    return law.update(state, L, dt);
}

// A sum of absolute values is finite only if every addend is.
template <int n>
PackMask is_finite(const State<Pack, n>& state, const Update<Pack>& result) {
  Pack sum = state.volume_ratio + result.plastic_shear_rate + result.dissipation;
  for (int c = 0; c < 6; ++c) sum += absolute(state.left_cauchy_green.c[c]) + absolute(result.kirchhoff_stress.c[c]);
  if constexpr (n > 0)
    for (const Pack& variable : state.internal) sum += absolute(variable);
  return absolute(sum) < broadcast<Pack>(std::numeric_limits<double>::infinity());
}

void count_failures(PackMask inverted, PackMask not_finite, const GlobalIndex* id, Tally& tally) {
  for (int lane = 0; lane < n_lanes; ++lane) {
    tally.n_inverted -= inverted[lane];
    tally.n_not_finite -= not_finite[lane];
    if (inverted[lane] | not_finite[lane]) tally.failed_id = std::min(tally.failed_id, id[lane]);
  }
}

// Shear in a step: dt sqrt(2 dev D : dev D).
Pack shear_of(const Tensor<Pack>& L, double dt) {
  const Pack mean = (1.0 / 3.0) * ((L(0, 0) + L(1, 1)) + L(2, 2));
  Pack square{};
  for (int a = 0; a < 3; ++a) {
    const Pack normal = L(a, a) - mean, shear = L(a, (a + 1) % 3) + L((a + 1) % 3, a);
    square += 2.0 * (normal * normal) + shear * shear;
  }
  return dt * square_root(square);
}

// J of particles that have less room than it says: the excess decays with the shear, the faster the larger it is (V5).
Pack crowded(Pack J, Pack fullness, const Tensor<Pack>& L, double dt) {
  const Pack excess = maximum(fullness * J - tolerated_fullness, broadcast<Pack>(0.0));
  if (!any(excess > broadcast<Pack>(0.0))) return J;
  return J / (1.0 + shear_of(L, dt) * minimum(decay_by_shear * (excess * excess), broadcast<Pack>(fastest_decay)));
}

// J of particles that have more room than it says: what is missing decays with the shear, (V6).
Pack spread(Pack J, Pack missing, const Tensor<Pack>& L, double dt) {
  if (!any(missing > broadcast<Pack>(0.0))) return J;
  return minimum(J * (1.0 + shear_of(L, dt) * missing), maximum(J, broadcast<Pack>(largest_spread)));
}

// Flattened: every call below is inlined here, so that this file's floating-point options hold for all of it.
template <class Law>
[[gnu::flatten]] void update_all(const Law& law, std::uint8_t material_index, Field gradient, double dt,
                                 const CellMeans& means, const Room& room, const double* falls, ParticleSet& particles,
                                 Tally& tally, ParticleBlock block) {
  const FieldColumns<9> velocity_gradient(particles, gradient);
  const MutableColumns<6> left_cauchy_green(particles, Field::left_cauchy_green);
  const InternalColumns<Law> internal(particles);
  const StateColumns states(law, particles);
  const MutableColumns<1> volume_ratio(particles, Field::volume_ratio);
  std::optional<MutableColumns<6>> kirchhoff_stress;
  if (particles.has(Field::kirchhoff_stress)) kirchhoff_stress.emplace(particles, Field::kirchhoff_stress);
  const MutableColumns<1> plastic_shear_rate(particles, Field::plastic_shear_rate);
  const MutableColumns<1> plastic_dissipation(particles, Field::plastic_dissipation);
  const FieldColumns<1> reference_volume(particles, Field::reference_volume);
  const std::uint8_t* material = particles.material();
  const GlobalIndex* id = particles.id();
  const LocalIndex end = std::min(block.end, particles.size());
  const PackMask lane = lane_numbers();
  const Pack zero{};
  const double kinematic_viscosity = law.viscosity() / law.density(), least_stress = stress_rounding * law.density();
  LaneExtremes extremes;

  for (LocalIndex p = block.begin; p < end; p += n_lanes) {
    const PackMask mine = lanes_of_material(material + p, material_index, lane, end - p);
    if (!any(mine)) continue;
    left_cauchy_green.prefetch(p + prefetch_distance);
    if (kirchhoff_stress) kirchhoff_stress->prefetch(p + prefetch_distance);
    volume_ratio.prefetch(p + prefetch_distance);
    reference_volume.prefetch(p + prefetch_distance);
    if constexpr (Law::flows) {
      plastic_shear_rate.prefetch(p + prefetch_distance);
      plastic_dissipation.prefetch(p + prefetch_distance);
    }

    Tensor<Pack> L;
    for (int c = 0; c < 9; ++c) L.c[c] = select(mine, velocity_gradient(p, c), zero);
    if (means.any()) {
      const Pack own = (L(0, 0) + L(1, 1)) + L(2, 2);
      const Pack change = select(mine, (1.0 / 3.0) * (means.of(&CellSums::dilation, p, own) - own), zero);
      for (int a = 0; a < 3; ++a) L(a, a) += change;
    }
    State<Pack, n_internal<Law>> state = states.of(p, mine);
    if (means.any()) {
      const Pack own = state.volume_ratio;
      state.volume_ratio += select(mine, means.relaxation * (means.of(&CellSums::ratio, p, own) - own), zero);
    }
    if constexpr (Law::flows) {
      Pack& J = state.volume_ratio;
      if (room.fullness) J = select(mine, crowded(J, load(room.fullness + (p - block.begin)), L, dt), J);
      if (room.missing) J = select(mine, spread(J, load(room.missing + (p - block.begin)), L, dt), J);
    }

    Tensor<Pack> f;
    for (int c = 0; c < 9; ++c) f.c[c] = L.c[c] * dt;
    for (int a = 0; a < 3; ++a) f(a, a) += 1.0;
    const PackMask inverted = mine & (determinant(f) <= zero);

    const Pack fall = falls ? load(falls + (p - block.begin)) : zero;
    const Update<Pack> result = updated(law, state, L, dt, falls ? &fall : nullptr);

    const PackMask not_finite = mine & ~inverted & ~is_finite(state, result);
    const PackMask valid = mine & ~inverted & ~not_finite;
    if (any(inverted | not_finite)) count_failures(inverted, not_finite, id + p, tally);

    // Other particles keep their values.
    const auto put = [&](const auto& columns, Pack value, int c = 0) {
      columns.store(p, select(valid, value, columns(p, c)), c);
    };
    for (int c = 0; c < 6; ++c) put(left_cauchy_green, state.left_cauchy_green.c[c], c);
    if (kirchhoff_stress)
      for (int c = 0; c < 6; ++c) put(*kirchhoff_stress, result.kirchhoff_stress.c[c], c);
    put(volume_ratio, state.volume_ratio);
    if constexpr (internal.n > 0)
      for (int k = 0; k < internal.n; ++k) {
        double* value = internal.column[k] + p;
        store(value, select(valid, state.internal[k], load(value)));
      }
    if constexpr (Law::flows) {
      put(plastic_shear_rate, result.plastic_shear_rate);
      put(plastic_dissipation, plastic_dissipation(p) + result.dissipation);
    }

    if (kinematic_viscosity > 0.0) extremes.include_viscosity(valid, kinematic_viscosity * state.volume_ratio, id + p);
    const Pack volume = reference_volume(p), speed_squared = law.wave_speed_squared(state);
    const Pack rounding = least_stress * speed_squared;
    extremes.include(valid, speed_squared, id + p,
                     (volume * volume) * (norm_squared(result.kirchhoff_stress) + rounding * rounding), state.volume_ratio);
  }
  extremes.merge_into(tally);
}

}  // namespace

void set_internal_variables(const Material& material, std::uint8_t material_index, ParticleSet& particles) {
  std::visit(
      [&]<class Law>(const Law& law) {
        if constexpr (InternalColumns<Law>::n != 0) {
          const InternalColumns<Law> internal(particles);
          const auto rest = state_at_rest(law);
          for (LocalIndex p = 0; p < particles.size(); ++p)
            if (particles.material()[p] == material_index)
              for (int k = 0; k < internal.n; ++k) internal.column[k][p] = rest.internal[k];
        }
      },
      material);
}

void set_stress(std::span<const NamedMaterial> materials, ParticleSet& particles) {
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    const auto stress_of = [&](const auto& law) { return law.kirchhoff_stress(particle_state(law, particles, p)); };
    const SymTensor<double> stress = std::visit(stress_of, materials[particles.material()[p]].material);
    for (int c = 0; c < 6; ++c) particles.real(Field::kirchhoff_stress, c)[p] = stress.c[c];
  }
}

OptionalFields internal_fields(std::span<const NamedMaterial> materials) {
  OptionalFields fields;
  for (const NamedMaterial& named : materials)
    for (const Field variable : internal_variables(named.material)) fields.insert(variable);
  for (const NamedMaterial& named : materials)
    if (field_yield(named.material).given()) fields.insert(Field::magnetic_field_strength);
  if (!StressOfState(materials).any()) fields.insert(Field::kirchhoff_stress);
  return fields;
}

Densities densities_of(std::span<const NamedMaterial> materials) {
  std::vector<double> densities;
  for (const NamedMaterial& named : materials) densities.push_back(rest_density(named.material));
  return Densities(densities);
}

void stress_update(const Material& material, std::uint8_t material_index, Field gradient, double dt, ParticleSet& particles,
                   StepBounds& bounds, ParticleBlock block, const CellMeans& means, const Room& room, const double* fall) {
  BULKLEY_ASSERT(dt > 0.0);
  BULKLEY_ASSERT(gradient == Field::affine_velocity || gradient == Field::velocity_gradient);
  Tally tally;
  std::visit(
      [&]<class Law>(const Law& law) {
        if constexpr (requires { law.parameters.field_yield; })
          if (law.parameters.field_yield.given())
            return update_all(InField<Law>{law}, material_index, gradient, dt, means, room, fall, particles, tally, block);
        update_all(law, material_index, gradient, dt, means, room, fall, particles, tally, block);
      },
      material);
  tally.add_to(bounds);
}

}  // namespace bulkley
