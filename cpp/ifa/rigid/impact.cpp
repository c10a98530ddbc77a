#include <algorithm>
#include <cmath>

#include "ifa/rigid/event_engine.hpp"

namespace ifa {

Mat3 inverse_inertia_world(const Body& body, const Quat& orientation) {
  const Vec3& inertia = body.principal_inertia();
  if (body.isotropic()) return Mat3::Identity() / inertia.x();
  const Mat3 r = orientation.toRotationMatrix();
  return r * inertia.cwiseInverse().asDiagonal() * r.transpose();
}

double kinetic_energy(const Body& body, const State& state) {
  const Vec3 spin = state.orientation.conjugate() * state.angular_velocity;
  return 0.5 * (body.mass_kg() * state.velocity.squaredNorm() +
                body.principal_inertia().dot(spin.cwiseProduct(spin)));
}

ImpactResult resolve_impact(const Body& body, double micro_speed, ContactSolver& solver,
                            std::vector<ContactPoint>& points, State& state) {
  const Material& material = body.material();
  const ContactBody problem{body.mass_kg(), inverse_inertia_world(body, state.orientation),
                            material.friction};
  double scale = 0.0;
  bool bounces = false;
  for (ContactPoint& p : points) {
    const Vec3 v = state.velocity + state.angular_velocity.cross(p.arm);
    p.target_speed = v.z() < -micro_speed ? -material.restitution * v.z() : 0.0;
    bounces |= p.target_speed > 0.0;
    scale = std::max(scale, v.norm());
  }
  const double tolerance = 1e-12 * scale;
  constexpr int kMaxSweeps = 200;

  State after = state;
  solver.solve(problem, points, after.velocity, after.angular_velocity, tolerance, kMaxSweeps);
  const double energy_before = kinetic_energy(body, state);
  if (bounces && kinetic_energy(body, after) > energy_before) {
    // Coulomb's law with e = 0 cannot raise the energy; along the blend the energy is a parabola in `share`.
    std::vector<Vec3> elastic;
    for (ContactPoint& p : points) {
      elastic.push_back(p.impulse);
      p.target_speed = 0.0;
    }
    State plastic = state;
    solver.solve(problem, points, plastic.velocity, plastic.angular_velocity, tolerance, kMaxSweeps);
    const Vec3 dv = after.velocity - plastic.velocity;
    const Vec3 dw = after.angular_velocity - plastic.angular_velocity;
    const Quat inverse = state.orientation.conjugate();
    const Vec3 w0 = inverse * plastic.angular_velocity, w1 = inverse * dw;
    const Vec3& inertia = body.principal_inertia();
    const double a = 0.5 * (body.mass_kg() * dv.squaredNorm() + inertia.dot(w1.cwiseProduct(w1)));
    const double b = body.mass_kg() * dv.dot(plastic.velocity) + inertia.dot(w1.cwiseProduct(w0));
    const double c = kinetic_energy(body, plastic) - energy_before;  // <= 0
    const double root = std::sqrt(std::max(0.0, b * b - 4.0 * a * std::min(c, 0.0)));
    double share = a > 0.0 ? (b > 0.0 ? -2.0 * std::min(c, 0.0) / (b + root) : (root - b) / (2.0 * a)) : 0.0;
    share = std::clamp(share * (1.0 - 1e-15), 0.0, 1.0);
    after.velocity = plastic.velocity + share * dv;
    after.angular_velocity = plastic.angular_velocity + share * dw;
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i].impulse += share * (elastic[i] - points[i].impulse);
  }

  ImpactResult result;
  double normal = 0.0;
  for (const ContactPoint& p : points) {
    result.impulse_n_s += p.impulse;
    result.position_m += p.impulse.z() * (state.position + p.arm);
    normal += p.impulse.z();
  }
  if (normal > 0.0)
    result.position_m /= normal;
  else if (!points.empty())
    result.position_m = state.position + points.front().arm;
  state = after;
  return result;
}

}  // namespace ifa
