#pragma once
// The scene's acceleration_field as a force on nodes.

#include "integrator/node_force.hpp"

namespace bulkley {

/// f_i = m_i a(x_i, t), with a as the formula gives it at the start of the step. Every node has one owner, who evaluates it.
class AccelerationForce : public NodeForce {
 public:
  AccelerationForce(const GridGeometry& grid, const VectorFormula& formula) : grid_(grid), field_(formula) {}
  const char* name() const override { return "acceleration_field"; }
  void add(const ForcedNodes& nodes, FailureCounts& failures) override;

 private:
  GridGeometry grid_;
  VectorField field_;
};

}  // namespace bulkley
