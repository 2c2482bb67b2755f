#include "stepping/time_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {
// The deformation predicted from the last step stays this far below the limit, so that small growth is not a rejection.
constexpr double prediction_margin = 0.8;
// A step is checked in advance when the deformation expected from the last step, or from contact at the present speed
// (a stencil reaches a wall by (v dt / dx)^2), comes within this factor of the limit.
constexpr double risk_factor = 2.0;
constexpr double contact_factor = 4.0;
constexpr double default_dt_min = 1e-6;     // of the first limit
constexpr double default_dt_initial = 0.1;  // of the first limit
constexpr GlobalIndex longest_wait = 1000;  // steps

double dt_min(const TimeStepSettings& settings, const TimeStepState& state) {
  return settings.dt_min > 0.0 ? settings.dt_min : default_dt_min * state.dt_first_limit;
}
}  // namespace

const char* name(Limiter limiter) {
  switch (limiter) {
    case Limiter::speed:
      return "speed";
    case Limiter::collider:
      return "collider";
    case Limiter::elastic:
      return "elastic";
    case Limiter::viscous:
      return "viscous";
    case Limiter::deformation:
      return "deformation";
    case Limiter::previous:
      return "previous";
    case Limiter::largest:
      return "largest";
    case Limiter::fixed:
      return "fixed";
    case Limiter::output:
      return "output";
  }
  return "unknown";
}

TimeStepSettings limited_by_fall(const TimeStepSettings& settings, double cell_size, double gravity) {
  TimeStepSettings limited = settings;
  if (settings.integrator != IntegratorKind::imex || gravity == 0.0) return limited;
  const double fall = std::sqrt(2.0 * settings.cfl * cell_size / gravity);
  limited.dt_max = settings.dt_max > 0.0 ? std::min(settings.dt_max, fall) : fall;
  return limited;
}

TimeStepLimit time_step_limit(const TimeStepSettings& settings, double cell_size, const StepBounds& bounds,
                              double collider_speed) {
  TimeStepLimit limit{std::numeric_limits<double>::infinity(), Limiter::largest, -1};
  auto include = [&](double dt, Limiter limiter, GlobalIndex id) {
    if (dt < limit.dt) limit = {dt, limiter, id};
  };
  if (settings.dt_max > 0.0) include(settings.dt_max, Limiter::largest, -1);
  if (bounds.motion.wave_speed.value > 0.0)
    include(settings.elastic_cfl * cell_size / bounds.motion.wave_speed.value, Limiter::elastic,
            bounds.motion.wave_speed.id);
  if (bounds.motion.viscosity.value > 0.0)
    include(settings.viscous_cfl * cell_size * cell_size / (6.0 * bounds.motion.viscosity.value), Limiter::viscous,
            bounds.motion.viscosity.id);
  if (bounds.motion.speed.value > 0.0)
    include(settings.cfl * cell_size / bounds.motion.speed.value, Limiter::speed, bounds.motion.speed.id);
  if (collider_speed > 0.0) include(settings.cfl * cell_size / collider_speed, Limiter::collider, -1);
  if (bounds.motion.velocity_gradient.value > 0.0)
    include(prediction_margin * settings.deformation_limit / bounds.motion.velocity_gradient.value, Limiter::deformation,
            bounds.motion.velocity_gradient.id);
  return limit;
}

namespace {

constexpr const char* advice_on_dt_fixed = "choose a smaller time.dt, mode = \"adaptive\", or allow_unstable = true";
constexpr const char* advice_on_dt_min = "see what drives it there, or set a smaller time.dt_min";

std::string of_particle(GlobalIndex id) { return id < 0 ? "" : fmt::format(" (particle {})", id); }

// The limit that a fixed step exceeds, if it does. Deformation limits accuracy, not stability: a fixed step may exceed that.
std::optional<TimeStepLimit> exceeded_limit(const TimeStepSettings& settings, double cell_size, const StepBounds& bounds,
                                            double collider_speed) {
  StepBounds stability = bounds;
  stability.motion.velocity_gradient = {};
  const TimeStepLimit limit = time_step_limit(settings, cell_size, stability, collider_speed);
  return settings.dt_fixed > limit.dt * (1.0 + 1e-12) ? std::optional(limit) : std::nullopt;
}

std::string excess_of_fixed_step(const TimeStepSettings& settings, const TimeStepLimit& limit) {
  return fmt::format("the fixed time step of {:.6g} s is above the {} limit of {:.6g} s{}", settings.dt_fixed,
                     name(limit.limiter), limit.dt, of_particle(limit.id));
}

}  // namespace

