#include "ifa/rigid/ode_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace ifa {

double OdeBody::kinetic_energy(const Vec3& velocity, const Vec3& angular_velocity,
                               const Quat& orientation) const {
  const Vec3 spin = orientation.conjugate() * angular_velocity;
  return 0.5 * (mass * velocity.squaredNorm() + inertia.dot(spin.cwiseProduct(spin)));
}

double OdeBody::mobility(const Vec3& arm, const Vec3& direction, const Quat& orientation) const {
  const Vec3 lever = orientation.conjugate() * arm.cross(direction);
  return 1.0 / mass + lever.cwiseProduct(lever).dot(inertia.cwiseInverse());
}

void OdeContacts::find(const State& state, double margin, double length) {
  touching_.clear();
  arms_.clear();
  if (state.position.z() - body_->reach > margin) return;
  const Quat inverse = state.orientation.conjugate();
  const Vec3 up = inverse * kUp, up_rate = up.cross(inverse * state.angular_velocity);
  const double z = state.position.z() - body_->radius;
  points_.resize(body_->vertices.size());
  for (const Ring& ring : body_->rings) {
    const Vec3 tilt = ring.axis.dot(up) * ring.axis - up;
    const Vec3 lowest = tilt.norm() > 1e-9 ? tilt.normalized() : ring.axis.unitOrthogonal();
    constexpr int kAround = 8;
    for (int k = 0; k < kAround; ++k)
      points_.push_back(ring.centre_m +
                        ring.radius_m *
                            (Eigen::AngleAxisd(2.0 * std::numbers::pi * k / kAround, ring.axis) * lowest));
  }
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const double gap = z + up.dot(points_[i]);
    if (gap > margin) continue;
    const double rate = state.velocity.z() + up_rate.dot(points_[i]);
    if (gap + length * rate <= margin) touching_.push_back(static_cast<int>(i));
  }
  const auto arm_of = [&](int i) { return Vec3(state.orientation * points_[i] - body_->radius * kUp); };

  // Points in the span of others add only redundant rows: keep those furthest out and down in eight
  // directions, and the one that approaches fastest.
  constexpr std::size_t kFew = 4, kDirections = 8;
  if (touching_.size() > kFew) {
    std::array<int, kDirections + 1> chosen{};
    std::array<double, kDirections + 1> best;
    best.fill(-std::numeric_limits<double>::infinity());
    for (const int i : touching_) {
      const Vec3 arm = arm_of(i);
      const double d = std::numbers::sqrt2 / 2.0, x = arm.x(), y = arm.y(), down = -arm.z();
      const double sinking = -state.angular_velocity.cross(arm).z();
      const std::array<double, kDirections + 1> far = {
          x + down,  d * (x + y) + down, y + down, d * (y - x) + down, -x + down, -d * (x + y) + down,
          -y + down, d * (x - y) + down, sinking};
      for (std::size_t k = 0; k < far.size(); ++k)
        if (far[k] > best[k]) best[k] = far[k], chosen[k] = i;
    }
    std::sort(chosen.begin(), chosen.end());
    touching_.assign(chosen.begin(), std::unique(chosen.begin(), chosen.end()));
  }
  for (const int i : touching_) arms_.push_back(arm_of(i));
}

bool OdeContacts::stable() const { return arms_.size() >= 3 || points_.size() == 1; }

// Seen from above, the points leave no gap of more than half a turn around the centre.
bool OdeContacts::supported() const {
  std::vector<double> angles;
  for (const Vec3& arm : arms_) {
    if (arm.head<2>().norm() <= 1e-3 * body_->reach) return true;
    angles.push_back(std::atan2(arm.y(), arm.x()));
  }
  if (angles.size() < 2) return false;
  std::sort(angles.begin(), angles.end());
  double gap = angles.front() + 2.0 * std::numbers::pi - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  return gap <= std::numbers::pi + 1e-3;
}

double OdeContacts::approach_speed(const State& state) const {
  double fastest = 0.0;
  for (const Vec3& arm : arms_)
    fastest = std::max(fastest, -(state.velocity + state.angular_velocity.cross(arm)).z());
  return fastest;
}

double OdeContacts::depth(const State& state) const {
  double deepest = 0.0;
  for (const Vec3& arm : arms_) deepest = std::max(deepest, -(state.position + arm).z());
  return deepest;
}

const std::vector<OdeContact>& OdeContacts::make(const State& state, double length, const Vec3& gravity,
                                                 double softness, bool impact) {
  contacts_.clear();
  const double weight = body_->mass * std::max(0.0, -gravity.z());
  for (const Vec3& arm : arms_) {
    OdeContact c;
    c.position = state.position + arm;
    c.depth = -c.position.z();
    // ODE's friction is a box about two axes. The first is the slip that would be without friction, so that
    // no heading is special. What slides on has no second one, which would hold it against every sideways
    // pull; in an impact, which turns the slip, both together come nearer to the cone.
    const Vec3 velocity = state.velocity + state.angular_velocity.cross(arm) + length * gravity;
    const Vec3 slip(velocity.x(), velocity.y(), 0.0);
    const double slip_speed = slip.norm();
    if (slip_speed > 0.0) c.slip_direction = slip / slip_speed;
    const auto mobility = [&](const Vec3& direction) {
      return body_->mobility(arm, direction, state.orientation);
    };
    const double along = mobility(c.slip_direction);
    c.friction = body_->friction;
    c.cross_friction =
        !impact && slip_speed > body_->friction * weight * length * along ? 0.0 : body_->friction;
    c.softness = {softness * length * mobility(kUp), softness * length * along,
                  softness * length * mobility(kUp.cross(c.slip_direction))};
    c.restitution = impact ? body_->restitution : 0.0;
    contacts_.push_back(c);
  }
  return contacts_;
}

// ODE's rows for these, three to a contact, are redundant and make its LCP solver fail. A torque is at most
// what ends the turning of the free body: the contacts only make it harder to turn.
Vec3 OdeContacts::friction_torque(const State& state, double length, const Vec3& gravity) const {
  const double weight = body_->mass * std::max(0.0, -gravity.z());
  const auto resist = [&](const Vec3& part, double lever) -> Vec3 {
    const double speed = part.norm();
    if (speed == 0.0 || lever == 0.0) return Vec3::Zero();
    const Vec3 axis = state.orientation.conjugate() * part / speed;
    const double stopping = speed / length / axis.cwiseProduct(axis).dot(body_->inertia.cwiseInverse());
    return part / speed * -std::min(lever * weight, stopping);
  };
  const Vec3& spin = state.angular_velocity;
  return resist({spin.x(), spin.y(), 0.0}, body_->rolling_friction) +
         resist({0.0, 0.0, spin.z()}, body_->spin_friction);
}

}  // namespace ifa
