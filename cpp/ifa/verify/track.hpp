// Kinematics of sampled poses: heights of the hull points, and velocities from finite differences.
#pragma once

#include <vector>

#include "ifa/rigid/body.hpp"
#include "ifa/verify/certificate.hpp"

namespace ifa::verify {

struct Velocity {
  Vec3 linear, acceleration;  // of the centre of mass
  Vec3 momentum;              // angular, world axes, kg m^2/s
};

struct Pose {
  Vec3 position;
  Quat orientation;
};

// Interval j goes from sample j to sample j + 1. The rotation across an interval is described by the constant
// angular momentum that takes one orientation to the next by Euler's equations: exact in flight however
// coarse the sampling, and a plain finite difference where contact forces act. It needs no stencil that could
// straddle an impact.
class Track {
 public:
  // The poses and the body must outlive it.
  Track(const Poses& poses, const Body& body, double gravity_m_s2);

  int size() const { return static_cast<int>(poses_->times_s.size()); }
  // Points that may touch: the vertices, and for each circular edge its lowest point at a pose and seven more
  // around it from there.
  int points() const { return static_cast<int>(heights_.rows()); }
  // One of those seven more.
  bool beside_lowest(int point) const {
    const int on_edges = point - static_cast<int>(body_->vertices().size());
    return on_edges >= 0 && on_edges % kAround != 0;
  }
  // Points that stay with the body, in its axes: the vertices, and some of each circular edge.
  const std::vector<Vec3>& fixed_points() const { return fixed_points_; }
  const Body& body() const { return *body_; }
  // Height below which a hull point touches, m.
  double touch() const { return touch_m_; }
  double time(int i) const { return poses_->times_s[i]; }
  double step(int j) const { return time(j + 1) - time(j); }
  const Vec3& position(int i) const { return poses_->positions_m[i]; }
  const Quat& orientation(int i) const { return poses_->orientations[i]; }
  double height(int point, int i) const { return heights_(point, i); }  // above the ground
  // At sample j, of the body's own point that is there at sample i: what an edge rolls away from.
  double height(int point, int i, int j) const;
  double lowest(int i) const { return lowest_[i]; }
  double turn(int j) const { return turns_[j]; }  // angle of interval j, rad
  const Vec3& momentum(int j) const { return momenta_[j]; }
  double speed_bound(int j) const;  // of any hull point, on average over the interval

  // Just before sample i, from samples [max(first, i - 2), i]; needs i > first. With two samples only,
  // gravity is assumed.
  Velocity before(int i, int first) const;
  // Just after sample i, from samples [i, min(last, i + 2)]; needs i < last.
  Velocity after(int i, int last) const;

  Vec3 angular_velocity(const Quat& orientation, const Vec3& momentum) const;  // world axes
  Quat rotate(const Quat& orientation, const Vec3& momentum, double time_s) const;
  Pose extrapolate(int i, const Velocity& velocity, double time_s) const;  // of either sign
  double height(int point, const Pose& pose) const;
  double vertical_speed(int point, const Pose& pose, const Velocity& velocity, double time_s) const;
  Vec3 arm(int point, const Quat& orientation) const;

 private:
  static constexpr int kAround = 8;

  Velocity one_sided(int i, int near, int far, bool has_far) const;
  Vec3 momentum_between(const Quat& from, const Quat& to, double time_s, double* angle) const;

  const Poses* poses_;
  const Body* body_;
  Vec3 gravity_;
  double touch_m_;
  std::vector<Vec3> fixed_points_;
  Mat3 inverse_inertia_;
  Eigen::MatrixXd heights_;
  std::vector<double> lowest_, turns_;
  std::vector<Vec3> momenta_;
};

}  // namespace ifa::verify
