#pragma once
// What a step learns about its particles: bounds for the next dt and for the order-free sums, counts, failures, requests.
// Kernels fill one StepBounds, ranks merge theirs in the one all-reduce of the step.
//
// Every number has a type that says how two of them merge (Largest, Smallest, Total, Extreme), and every group has one list of its
// members, `each`. Merging, checkpoints and tests go through that list, and it does not compile when it lacks a member.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "bulkley/base/types.hpp"

namespace bulkley {

/// The largest of what is included; zero where that is nothing.
template <class T>
struct Largest {
  T value{};
  void include(T other) { value = std::max(value, other); }
  void merge(const Largest& other) { include(other.value); }
  operator T() const { return value; }
};

/// The smallest of what is included; the largest number there is where that is nothing.
template <class T>
struct Smallest {
  T value = std::numeric_limits<T>::has_infinity ? std::numeric_limits<T>::infinity() : std::numeric_limits<T>::max();
  void include(T other) { value = std::min(value, other); }
  void merge(const Smallest& other) { include(other.value); }
  operator T() const { return value; }
};

/// A sum of whole numbers.
struct Total {
  GlobalIndex value = 0;
  Total& operator+=(GlobalIndex other) {
    value += other;
    return *this;
  }
  Total& operator-=(GlobalIndex other) { return *this += -other; }
  Total& operator++() { return *this += 1; }
  void merge(const Total& other) { value += other.value; }
  operator GlobalIndex() const { return value; }
};

/// A largest value and the particle that has it; the smallest id wins ties, so the answer is the same on any rank count.
struct Extreme {
  double value = 0.0;
  GlobalIndex id = -1;

  void include(double other_value, GlobalIndex other_id) {
    if (other_value > value || (other_value == value && other_id >= 0 && (id < 0 || other_id < id))) {
      value = other_value;
      id = other_id;
    }
  }
  void merge(const Extreme& other) { include(other.value, other.id); }
};

/// For the next dt.
struct MotionBounds {
  Extreme speed;              ///< max |v_p|, m/s
  Extreme wave_speed;         ///< max elastic wave speed c, m/s
  Extreme viscosity;          ///< max kinematic viscosity of a viscous stress, J eta / rho_0, m^2/s
  Extreme velocity_gradient;  ///< max ||L_p||_F, 1/s

  template <class Visit, class... Group>
  static constexpr void each(Visit&& visit, Group&&... g) {
    visit("speed", g.speed...);
    visit("wave_speed", g.wave_speed...);
    visit("viscosity", g.viscosity...);
    visit("velocity_gradient", g.velocity_gradient...);
  }
};

/// A particle below both need not be measured to accept a step (measure_motion).
struct MotionLimits {
  double speed = -1.0;              ///< m/s; below 0: every particle is measured
  double velocity_gradient = -1.0;  ///< 1/s, of ||L_p||_F; likewise
};

/// For the order-free sums.
struct SumTerms {
  Largest<double> mass;             ///< max m_p, kg
  Largest<double> momentum;         ///< max m_p (|v_p| + |C_p| r), kg m/s, r = moment_sum_ratio dx
  Largest<double> stress_volume;    ///< max V_p^0 ||tau_p||, J
  Largest<GlobalIndex> cell_count;  ///< largest number of particles with one base cell

  template <class Visit, class... Group>
  static constexpr void each(Visit&& visit, Group&&... g) {
    visit("mass", g.mass...);
    visit("momentum", g.momentum...);
    visit("stress_volume", g.stress_volume...);
    visit("cell_count", g.cell_count...);
  }
};

/// The particles as they are.
struct ParticleTotals {
  Smallest<double> smallest_volume_ratio;
  Largest<double> largest_volume_ratio;
  Total n_particles;

  template <class Visit, class... Group>
  static constexpr void each(Visit&& visit, Group&&... g) {
    visit("smallest_volume_ratio", g.smallest_volume_ratio...);
    visit("largest_volume_ratio", g.largest_volume_ratio...);
    visit("n_particles", g.n_particles...);
  }
};

/// How the particles are distributed, and what has moved in this step.
struct TransportCounts {
  Largest<GlobalIndex> largest_share;  ///< particles of the most loaded rank
  Total n_removed;                     ///< left through an outflow face
  Total n_migrated;                    ///< moved to another rank

