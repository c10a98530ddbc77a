#include "ifa/verify/track.hpp"

#include <algorithm>
#include <cmath>

namespace ifa::verify {
namespace {

constexpr double kTurnPerStep = 0.05;  // rad: a Runge-Kutta step is then good to 1e-8 of its turn
constexpr int kMaxSteps = 64;
// Above the contact error of honest exporters: 1e-7 m through single precision; and in sustained contact an
// interpolated rotation of up to 0.05 rad a step cuts the arc by 0.05^2 / 8 of the radius. Below any hop that
// an audible hit leads to (0.1 mm).
constexpr double kTouch = 5e-6;
constexpr double kTouchShare = 4e-4;

constexpr double kTwoPi = 6.283185307179586;

Vec3 rotation_log(const Quat& q) {
  const double sine = q.vec().norm();
  if (sine < 1e-12) return (q.w() < 0.0 ? -2.0 : 2.0) * q.vec();
  const double angle = 2.0 * std::atan2(q.w() < 0.0 ? -sine : sine, std::abs(q.w()));
  return (angle / sine) * q.vec();
}

}  // namespace

Track::Track(const Poses& poses, const Body& body, double gravity_m_s2)
    : poses_(&poses),
      body_(&body),
      gravity_(0.0, 0.0, -gravity_m_s2),
      touch_m_(std::max(kTouch, kTouchShare * body.bounding_radius_m())),
      inverse_inertia_(body.inertia_kg_m2().inverse()) {
  const int n = size();
  const auto& vertices = body.vertices();
  const auto& rings = body.rings();
  const Eigen::Index n_vertices = static_cast<Eigen::Index>(vertices.size());
  Eigen::MatrixXd points(n_vertices, 3), up(3, n);
  for (Eigen::Index k = 0; k < n_vertices; ++k) points.row(k) = vertices[k];
  fixed_points_ = vertices;
  for (const Ring& ring : rings) {
    const Vec3 side = ring.axis.unitOrthogonal();
    for (int k = 0; k < kAround; ++k)
      fixed_points_.push_back(ring.centre_m +
                              ring.radius_m * (Eigen::AngleAxisd(k * kTwoPi / kAround, ring.axis) * side));
  }
  Eigen::RowVectorXd base(n);
  for (int i = 0; i < n; ++i) {
    up.col(i) = orientation(i).conjugate() * kUp;
    base(i) = position(i).z() - body.radius_m();
  }
  heights_.resize(n_vertices + static_cast<Eigen::Index>(rings.size()) * kAround, n);
  heights_.topRows(n_vertices).noalias() = points * up;
  for (std::size_t j = 0; j < rings.size(); ++j) {
    const Ring& ring = rings[j];
    for (int i = 0; i < n; ++i) {
      // a rim leans against the ground by the angle between its axis and the vertical
      const double steepness = ring.axis.cross(Vec3(up.col(i))).norm();
      for (int k = 0; k < kAround; ++k)
        heights_(n_vertices + static_cast<Eigen::Index>(j) * kAround + k, i) =
            ring.centre_m.dot(up.col(i)) - ring.radius_m * steepness * std::cos(k * kTwoPi / kAround);
    }
  }
  heights_.rowwise() += base;
  lowest_.resize(n);
  for (int i = 0; i < n; ++i) lowest_[i] = heights_.col(i).minCoeff();
  turns_.resize(n - 1);
  momenta_.resize(n - 1);
  for (int j = 0; j + 1 < n; ++j)
    momenta_[j] = momentum_between(orientation(j), orientation(j + 1), step(j), &turns_[j]);
}

double Track::speed_bound(int j) const {
  return ((position(j + 1) - position(j)).norm() + turns_[j] * body_->bounding_radius_m()) / step(j);
}

Vec3 Track::angular_velocity(const Quat& q, const Vec3& momentum) const {
  return q * (inverse_inertia_ * (q.conjugate() * momentum));
}

Quat Track::rotate(const Quat& start, const Vec3& momentum, double time_s) const {
  const auto rate = [&](const Quat& q) {
    const Vec3 w = 0.5 * (inverse_inertia_ * (q.conjugate() * momentum));
    return Eigen::Vector4d((q * Quat(0.0, w.x(), w.y(), w.z())).coeffs());
  };
  const double turn = (inverse_inertia_ * (start.conjugate() * momentum)).norm() * std::abs(time_s);
  if (turn == 0.0) return start;
  const int steps = std::clamp(static_cast<int>(std::ceil(turn / kTurnPerStep)), 1, kMaxSteps);
  const double h = time_s / steps;
  Quat q = start;
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector4d c = q.coeffs();
    const auto at = [&](const Eigen::Vector4d& k, double share) {
      return Quat(Eigen::Vector4d(c + share * h * k)).normalized();
    };
    const Eigen::Vector4d k1 = rate(q), k2 = rate(at(k1, 0.5)), k3 = rate(at(k2, 0.5)),
                          k4 = rate(at(k3, 1.0));
    q.coeffs() = c + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    q.normalize();
  }
  return q;
}