std::string fixed_step_fault(const TimeStepSettings& settings, double cell_size, const StepBounds& bounds) {
  if (settings.mode != TimeStepMode::fixed) return {};
  const auto limit = exceeded_limit(settings, cell_size, bounds, 0.0);
  return limit ? fmt::format("{}; {}", excess_of_fixed_step(settings, *limit), advice_on_dt_fixed) : std::string();
}

namespace {

// Clips `plan` so that outputs are met exactly and no sliver of a step is left before one.
void clip(double remaining, TimeStepPlan& plan) {
  if (plan.dt >= remaining * (1.0 - 1e-9)) {
    plan.full = plan.dt <= remaining * (1.0 + 1e-9);
    plan.dt = remaining;
    plan.lands = true;
  } else if (2.0 * plan.dt > remaining) {
    plan.dt = 0.5 * remaining;
    plan.full = false;
  }
  if (!plan.full) {
    plan.limiter = Limiter::output;
    plan.id = -1;
  }
}

TimeStepPlan plan_fixed(const TimeStepSettings& settings, double cell_size, const StepBounds& bounds, double collider_speed,
                        double remaining) {
  if (const auto limit = exceeded_limit(settings, cell_size, bounds, collider_speed); limit && !settings.allow_unstable)
    throw NoStep(excess_of_fixed_step(settings, *limit), limit->id, advice_on_dt_fixed);
  TimeStepPlan plan{settings.dt_fixed, Limiter::fixed, -1, false, false, false, true, settings.dt_fixed};
  clip(remaining, plan);
  return plan;
}

}  // namespace

TimeStepPlan plan_step(const TimeStepSettings& settings, double cell_size, const StepBounds& bounds, double collider_speed,
                       double remaining, TimeStepState& state) {
  const TimeStepLimit limit = time_step_limit(settings, cell_size, bounds, collider_speed);
  if (!std::isfinite(limit.dt) && settings.mode == TimeStepMode::adaptive && settings.dt_initial <= 0.0)
    throw NoStep("nothing limits the time step (no particle moves or has stiffness)", -1, "set time.dt_max");
  if (state.dt_first_limit == 0.0) {
    state.dt_first_limit = std::isfinite(limit.dt) ? limit.dt : settings.dt_initial;
    state.wait = settings.trial_interval;
  }
  if (settings.mode == TimeStepMode::fixed) return plan_fixed(settings, cell_size, bounds, collider_speed, remaining);

  if (state.dt_stable == 0.0)
    state.dt_stable = std::min(settings.dt_initial > 0.0 ? settings.dt_initial : default_dt_initial * limit.dt, limit.dt);
  if (limit.dt < dt_min(settings, state))
    throw NoStep(fmt::format("the {} limit of {:.6g} s{} is below the smallest time step of {:.6g} s", name(limit.limiter),
                             limit.dt, of_particle(limit.id), dt_min(settings, state)),
                 limit.id, advice_on_dt_min);
  // A limit that has shrunk below the stable step counts at once.
  const double stable = std::min(state.dt_stable, limit.dt);
  const auto propose = [&](double dt) {
    TimeStepPlan plan{dt, limit.limiter, limit.id, dt > stable, false, false, true, dt};
    if (dt < limit.dt) {
      plan.limiter = Limiter::previous;
      plan.id = -1;
    }
    clip(remaining, plan);
    return plan;
  };
  TimeStepPlan plan = propose(stable);
  if (stable < limit.dt && state.since_trial >= state.wait) {
    const TimeStepPlan trial = propose(std::min(limit.dt, settings.growth * stable));
    if (trial.full) plan = trial;  // one that an output would clip is postponed: it would not be a full test
  }

  const double expected = plan.dt * bounds.motion.velocity_gradient.value;
  const double crossing = plan.dt * std::max(bounds.motion.speed.value, collider_speed) / cell_size;
  plan.checked = plan.trial || settings.deformation_check == DeformationCheck::always || state.n_steps == 0 ||
                 risk_factor * expected > settings.deformation_limit ||
                 contact_factor * crossing * crossing > settings.deformation_limit;
  return plan;
}

