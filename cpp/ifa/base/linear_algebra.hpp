// The project's names for Eigen's types.
#pragma once

#include <Eigen/Dense>

#include <cmath>

namespace ifa {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;  // constructor order w, x, y, z; storage x, y, z, w

inline const Vec3 kUp(0.0, 0.0, 1.0);  // the ground's normal; the ground is z = 0

// [a]x b = a x b
inline Mat3 cross_matrix(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

// The unit quaternion of the rotation vector theta (axis times angle, rad).
inline Quat rotation_exp(const Vec3& theta) {
  const double angle = theta.norm();
  // sin(x / 2) / x by its series where the division would lose digits
  const double s = angle > 1e-4 ? std::sin(0.5 * angle) / angle : 0.5 - angle * angle / 48.0;
  return Quat(std::cos(0.5 * angle), s * theta.x(), s * theta.y(), s * theta.z());
}

// The inverse: the rotation vector of the shortest arc, of length at most pi, the same for q and -q. A half
// turn has two, of opposite sign: the one whose first component that is not zero is positive. q need not be
// of unit length.
inline Vec3 rotation_log(const Quat& q) {
  const Vec3 v = q.vec();
  const double sine = v.stableNorm();  // also where squares vanish
  if (sine == 0.0) return Vec3::Zero();
  const double first = v.x() != 0.0 ? v.x() : v.y() != 0.0 ? v.y() : v.z();
  const double sign = q.w() < 0.0 || (q.w() == 0.0 && first < 0.0) ? -1.0 : 1.0;
  return (sign * 2.0 * std::atan2(sine, std::abs(q.w())) / sine) * v;
}

}  // namespace ifa
