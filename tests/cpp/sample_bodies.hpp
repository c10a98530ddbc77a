// Bodies whose mass properties are known in closed form.
#pragma once

#include <cmath>
#include <numbers>

#include "ifa/base/random.hpp"
#include "ifa/rigid/event_engine.hpp"

namespace ifa::sample {

inline constexpr double kGravity = 9.81;

inline Body box(const Vec3& size_m, double mass_kg, const Material& material = {}) {
  Body::Definition d;
  for (int i = 0; i < 8; ++i)
    d.vertices_m.push_back(0.5 * size_m.cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  const Vec3 squares = size_m.cwiseAbs2();
  d.inertia_kg_m2 = (mass_kg / 12.0 * (Vec3::Constant(squares.sum()) - squares)).asDiagonal();
  d.mass_kg = mass_kg;
  d.material = material;
  return Body::make(d);
}

// Solid.
inline Body ball(double radius_m, double mass_kg, const Material& material = {}) {
  Body::Definition d;
  d.vertices_m = {Vec3::Zero()};
  d.radius_m = radius_m;
  d.inertia_kg_m2 = 0.4 * mass_kg * radius_m * radius_m * Mat3::Identity();
  d.mass_kg = mass_kg;
  d.material = material;
  return Body::make(d);
}

// A thin rod along x.
inline Body rod(double length_m, double radius_m, double mass_kg, const Material& material = {}) {
  Body::Definition d;
  d.vertices_m = {Vec3(-0.5 * length_m, 0, 0), Vec3(0.5 * length_m, 0, 0)};
  d.radius_m = radius_m;
  const double across = mass_kg * length_m * length_m / 12.0;
  d.inertia_kg_m2 = Vec3(1e-3 * across, across, across).asDiagonal();
  d.mass_kg = mass_kg;
  d.material = material;
  return Body::make(d);
}

// Two rings, rounded, as a coin: 25.75 x 2.2 mm, its moments those of the cylinder.
inline Body coin(const Material& material = {}) {
  constexpr double kRounding = 0.2e-3, kRim = 12.875e-3 - kRounding, kHalf = 1.1e-3 - kRounding;
  Body::Definition d;
  d.rings_m = {{{0, 0, kHalf}, kUp, kRim}, {{0, 0, -kHalf}, kUp, kRim}};
  d.radius_m = kRounding;
  d.mass_kg = 8.5e-3;
  const double r2 = 12.875e-3 * 12.875e-3, across = d.mass_kg * (3.0 * r2 + 2.2e-3 * 2.2e-3) / 12.0;
  d.inertia_kg_m2 = Vec3(across, across, 0.5 * d.mass_kg * r2).asDiagonal();
  d.material = material;
  return Body::make(d);
}

// For conservation laws: no rolling nor spin friction.
inline Material ideal(double restitution, double friction) { return {restitution, friction, 0.0, 0.0}; }

inline Vec3 downwards() { return {0.0, 0.0, -kGravity}; }

// World axes, straight from the definition L = R I R^T omega.
inline Vec3 angular_momentum(const Body& body, const State& s) {
  const Mat3 r = s.orientation.toRotationMatrix();
  return r * body.principal_inertia().asDiagonal() * r.transpose() * s.angular_velocity;
}

// Likewise the energies, apart from the library's own.
inline double kinetic(const Body& body, const State& s) {
  return 0.5 *
         (body.mass_kg() * s.velocity.squaredNorm() + s.angular_velocity.dot(angular_momentum(body, s)));
}

inline double mechanical(const Body& body, const State& s) {
  return kinetic(body, s) + body.mass_kg() * kGravity * s.position.z();
}

// Height of the lowest point of the rounded hull.
inline double lowest(const Body& body, const State& s) {
  const Mat3 r = s.orientation.toRotationMatrix();
  double least = 1e300;
  for (const Vec3& p : body.principal_vertices()) least = std::min(least, (r * p).z());
  for (const Ring& ring : body.principal_rings()) {
    const double steep = (r * ring.axis).head<2>().norm();
    least = std::min(least, (r * ring.centre_m).z() - ring.radius_m * steep);
  }
  return least + s.position.z() - body.radius_m();
}

// Angle between two orientations, rad; good for small ones (no arc cosine).
inline double angle_between(const Quat& a, const Quat& b) { return 2.0 * (a.conjugate() * b).vec().norm(); }

// At `clearance_m` above the ground, any orientation.
inline State random_state(const Body& body, RandomStream& random, double clearance_m, double speed_m_s,
                          double spin_rad_s) {
  State s;
  s.orientation = random.rotation();
  s.position.z() = clearance_m - lowest(body, s);
  s.velocity = speed_m_s * random.uniform() * random.unit_vector();
  s.angular_velocity = spin_rad_s * random.uniform() * random.unit_vector();
  return s;
}

}  // namespace ifa::sample