// Shooting: the mean spin gives a second-order guess, each correction gains a factor of about its turn.
Vec3 Track::momentum_between(const Quat& from, const Quat& to, double time_s, double* angle) const {
  const Vec3 turn = rotation_log(from.conjugate() * to);
  *angle = turn.norm();
  if (*angle == 0.0) return Vec3::Zero();
  const Quat middle = from * rotation_exp(0.5 * turn);
  const Mat3& inertia = body_->inertia_kg_m2();
  Vec3 momentum = middle * (inertia * turn) / time_s;
  if (body_->isotropic()) return momentum;
  for (int i = 0; i < 8; ++i) {
    const Quat reached = rotate(from, momentum, time_s);
    const Vec3 missing = rotation_log(to * reached.conjugate());  // world axes
    if (missing.norm() <= 1e-12 * *angle + 1e-15) break;
    momentum += middle * (inertia * (middle.conjugate() * missing)) / time_s;
  }
  return momentum;
}

// `near` and `far` are the neighbouring samples on one side of i; differences work for either side.
Velocity Track::one_sided(int i, int near, int far, bool has_far) const {
  const double h1 = time(near) - time(i);
  const Vec3 d1 = (position(near) - position(i)) / h1;
  Velocity velocity;
  velocity.momentum = momenta_[std::min(i, near)];
  if (has_far) {
    const double h2 = time(far) - time(near);
    const Vec3 d2 = (position(far) - position(near)) / h2;
    velocity.acceleration = 2.0 * (d2 - d1) / (h1 + h2);
    // constant in flight; in contact the ground's torque turns it
    const Vec3 change = velocity.momentum - momenta_[std::min(near, far)];
    velocity.momentum += h1 / (h1 + h2) * change;
  } else {
    velocity.acceleration = gravity_;
  }
  velocity.linear = d1 - 0.5 * h1 * velocity.acceleration;
  return velocity;
}

Velocity Track::before(int i, int first) const { return one_sided(i, i - 1, i - 2, i - 2 >= first); }

Velocity Track::after(int i, int last) const { return one_sided(i, i + 1, i + 2, i + 2 <= last); }

Pose Track::extrapolate(int i, const Velocity& velocity, double time_s) const {
  return {position(i) + time_s * (velocity.linear + 0.5 * time_s * velocity.acceleration),
          rotate(orientation(i), velocity.momentum, time_s)};
}

Vec3 Track::arm(int point, const Quat& q) const {
  const Vec3 rounding = body_->radius_m() * kUp;
  const int n_vertices = static_cast<int>(body_->vertices().size());
  if (point < n_vertices) return q * body_->vertices()[point] - rounding;
  const Ring& ring = body_->rings()[(point - n_vertices) / kAround];
  const Vec3 axis = q * ring.axis;
  Vec3 level = axis.cross(kUp);  // in the ring's plane and the ground's
  level = level.norm() > 1e-12 ? level.normalized() : Vec3(q * ring.axis.unitOrthogonal());
  const double angle = (point - n_vertices) % kAround * kTwoPi / kAround;
  const Vec3 lowest = axis.cross(level).z() < 0.0 ? axis.cross(level) : level.cross(axis);
  return q * ring.centre_m + ring.radius_m * (std::cos(angle) * lowest + std::sin(angle) * level) - rounding;
}

double Track::height(int point, const Pose& pose) const {
  return pose.position.z() + arm(point, pose.orientation).z();
}

double Track::height(int point, int i, int j) const {
  if (point < static_cast<int>(body_->vertices().size())) return heights_(point, j);
  const Vec3 rounding = body_->radius_m() * kUp;
  const Vec3 own = orientation(i).conjugate() * (arm(point, orientation(i)) + rounding);
  return position(j).z() + (orientation(j) * own - rounding).z();
}

double Track::vertical_speed(int point, const Pose& pose, const Velocity& velocity, double time_s) const {
  const Vec3 spin = angular_velocity(pose.orientation, velocity.momentum);
  return velocity.linear.z() + time_s * velocity.acceleration.z() +
         spin.cross(arm(point, pose.orientation)).z();
}

}  // namespace ifa::verify
