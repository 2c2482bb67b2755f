#pragma once
// One time step, whatever the scheme.

#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "integrator/step_parts.hpp"

namespace bulkley {

/// What the caller wants of a step.
struct StepRequest {
  double time;                      ///< at the start of the step, s
  double remaining;                 ///< the step is no longer than that, s; > 0
  std::int32_t from_rank = 0;       ///< merged over ranks (largest), it comes back as StepReport::bounds.requests.caller
  std::optional<double> landing{};  ///< s, the time of a step that takes all that remains, where the sum rounds to another
};

/// How the implicit pressure of a step was found.
struct PressureReport {
  int n_iterations = 0;  ///< of conjugate gradients, over all rounds
  int n_rounds = 0;      ///< solutions until walls and free surfaces kept their state
  bool solved = true;    ///< false: the tolerance was not reached, or a number is not finite
  std::string fault;     ///< then: "the pressure is not found ...", where the solver says why
};

/// How the viscous motion of a step was found.
struct ViscosityReport {
  int n_iterations = 0;  ///< of conjugate gradients
  bool solved = true;    ///< as PressureReport
};

/// How a step went; the same on every rank.
struct StepReport {
  TimeStepPlan plan;          ///< the plan that was carried out
  int n_rejected = 0;         ///< plans that were judged bad before it
  PressureReport pressure;    ///< of an implicit pressure
  ViscosityReport viscosity;  ///< of implicit viscosity
  StepBounds bounds;          ///< merged over ranks, after the step
};

class Integrator {
 public:
  virtual ~Integrator() = default;

  /// Takes one step: dt from `state` and the limits, then particles -> nodes -> particles, ended by
  /// ParticleGrid::finish_move. Where the report's bounds have failed(), the run cannot continue. Throws NoStep when no step
  /// can be taken, alike on every rank. Collective.
  virtual StepReport step(const StepRequest& request, TimeStepState& state) = 0;

  /// Makes its arrays those of the present pools; `step` does so by itself. Not collective.
  virtual void fit() = 0;

  /// What limits dt in a step from `time`, s, of at most `remaining`, s, with the particles as `bounds` has them. Not
  /// collective (the same on every rank).
  virtual TimeStepLimit dt_limit(const StepBounds& bounds, double time, double remaining) const = 0;

  /// Whether particles are the same bits on any number of ranks, or only the same to the tolerance of a solver.
  virtual bool is_exact() const = 0;

  /// {v, m} of the owned nodes that the particles as they are give at `time`, s, contact applied. Valid until the next step.
  /// Changes no particle. Collective.
  virtual std::span<const Node> node_velocities(double time) = 0;

  /// Fields of nodes that go through the exchange in a step. Not collective.
  virtual int n_exchanges() const = 0;
  /// Bytes that this rank sends in an iteration of a linear system. Not collective.
  virtual std::size_t bytes_per_iteration() const { return 0; }
  /// Bytes of its arrays on this rank. Not collective.
  virtual std::size_t memory() const = 0;
};

/// Makes an integrator that works with the parts, which outlive it.
using MakeIntegrator = std::function<std::unique_ptr<Integrator>(StepParts&)>;

}  // namespace bulkley
