#include "ifa/rigid/contact.hpp"

#include <vector>

#include "ifa/rigid/event_engine.hpp"
#include "ifa/rigid/lanes/scalar.hpp"
#include "ifa/rigid/views.hpp"

namespace ifa {
namespace {

namespace one = lanes_scalar;

std::vector<one::ContactSlot> slots_of(const std::vector<ContactPoint>& points) {
  std::vector<one::ContactSlot> slots(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    slots[i].valid = true;
    slots[i].arm = one::pack(points[i].arm);
    slots[i].target = points[i].target_speed;
    slots[i].impulse = one::pack(points[i].impulse);
  }
  return slots;
}

}  // namespace

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

void solve_contacts(const ContactBody& body, std::vector<ContactPoint>& points, Vec3& velocity,
                    Vec3& angular_velocity, double tolerance, int max_sweeps) {
  const Mat3& w = body.inverse_inertia;
  const one::ContactBodies problem{
      1.0 / body.mass_kg,   {w(0, 0), w(0, 1), w(0, 2), w(1, 1), w(1, 2), w(2, 2)},
      body.friction,        body.rolling_friction_m,
      body.spin_friction_m, body.friction > 0.0};
  std::vector<one::ContactSlot> slots = slots_of(points);
  one::Pack3 v = one::pack(velocity), spin = one::pack(angular_velocity), torque{0.0, 0.0, 0.0};
  one::solve_contacts(problem, slots.data(), static_cast<int>(slots.size()), true, tolerance, max_sweeps, v,
                      spin, torque);
  velocity = one::unpack(v);
  angular_velocity = one::unpack(spin);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].impulse = one::unpack(slots[i].impulse);
}

ImpactResult resolve_impact(const Body& body, double micro_speed, std::vector<ContactPoint>& points,
                            State& state) {
  const lanes::BodyView view = view_of(body);
  one::Motion m = one::pack(state);
  std::vector<one::ContactSlot> slots = slots_of(points);
  const one::ImpactOutcome outcome = one::resolve_impact(
      view, micro_speed, slots.data(), static_cast<int>(slots.size()), true, one::rotation(m.orientation), m);
  state.velocity = one::unpack(m.velocity);
  state.angular_velocity = one::unpack(m.spin);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].impulse = one::unpack(slots[i].impulse);
    points[i].target_speed = slots[i].target;
  }
  return {one::unpack(outcome.impulse), one::unpack(outcome.position)};
}

}  // namespace ifa
