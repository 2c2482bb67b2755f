// The controller of the time step (docs/theory.md, "Time step"), driven without particles: a made-up motion says how a step
// ends.
#include "stepping/time_step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "bulkley/base/error.hpp"

namespace bulkley::time_step_test {
namespace {

constexpr double dx = 0.1;       // m
constexpr double is_full = 1e9;  // s to the next output
const std::string advice = "; see what drives it there, or set a smaller time.dt_min";

// Bounds of particles with this largest speed, wave speed and velocity gradient, each of another particle.
StepBounds moving(double speed, double wave_speed, double gradient) {
  StepBounds bounds;
  bounds.motion.speed = {speed, 11};
  bounds.motion.wave_speed = {wave_speed, 22};
  bounds.motion.velocity_gradient = {gradient, 33};
  return bounds;
}

// The same with this largest kinematic viscosity, m^2/s.
StepBounds viscous(StepBounds bounds, double viscosity) {
  bounds.motion.viscosity = {viscosity, 44};
  return bounds;
}

// One step as the solver takes it: plans, judges by `motion` where the plan asks for it, accepts. Returns the plan taken.
TimeStepPlan take_step(const TimeStepSettings& settings, const StepBounds& before, const StepBounds& motion,
                       double remaining, TimeStepState& state) {
  for (;;) {
    const TimeStepPlan plan = plan_step(settings, dx, before, 0.0, remaining, state);
    if (!plan.checked || is_acceptable(settings, dx, plan, motion)) {
      accept_step(settings, plan, motion, state);
      return plan;
    }
    reject_step(settings, plan, motion, state);
  }
}

template <class Function>
std::string message_of(Function function) {
  try {
    function();
  } catch (const NoStep& error) {
    return error.what() + ("; " + error.advice);
  }
  return "no error";
}

// --- the limit -------------------------------------------------------------------------------------------------------

TEST(TimeStep, TheSmallestOfTheLimitsCountsAndNamesItsParticle) {
  TimeStepSettings settings;  // cfl 0.5, elastic_cfl 0.4, deformation_limit 0.1
  struct Case {
    StepBounds bounds;
    double largest, dt;
    Limiter limiter;
    GlobalIndex id;
  };
  const Case cases[] = {
      {moving(10.0, 1.0, 1.0), 0.0, 0.5 * dx / 10.0, Limiter::speed, 11},
      {moving(1.0, 10.0, 1.0), 0.0, 0.4 * dx / 10.0, Limiter::elastic, 22},
      {moving(1.0, 1.0, 100.0), 0.0, 0.8 * 0.1 / 100.0, Limiter::deformation, 33},
      {moving(1.0, 1.0, 1.0), 1e-5, 1e-5, Limiter::largest, -1},
      {moving(0.0, 10.0, 0.0), 0.0, 0.4 * dx / 10.0, Limiter::elastic, 22},
      {viscous(moving(1.0, 1.0, 1.0), 2.0), 0.0, 0.5 * dx * dx / (6.0 * 2.0), Limiter::viscous, 44},
      {viscous(moving(1.0, 100.0, 1.0), 2.0), 0.0, 0.4 * dx / 100.0, Limiter::elastic, 22},
      {viscous(moving(0.0, 0.0, 0.0), 2.0), 0.0, 0.5 * dx * dx / (6.0 * 2.0), Limiter::viscous, 44},
  };
  for (const Case& c : cases) {
    settings.dt_max = c.largest;
    const TimeStepLimit limit = time_step_limit(settings, dx, c.bounds, 0.0);
    EXPECT_DOUBLE_EQ(limit.dt, c.dt);
    EXPECT_EQ(limit.limiter, c.limiter);
    EXPECT_EQ(limit.id, c.id);
  }
}

TEST(TimeStep, AFallFromRestLimitsAnImplicitStep) {
  TimeStepSettings settings;
  EXPECT_EQ(limited_by_fall(settings, 0.01, 10.0).dt_max, 0.0) << "explicit";
  settings.integrator = IntegratorKind::imex;
  settings.cfl = 0.5;
  EXPECT_EQ(limited_by_fall(settings, 0.01, 0.0).dt_max, 0.0) << "no gravity";
  EXPECT_DOUBLE_EQ(limited_by_fall(settings, 0.01, 10.0).dt_max, std::sqrt(1e-3));
  settings.dt_max = 1e-3;
  EXPECT_EQ(limited_by_fall(settings, 0.01, 10.0).dt_max, 1e-3) << "the user's is smaller";
}

TEST(TimeStep, WithoutAnyLimitTheUserIsAsked) {
  TimeStepSettings settings;
  TimeStepState state;
  EXPECT_EQ(message_of([&] { plan_step(settings, dx, moving(0, 0, 0), 0.0, is_full, state); }),
            "nothing limits the time step (no particle moves or has stiffness); set time.dt_max");
  settings.dt_max = 1e-3;
  TimeStepState fresh;
  EXPECT_DOUBLE_EQ(plan_step(settings, dx, moving(0, 0, 0), 0.0, is_full, fresh).dt, 1e-4);
}

// --- growth ----------------------------------------------------------------------------------------------------------

// T12 (i): nothing deforms, so each attempt succeeds and multiplies the step by the growth factor, up to the limit.
TEST(TimeStep, TranslationClimbsByTheGrowthFactorToTheLimit) {
  TimeStepSettings settings;
  settings.trial_interval = 4;
  settings.growth = 1.5;
  TimeStepState state;
  const StepBounds motion = moving(1.0, 0.0, 0.0);
  const double limit = 0.5 * dx;
  double expected = 0.1 * limit;
  int n_attempts = 0;
  for (int step = 0; step < 60; ++step) {
    const TimeStepPlan plan = take_step(settings, motion, motion, is_full, state);
    const bool attempt = plan.dt > expected * 1.0001;
    if (attempt) {
      expected = std::min(limit, expected * settings.growth);
      ++n_attempts;
      EXPECT_EQ(step % 5, 4) << "an attempt every trial_interval steps";
    }
    EXPECT_NEAR(plan.dt, expected, 1e-14 * expected);
    EXPECT_EQ(plan.trial, attempt);
    EXPECT_EQ(plan.limiter, expected < limit ? Limiter::previous : Limiter::speed);
  }
  EXPECT_EQ(n_attempts, 6);  // 1.5^6 > 10
  EXPECT_EQ(state.n_trials, 6);
  EXPECT_EQ(state.n_accepted, 6);
  EXPECT_EQ(state.n_rejected, 0);
  EXPECT_DOUBLE_EQ(state.dt_stable, limit);
}

// T12 (ii): under a shear of 100/s no step above theta / 100 is taken, whatever the other limits allow.
TEST(TimeStep, ShearBoundsTheAcceptedStep) {
  TimeStepSettings settings;
  settings.dt_initial = 0.04;
  settings.trial_interval = 2;
  TimeStepState state;
  const StepBounds still = moving(1.0, 0.0, 0.0), sheared = moving(1.0, 0.0, 100.0);
  TimeStepPlan plan = take_step(settings, still, sheared, is_full, state);  // unexpected: the particles were at rest
  EXPECT_LE(plan.dt, 1e-3);
  EXPECT_GT(plan.dt, 0.5e-3);
  EXPECT_EQ(state.n_rejected, 6);  // halved from 0.04
  for (int step = 0; step < 100; ++step) {
    plan = take_step(settings, sheared, sheared, is_full, state);
    EXPECT_LE(plan.dt, 1e-3);
  }
  EXPECT_NEAR(plan.dt, 0.8e-3, 1e-9);  // the margin of the prediction
  EXPECT_EQ(plan.limiter, Limiter::deformation);
}

TEST(TimeStep, ALimitThatShrinksCountsAtOnce) {
  TimeStepSettings settings;
  settings.dt_initial = 1e-2;
  TimeStepState state;
  take_step(settings, moving(1.0, 0, 0), moving(1.0, 0, 0), is_full, state);
  const TimeStepPlan plan = take_step(settings, moving(50.0, 0, 0), moving(50.0, 0, 0), is_full, state);
  EXPECT_DOUBLE_EQ(plan.dt, 0.5 * dx / 50.0);
  EXPECT_EQ(plan.limiter, Limiter::speed);
  EXPECT_EQ(plan.id, 11);
  EXPECT_FALSE(plan.trial);
  EXPECT_DOUBLE_EQ(state.dt_stable, plan.dt);
  // It does not jump back when the limit widens again.
  EXPECT_DOUBLE_EQ(plan_step(settings, dx, moving(1.0, 0, 0), 0.0, is_full, state).dt, plan.dt);
}

// --- rejection -------------------------------------------------------------------------------------------------------

TEST(TimeStep, ARejectedTrialFallsBackToTheStableStepAndDoublesTheWait) {
  TimeStepSettings settings;
  settings.trial_interval = 4;
  settings.dt_initial = 1e-3;
  TimeStepState state;
  const StepBounds before = moving(1.0, 0.0, 10.0);
  const StepBounds motion = moving(1.0, 0.0, 90.0);  // 1e-3 s is fine, 1.5e-3 s is not
  std::vector<int> attempts;
  GlobalIndex n_rejected = 0;
  for (int step = 0; step < 150; ++step) {
    const TimeStepPlan plan = take_step(settings, before, motion, is_full, state);
    EXPECT_DOUBLE_EQ(plan.dt, 1e-3);
    EXPECT_FALSE(plan.trial);
    EXPECT_DOUBLE_EQ(state.dt_stable, 1e-3);
    if (state.n_rejected > n_rejected) attempts.push_back(step);
    n_rejected = state.n_rejected;
  }
  EXPECT_EQ(attempts, (std::vector<int>{4, 12, 28, 60, 124}));  // 4 steps, then 8, 16, 32, 64 after each
  EXPECT_EQ(state.n_trials, 5);
  EXPECT_EQ(state.n_accepted, 0);

  // The cool-down has an end, and an accepted trial resets it.
  for (int step = 0; step < 10000; ++step) take_step(settings, before, motion, is_full, state);
  EXPECT_EQ(state.wait, 1000);
  const StepBounds calm = moving(1.0, 0.0, 10.0);
  while (state.n_accepted == 0) take_step(settings, calm, calm, is_full, state);
  EXPECT_EQ(state.wait, settings.trial_interval);
}

TEST(TimeStep, AnyOtherBadStepHalvesTheStableStepUntilTheSmallest) {
  TimeStepSettings settings;
  settings.dt_initial = 1e-2;
  settings.dt_min = 3e-3;
  TimeStepState state;
  const StepBounds still = moving(1.0, 0.0, 0.0), torn = moving(1.0, 0.0, 1e6);
  EXPECT_EQ(
      message_of([&] { take_step(settings, still, torn, is_full, state); }),
      "the time step would fall below its smallest value of 0.003 s: even that step deforms a particle by more than 0.1" +
          advice);
  EXPECT_EQ(state.n_rejected, 3);  // 1e-2, 5e-3, then 3e-3 itself
  // The smallest step itself is tried, not one below it.
  TimeStepState other;
  EXPECT_DOUBLE_EQ(take_step(settings, still, moving(1.0, 0.0, 30.0), is_full, other).dt, 3e-3);
}

TEST(TimeStep, ALimitBelowTheSmallestStepIsAnError) {
  TimeStepSettings settings;
  settings.dt_min = 1e-3;
  TimeStepState state;
  EXPECT_EQ(message_of([&] { plan_step(settings, dx, moving(1.0, 100.0, 0.0), 0.0, is_full, state); }),
            "the elastic limit of 0.0004 s (particle 22) is below the smallest time step of 0.001 s" + advice);
  // By default a millionth of the first limit.
  TimeStepSettings defaults;
  TimeStepState other;
  take_step(defaults, moving(1.0, 0, 0), moving(1.0, 0, 0), is_full, other);
  EXPECT_EQ(message_of([&] { plan_step(defaults, dx, moving(0.99e6, 0, 0), 0.0, is_full, other); }), "no error");
  EXPECT_EQ(message_of([&] { plan_step(defaults, dx, moving(2e6, 0, 0), 0.0, is_full, other); }),
            "the speed limit of 2.5e-08 s (particle 11) is below the smallest time step of 5e-08 s" + advice);
}

TEST(TimeStep, WhatIsAcceptable) {
  const TimeStepSettings settings;
  const TimeStepPlan plan{1e-3, Limiter::previous, -1, true, true, false, true, 1e-3};
  EXPECT_TRUE(is_acceptable(settings, dx, plan, moving(1.0, 0.0, 100.0)));  // exactly theta
  EXPECT_FALSE(is_acceptable(settings, dx, plan, moving(1.0, 0.0, 100.1)));
  EXPECT_TRUE(is_acceptable(settings, dx, plan, moving(100.0, 0.0, 0.0)));  // exactly one cell
  EXPECT_FALSE(is_acceptable(settings, dx, plan, moving(100.1, 0.0, 0.0)));
  StepBounds lost = moving(1.0, 0.0, 0.0);
  lost.failures.n_not_finite.value = 1;
  EXPECT_FALSE(is_acceptable(settings, dx, plan, lost));
  EXPECT_FALSE(is_acceptable(settings, dx, plan, moving(1.0, 0.0, std::numeric_limits<double>::quiet_NaN())));
}

TEST(TimeStep, RiskyStepsAreChecked) {
  TimeStepSettings settings;
  settings.dt_initial = 1e-3;
  settings.trial_interval = 100;
  TimeStepState state;
  const StepBounds calm = moving(1.0, 0.0, 1.0);
  EXPECT_TRUE(take_step(settings, calm, calm, is_full, state).checked) << "the first step is";
  EXPECT_FALSE(plan_step(settings, dx, calm, 0.0, is_full, state).checked);
  EXPECT_TRUE(plan_step(settings, dx, moving(1.0, 0.0, 51.0), 0.0, is_full, state).checked) << "deformation near the limit";
  EXPECT_TRUE(plan_step(settings, dx, moving(17.0, 0.0, 0.0), 0.0, is_full, state).checked)
      << "fast enough for a hard contact";
  settings.deformation_check = DeformationCheck::always;
  EXPECT_TRUE(plan_step(settings, dx, calm, 0.0, is_full, state).checked);
}

TEST(TimeStep, UncheckedStepsThatDeformTooMuchAreCounted) {
  TimeStepSettings settings;
  settings.dt_initial = 1e-3;
  TimeStepState state;
  const StepBounds calm = moving(1.0, 0.0, 1.0);
  take_step(settings, calm, calm, is_full, state);
  take_step(settings, calm, moving(1.0, 0.0, 200.0), is_full, state);
  EXPECT_EQ(state.n_unchecked_large, 1);
}

// --- outputs ---------------------------------------------------------------------------------------------------------

TEST(TimeStep, OutputsAreMetExactlyAndNeverChangeTheStableStep) {
  TimeStepSettings settings;
  settings.dt_initial = 1e-3;
  settings.dt_max = 1e-3;
  TimeStepState state;
  const StepBounds motion = moving(1.0, 0.0, 0.0);
  const double interval = 2.7e-3;
  for (int frame = 1; frame <= 50; ++frame) {
    const double target = frame * interval;
    double time = (frame - 1) * interval, smallest = 1.0;
    for (bool landed = false; !landed;) {
      const TimeStepPlan plan = take_step(settings, motion, motion, target - time, state);
      landed = plan.lands;
      time = landed ? target : time + plan.dt;
      smallest = std::min(smallest, plan.dt);
      EXPECT_EQ(plan.limiter == Limiter::output, !plan.full);
      EXPECT_EQ(plan.unclipped, 1e-3);
      EXPECT_EQ(state.dt_stable, 1e-3);
      EXPECT_LE(time, target);
    }
    EXPECT_GT(smallest, 0.4e-3) << "no slivers";
  }
  EXPECT_EQ(state.n_steps, 150);
}

TEST(TimeStep, AStepThatFitsButForRoundingIsAWholeStep) {
  TimeStepSettings settings;
  settings.dt_initial = settings.dt_max = 1e-3;
  TimeStepState state;
  const StepBounds motion = moving(1.0, 0.0, 0.0);
  for (const double remaining : {1e-3, 1e-3 * (1.0 + 1e-12), 1e-3 * (1.0 - 1e-12)}) {
    const TimeStepPlan plan = plan_step(settings, dx, motion, 0.0, remaining, state);
    EXPECT_EQ(plan.dt, remaining);
    EXPECT_TRUE(plan.lands);
    EXPECT_TRUE(plan.full);
  }
  EXPECT_FALSE(plan_step(settings, dx, motion, 0.0, 1.5e-3, state).lands);
  EXPECT_DOUBLE_EQ(plan_step(settings, dx, motion, 0.0, 1.5e-3, state).dt, 0.75e-3);
  EXPECT_DOUBLE_EQ(plan_step(settings, dx, motion, 0.0, 2e-3, state).dt, 1e-3);
}

// Without an accepted trial the step never grows; a trial that cannot be made in full is put off.
TEST(TimeStep, ATrialThatAnOutputWouldClipIsPutOff) {
  TimeStepSettings settings;
  settings.dt_initial = 1e-3;
  settings.trial_interval = 1;
  TimeStepState state;
  const StepBounds motion = moving(1.0, 0.0, 0.0);
  take_step(settings, motion, motion, is_full, state);
  for (const double remaining : {1.2e-3, 1.4e-3, 2.2e-3, 2.9e-3}) {
    const TimeStepPlan plan = plan_step(settings, dx, motion, 0.0, remaining, state);
    EXPECT_FALSE(plan.trial);
    EXPECT_LE(plan.dt, 1e-3);
  }
  for (const double remaining : {1.5e-3, 3.1e-3, 1.0}) {
    const TimeStepPlan plan = plan_step(settings, dx, motion, 0.0, remaining, state);
    EXPECT_TRUE(plan.trial);
    EXPECT_TRUE(plan.checked);
    EXPECT_DOUBLE_EQ(plan.dt, 1.5e-3);
  }
}

// --- the fixed step --------------------------------------------------------------------------------------------------

TEST(TimeStep, AFixedStepAboveTheLimitsIsRefused) {
  TimeStepSettings settings;
  settings.mode = TimeStepMode::fixed;
  settings.dt_fixed = 1e-3;
  TimeStepState state;
  const std::string refusal =
      "the fixed time step of 0.001 s is above the elastic limit of 0.0004 s (particle 22); choose a smaller time.dt, "
      "mode = \"adaptive\", or allow_unstable = true";
  EXPECT_EQ(message_of([&] { plan_step(settings, dx, moving(1.0, 100.0, 0.0), 0.0, is_full, state); }), refusal);
  // Also when the deformation, which alone would be allowed, limits even more.
  EXPECT_EQ(message_of([&] { plan_step(settings, dx, moving(1.0, 100.0, 1e4), 0.0, is_full, state); }), refusal);
  EXPECT_EQ(plan_step(settings, dx, moving(1.0, 10.0, 1e4), 0.0, is_full, state).dt, 1e-3);
  settings.allow_unstable = true;
  EXPECT_EQ(plan_step(settings, dx, moving(1.0, 100.0, 0.0), 0.0, is_full, state).dt, 1e-3);
}

// Viscosity is a matter of stability, too.
TEST(TimeStep, AFixedStepAboveTheViscousLimitIsRefused) {
  TimeStepSettings settings;
  settings.mode = TimeStepMode::fixed;
  settings.dt_fixed = 1e-3;
  settings.viscous_cfl = 0.3;
  TimeStepState state;
  EXPECT_EQ(message_of([&] { plan_step(settings, dx, viscous(moving(1.0, 1.0, 0.0), 1.0), 0.0, is_full, state); }),
            "the fixed time step of 0.001 s is above the viscous limit of 0.0005 s (particle 44); choose a smaller time.dt, "
            "mode = \"adaptive\", or allow_unstable = true");
  EXPECT_EQ(plan_step(settings, dx, viscous(moving(1.0, 1.0, 0.0), 0.4), 0.0, is_full, state).dt, 1e-3);
}

TEST(TimeStep, TheViscousLimitIsNamed) { EXPECT_STREQ(name(Limiter::viscous), "viscous"); }

TEST(TimeStep, AFixedStepStaysButForOutputs) {
  TimeStepSettings settings;
  settings.mode = TimeStepMode::fixed;
  settings.dt_fixed = 1e-3;
  TimeStepState state;
  const StepBounds motion = moving(1.0, 1.0, 1.0);
  for (int step = 0; step < 30; ++step) {
    const TimeStepPlan plan = take_step(settings, motion, motion, is_full, state);
    EXPECT_EQ(plan.dt, 1e-3);
    EXPECT_EQ(plan.limiter, Limiter::fixed);
    EXPECT_FALSE(plan.trial);
  }
  const TimeStepPlan last = take_step(settings, motion, motion, 0.3e-3, state);
  EXPECT_EQ(last.dt, 0.3e-3);
  EXPECT_EQ(last.unclipped, 1e-3);
  EXPECT_TRUE(last.lands);
  EXPECT_EQ(take_step(settings, motion, motion, is_full, state).dt, 1e-3);
}

}  // namespace
}  // namespace bulkley::time_step_test