bool is_acceptable(const TimeStepSettings& settings, double cell_size, const TimeStepPlan& plan, const StepBounds& motion) {
  // Written so that NaN is not acceptable.
  return plan.dt * motion.motion.velocity_gradient.value <= settings.deformation_limit &&
         plan.dt * motion.motion.speed.value <= cell_size && motion.failures.n_not_finite == 0;
}

MotionLimits ample_limits(const TimeStepSettings& settings, double cell_size, const TimeStepPlan& plan) {
  // A node that has no mass because the sums round away what a particle gives it could add 4e-9 to its deformation.
  constexpr double unseen = 1e-7;
  return {(1.0 - unseen) * cell_size / plan.dt, (settings.deformation_limit - unseen) / plan.dt};
}

namespace {

// `reason`: why no smaller step will do, should it come to that.
void reject(const TimeStepSettings& settings, const TimeStepPlan& plan, TimeStepState& state, const std::string& reason,
            GlobalIndex id) {
  ++state.n_rejected;
  if (plan.trial) {
    ++state.n_trials;
    state.wait = std::min(2 * state.wait, longest_wait);
    state.since_trial = 0;
    return;
  }
  const double smallest = dt_min(settings, state);
  if (plan.dt <= smallest)
    throw NoStep(fmt::format("the time step would fall below its smallest value of {:.6g} s: {}", smallest, reason), id,
                 advice_on_dt_min);
  state.dt_stable = std::max(0.5 * plan.dt, smallest);
}

}  // namespace

void reject_step(const TimeStepSettings& settings, const TimeStepPlan& plan, const StepBounds& motion,
                 TimeStepState& state) {
  reject(settings, plan, state,
         fmt::format("even that step deforms a particle by more than {:.3g}", settings.deformation_limit),
         motion.motion.velocity_gradient.id);
}

void reject_unsolved(const TimeStepSettings& settings, const TimeStepPlan& plan, ImplicitPart part, const std::string& fault,
                     TimeStepState& state) {
  const bool viscous = part == ImplicitPart::viscosity;
  const char* const what = viscous ? "viscous motion" : "pressure";
  const int iterations = viscous ? settings.viscous.max_iterations : settings.pressure.max_iterations;
  const std::string how = fault.empty() ? fmt::format("in {} iterations", iterations) : fault;
  if (settings.mode == TimeStepMode::fixed)
    throw NoStep(fmt::format("the {} of a step of {:.6g} s is not found {}", what, plan.dt, how), -1,
                 fmt::format("choose a smaller time.dt, mode = \"adaptive\", or a larger time.{}.max_iterations",
                             viscous ? "viscous" : "pressure"));
  reject(settings, plan, state, fmt::format("even in that step the {} is not found {}", what, how), -1);
}

void accept_step(const TimeStepSettings& settings, const TimeStepPlan& plan, const StepBounds& bounds,
                 TimeStepState& state) {
  ++state.n_steps;
  if (plan.trial) {
    ++state.n_trials;
    ++state.n_accepted;
    state.wait = settings.trial_interval;
    state.since_trial = 0;
  } else {
    ++state.since_trial;
  }
  if (plan.full && settings.mode == TimeStepMode::adaptive) state.dt_stable = plan.dt;
  if (!plan.checked && plan.dt * bounds.motion.velocity_gradient.value > settings.deformation_limit)
    ++state.n_unchecked_large;
}

}  // namespace bulkley
