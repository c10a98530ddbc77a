#include "ifa/signature/placement.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/base/counted.hpp"

namespace ifa {

Vec3 Placement::turned(const Vec3& v) const {
  const Vec2 flat = turned(Vec2(v.head<2>()));
  return {flat.x(), flat.y(), v.z()};
}

Vec3 Placement::placed(const Vec3& position_m) const {
  const Vec2 flat = placed(Vec2(position_m.head<2>()));
  return {flat.x(), flat.y(), position_m.z()};
}

State Placement::placed(const State& state) const {
  const double half = 0.5 * std::atan2(sine, cosine);
  State s;
  s.position = placed(state.position);
  s.orientation = Quat(std::cos(half), 0.0, 0.0, std::sin(half)) * state.orientation;
  s.velocity = turned(state.velocity);
  s.angular_velocity = turned(state.angular_velocity);
  return s;
}

void Alignment::add_position(const Vec2& own, const Vec2& wanted, double weight) {
  count_run(Effect::position_constraints);
  const Vec2 a = own - mean_own_, b = wanted - mean_wanted_;
  const double share = weight / (weight_ + weight), moved = weight_ * share;
  squares_ += moved * (a.squaredNorm() + b.squaredNorm());
  dot_ += moved * a.dot(b);
  cross_ += moved * (a.x() * b.y() - a.y() * b.x());
  mean_own_ += share * a;
  mean_wanted_ += share * b;
  weight_ += weight;
}

void Alignment::add_direction(const Vec3& own, const Vec3& wanted, double weight) {
  count_run(Effect::orientation_constraints);
  const Vec2 a = own.head<2>(), b = wanted.head<2>();
  const double up = own.z() - wanted.z();
  squares_ += weight * (a.squaredNorm() + b.squaredNorm() + up * up);
  dot_ += weight * a.dot(b);
  cross_ += weight * (a.x() * b.y() - a.y() * b.x());
}

void Alignment::add(const Constraints& asked, std::size_t mark, const Body& body, const State& pose) {
  for (const PositionConstraint& c : asked.positions)
    if (c.mark == mark) add_position(pose.position.head<2>(), c.position_m);
  for (const OrientationConstraint& c : asked.orientations)
    if (c.mark == mark)
      add_direction(seen(body, pose, c.body_direction).stableNormalized(), c.direction.stableNormalized());
}

Placement Alignment::best() const {
  Placement p;
  const double size = std::hypot(dot_, cross_);
  if (size > 0.0) {
    p.cosine = dot_ / size;
    p.sine = cross_ / size;
  }
  p.shift_m = mean_wanted_ - p.turned(mean_own_);
  return p;
}

double Alignment::cost() const { return std::max(0.0, squares_ - 2.0 * std::hypot(dot_, cross_)); }

Vec3 seen(const Body& body, const State& pose, const Vec3& body_direction) {
  return pose.orientation * (body.body_from_principal().conjugate() * body_direction);
}

}  // namespace ifa
