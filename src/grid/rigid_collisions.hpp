#pragma once
// Collisions of free rigid bodies with walls, colliders and each other (docs/theory.md, "Collisions").
//
// Points of one surface against the signed distance to the other, at most eight a pair; normal impulses with restitution and
// Coulomb friction by projected Gauss-Seidel in a fixed order. Every rank works all of it out from the same states: the same bits,
// no messages.

#include <optional>
#include <vector>

#include "grid/rigid_body.hpp"

namespace bulkley {

/// What collisions have done to a body in a step.
struct CollisionEffect {
  Vec3 impulse = Vec3::Zero();  ///< N s
  double work = 0.0;            ///< J, the change of its kinetic energy
};

class RigidCollisions {
 public:
  /// `bodies`: with the shapes that are asked for distances. All must outlive this.
  RigidCollisions(const GridGeometry& grid, const Faces& faces, const std::vector<Collider>& colliders,
                  const std::vector<RigidBody>& bodies, const std::vector<RigidStart>& starts)
      : grid_(grid), faces_(faces), colliders_(colliders), bodies_(bodies), starts_(starts) {}

  /// Changes the momenta of bodies that touch something in the step of `dt` from `time`, s. `before`: at its start; `states`: there
  /// still, with the momenta that they would have at its end. Not collective (the same on every rank), as all here.
  std::vector<CollisionEffect> collide(double time, double dt, const std::vector<RigidState>& before,
                                       std::vector<RigidState>& states);
  /// After the bodies have moved: pushes out what the last `collide` found too deep, with unchanged momenta. `effects` gets the work, for
  /// a body that is turned has another energy with the same angular momentum.
  void push_out(double dt, std::vector<RigidState>& states, std::vector<CollisionEffect>& effects) const;

 private:
  struct Touch {
    std::size_t body;
    std::optional<std::size_t> other;  ///< body; none: wall or collider
    Vec3 arm, other_arm;               ///< m, from the centres of mass
    Vec3 normal;                       ///< unit, into `body`
    double depth;                      ///< m
    Vec3 velocity;                     ///< m/s, of a wall or collider there
  };
  /// How a body moves, and what an impulse changes in that.
  struct Mover {
    Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
    double inverse_mass = 0.0;
    Mat3 inverse_inertia = Mat3::Zero();
    std::optional<RigidVelocity> freedom;  ///< of a guided body, at the rate 1 ...
    double rate = 0.0;                     ///< ... at which it runs ...
    double inverse_of_freedom = 0.0;       ///< ... and one over its inertia

    Vec3 at(const Vec3& arm) const { return velocity + spin.cross(arm); }
    void push(const Vec3& arm, const Vec3& impulse);
    Mat3 response(const Vec3& arm) const;  ///< of the velocity at `arm` to an impulse there
  };

  std::vector<Mover> movers(const std::vector<RigidState>& states) const;
  Vec3 approach(const Touch& touch, const std::vector<Mover>& movers) const;
  void find_touches(double time, double dt, const std::vector<RigidState>& states);
  void add_pair(std::vector<Touch>& found);
  /// Impulses that make normal velocities at least `wanted`; without walls' velocities and friction where `is_push`.
  std::vector<Vec3> solve(const std::vector<double>& wanted, bool is_push, std::vector<Mover>& movers) const;

  const GridGeometry& grid_;
  const Faces& faces_;
  const std::vector<Collider>& colliders_;
  const std::vector<RigidBody>& bodies_;
  const std::vector<RigidStart>& starts_;
  std::vector<Touch> touches_;
};

}  // namespace bulkley