  template <class Visit, class... Group>
  static constexpr void each(Visit&& visit, Group&&... g) {
    visit("largest_share", g.largest_share...);
    visit("n_removed", g.n_removed...);
    visit("n_migrated", g.n_migrated...);
  }
};

struct FailureCounts {
  Total n_not_finite;
  Total n_inverted;                      ///< det(1 + dt L) <= 0
  Total n_escaped;                       ///< left the domain where no outflow is declared
  Smallest<GlobalIndex> failed_id;       ///< smallest id among the failed particles
  Total n_undefined_nodes;               ///< where a node force has no finite value
  Smallest<GlobalIndex> undefined_node;  ///< the first of them, z fastest

  bool any() const { return n_not_finite + n_inverted + n_escaped + n_undefined_nodes > 0; }

  template <class Visit, class... Group>
  static constexpr void each(Visit&& visit, Group&&... g) {
    visit("n_not_finite", g.n_not_finite...);
    visit("n_inverted", g.n_inverted...);
    visit("n_escaped", g.n_escaped...);
    visit("failed_id", g.failed_id...);
    visit("n_undefined_nodes", g.n_undefined_nodes...);
    visit("undefined_node", g.undefined_node...);
  }
};

/// What a rank wants of all.
struct StepRequests {
  Largest<std::int32_t> rebuild;  ///< a particle entered a tile that the pools do not hold
  Largest<std::int32_t> sort;     ///< a rank's particles have lost their order; all sort together, for all would wait
  Largest<std::int32_t> caller;   ///< a number that the caller of the step passes on, as its requests to stop

  template <class Visit, class... Group>
  static constexpr void each(Visit&& visit, Group&&... g) {
    visit("rebuild", g.rebuild...);
    visit("sort", g.sort...);
    visit("caller", g.caller...);
  }
};

/// Plain data, exact whatever the order of merging.
struct StepBounds {
  MotionBounds motion;
  SumTerms sums;
  ParticleTotals totals;
  TransportCounts transport;
  FailureCounts failures;
  StepRequests requests;

  bool failed() const { return failures.any(); }
  void merge(const StepBounds& other);

  template <class Visit, class... Bounds>
  static constexpr void each_group(Visit&& visit, Bounds&&... b) {
    visit("motion", b.motion...);
    visit("sums", b.sums...);
    visit("totals", b.totals...);
    visit("transport", b.transport...);
    visit("failures", b.failures...);
    visit("requests", b.requests...);
  }
};

namespace detail {

/// Bytes of the members that `each` lists.
template <class Group>
constexpr std::size_t listed_bytes() {
  std::size_t bytes = 0;
  Group::each([&](const char*, const auto& member) { bytes += sizeof member; }, Group{});
  return bytes;
}

/// Every member of every group is listed: they fill the group. Members of 4 bytes must come in such numbers that they do.
constexpr bool lists_are_complete() {
  std::size_t bytes = 0;
  bool complete = true;
  StepBounds::each_group(
      [&](const char*, const auto& group) {
        using Group = std::remove_cvref_t<decltype(group)>;
        complete = complete && listed_bytes<Group>() == sizeof(Group);
        bytes += sizeof(Group);
      },
      StepBounds{});
  return complete && sizeof(StepBounds) - bytes < alignof(StepBounds);  // but for the padding at the end
}
static_assert(lists_are_complete(), "a member is missing from the list `each` of its group, or a group from `each_group`");

}  // namespace detail

inline void StepBounds::merge(const StepBounds& other) {
  each_group(
      [](const char*, auto& into, const auto& from) {
        std::remove_cvref_t<decltype(into)>::each([](const char*, auto& a, const auto& b) { a.merge(b); }, into, from);
      },
      *this, other);
}

}  // namespace bulkley
