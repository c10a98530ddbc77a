// Contacts of a body with the ground for the engine on ODE, straight from its hull vertices.
#pragma once

#include <vector>

#include "ifa/rigid/ode_world.hpp"

namespace ifa {

// A body in the units of its OdeWorld, in principal axes.
struct OdeBody {
  double mass, radius, reach;  // reach: of the ball about the centre of mass
  Vec3 inertia;
  std::vector<Vec3> vertices;
  std::vector<Ring> rings;
  double restitution, friction, rolling_friction, spin_friction;  // the last two are lengths

  double kinetic_energy(const Vec3& velocity, const Vec3& angular_velocity, const Quat& orientation) const;
  // J M^-1 J^T of a force along `direction` at `arm`.
  double mobility(const Vec3& arm, const Vec3& direction, const Quat& orientation) const;
};

class OdeContacts {
 public:
  explicit OdeContacts(const OdeBody& body) : body_(&body), points_(body.vertices) {}

  // The vertices, and of each ring the lowest point and seven around it, within `margin` of the ground or
  // below it, however far: a thin plate has no side to fall out of. Not those that leave it within a step of
  // `length`. Of many, as few as span the others.
  void find(const State& state, double margin, double length);

  bool empty() const { return arms_.empty(); }
  const std::vector<Vec3>& arms() const { return arms_; }  // from the centre of mass, world axes
  bool stable() const;     // three points, or the one of a ball: nothing to tip over
  bool supported() const;  // the centre of mass is above the points
  double approach_speed(const State& state) const;
  double depth(const State& state) const;

  // `softness` is relative to each row's own mobility. In an `impact` the points bounce.
  const std::vector<OdeContact>& make(const State& state, double length, const Vec3& gravity, double softness,
                                      bool impact);

  // Rolling and spinning friction under the body's weight, as a torque.
  Vec3 friction_torque(const State& state, double length, const Vec3& gravity) const;

 private:
  const OdeBody* body_;
  std::vector<Vec3> points_;  // that may touch, principal axes
  std::vector<int> touching_;
  std::vector<Vec3> arms_;
  std::vector<OdeContact> contacts_;
};

}  // namespace ifa
