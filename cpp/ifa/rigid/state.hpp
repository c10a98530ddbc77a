// The state of a rigid body, psi = (x, q, v, omega), and its change of axes.
#pragma once

#include <algorithm>
#include <limits>

#include "ifa/base/linear_algebra.hpp"
#include "ifa/rigid/body.hpp"

namespace ifa {

// World axes throughout. `orientation` maps body axes to world axes at the boundary and principal axes
// to world axes inside the engines; `to_principal` and `to_body` convert.
struct State {
  Vec3 position = Vec3::Zero();  // of the centre of mass, m
  Quat orientation = Quat::Identity();
  Vec3 velocity = Vec3::Zero();          // of the centre of mass, m/s
  Vec3 angular_velocity = Vec3::Zero();  // rad/s, world axes
};

inline State to_principal(const Body& body, State s) {
  s.orientation = s.orientation * body.body_from_principal();
  return s;
}

inline State to_body(const Body& body, State s) {
  s.orientation = s.orientation * body.body_from_principal().conjugate();
  return s;
}

inline bool is_finite(const State& s) {
  return s.position.allFinite() && s.orientation.coeffs().allFinite() && s.velocity.allFinite() &&
         s.angular_velocity.allFinite();
}

// The signed gap between the ground and the lowest point of the rounded hull; principal axes.
inline double lowest_gap_m(const Body& body, const State& s) {
  const Vec3 up = s.orientation.conjugate() * kUp;
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vec3& p : body.principal_vertices()) lowest = std::min(lowest, up.dot(p));
  for (const Ring& ring : body.principal_rings()) lowest = std::min(lowest, -reach_m(ring, -up));
  return s.position.z() + (lowest - body.radius_m());
}

}  // namespace ifa
