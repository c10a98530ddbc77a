#include "ifa/base/linear_algebra.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "held.hpp"
#include "ifa/base/random.hpp"

namespace ifa {
namespace {

// Rodrigues' formula in long double: R = I + sin(a) K + (1 - cos(a)) K^2, K = [axis]x.
Mat3 rodrigues(const Vec3& axis, double angle) {
  using Mat3l = Eigen::Matrix<long double, 3, 3>;
  const Mat3l k = cross_matrix(axis).cast<long double>();
  const long double a = angle, half_sine = std::sin(0.5L * a);
  return (Mat3l::Identity() + std::sin(a) * k + 2.0L * half_sine * half_sine * (k * k)).cast<double>();
}

// Angles on both sides of the switch to the series (1e-4), and beyond a full turn.
const std::vector<double> kAngles = {1e-300,
                                     1e-12,
                                     1e-8,
                                     0.99e-4,
                                     1e-4,
                                     1.01e-4,
                                     1e-3,
                                     0.1,
                                     1.0,
                                     3.0,
                                     std::numbers::pi,
                                     5.0,
                                     2.0 * std::numbers::pi,
                                     20.0};

TEST(CrossMatrix, IsTheCrossProduct) {
  RandomStream stream(1, 1);
  for (int i = 0; i < 100; ++i) {
    const Vec3 a = 10.0 * stream.unit_vector(), b = 0.1 * stream.unit_vector();
    EXPECT_LE((cross_matrix(a) * b - a.cross(b)).norm(), 1e-15);  // the same products, |a| |b| = 1
  }
  EXPECT_EQ(cross_matrix(Vec3::UnitX()) * Vec3::UnitY(), Vec3::UnitZ());
}

TEST(RotationExp, AgreesWithRodrigues) {
  RandomStream stream(1, 2);
  for (const double angle : kAngles) {
    for (int i = 0; i < 20; ++i) {
      const Vec3 axis = stream.unit_vector();
      const Mat3 r = rotation_exp(angle * axis).toRotationMatrix();
      // rounding of the entries, and of the angle itself in the argument of the sine
      EXPECT_LE((r - rodrigues(axis, angle)).cwiseAbs().maxCoeff(), 1e-15 * (2.0 + angle)) << angle;
    }
  }
}

// A small rotation keeps all its digits: the matrix alone would hide an error in the vector part.
TEST(RotationExp, VectorPartIsRelativelyExact) {
  for (const double angle : kAngles) {
    if (angle > 1.0) continue;  // near pi and beyond the sine itself loses relative digits
    const double expected = static_cast<double>(std::sin(0.5L * static_cast<long double>(angle)));
    const Quat q = rotation_exp(Vec3(0.0, angle, 0.0));
    EXPECT_NEAR(q.y() / expected, 1.0, 1e-15) << angle;  // four roundings
    EXPECT_EQ(q.x(), 0.0);
    EXPECT_EQ(q.z(), 0.0);
  }
}

TEST(RotationExp, ZeroIsTheIdentity) {
  EXPECT_EQ(rotation_exp(Vec3::Zero()).coeffs(), Quat::Identity().coeffs());
}

TEST(RotationExp, IsAUnitQuaternionAndInvertsByItsSign) {
  RandomStream stream(1, 3);
  for (const double angle : kAngles) {
    const Vec3 theta = angle * stream.unit_vector();
    EXPECT_NEAR(rotation_exp(theta).norm(), 1.0, 1e-15);  // a few roundings
    EXPECT_EQ(rotation_exp(-theta).coeffs(), rotation_exp(theta).conjugate().coeffs());
  }
}

TEST(RotationExp, RotationsAboutOneAxisAdd) {
  RandomStream stream(1, 4);
  for (int i = 0; i < 100; ++i) {
    const Vec3 axis = stream.unit_vector();
    const double a = stream.uniform(-6.0, 6.0), b = stream.uniform(-6.0, 6.0);
    const Quat product = rotation_exp(a * axis) * rotation_exp(b * axis);
    const Quat sum = rotation_exp((a + b) * axis);
    EXPECT_LE((product.coeffs() - sum.coeffs()).norm(), 1e-14);  // rounding of angles up to 12 rad
  }
}

// Hard case 22: the largest error of a component in its own units in the last place.
double ulps(const Vec3& value, const Vec3& expected) {
  double worst = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double size = std::abs(expected[i]);
    worst = std::max(worst, std::abs(value[i] - expected[i]) / (std::nextafter(size, INFINITY) - size));
  }
  return worst;
}

TEST(RotationLog, RoundTripFromZeroToPi) {
  RandomStream stream(1, 5);
  Held error("error of a component, ulp", 4.0);
  const double pi = std::numbers::pi;
  for (const double angle : {0.0, 1e-300, 1e-160, 1e-16, 1e-8, 0.99e-4, 1e-4, 1.01e-4, 1e-3, 0.5, 1.0, 2.0,
                             3.0, pi - 1e-3, pi - 1e-8, pi - 1e-15, pi})
    for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1)}) {
      error.see(ulps(rotation_log(rotation_exp(angle * axis)), angle * axis));
      for (int i = 0; i < 200; ++i) {
        Vec3 theta = angle * stream.unit_vector();
        while (theta.norm() > pi) theta *= 1.0 - 2e-16;  // past a half turn the short arc is the other one
        error.see(ulps(rotation_log(rotation_exp(theta)), theta));
      }
    }
}

// sin(1e-16) is 1e-16 and sin(x / 2) of x = pi - 1e-15 is 1 to rounding: logarithms known without the
// exponential.
TEST(RotationLog, KnownValues) {
  Held error("error of a component, ulp", 4.0);
  error.see(ulps(rotation_log(Quat(1.0, 0.0, 0.5e-16, 0.0)), Vec3(0.0, 1e-16, 0.0)));
  error.see(ulps(rotation_log(Quat(1.0, 3e-200, -4e-200, 0.0)), Vec3(6e-200, -8e-200, 0.0)));
  error.see(
      ulps(rotation_log(Quat(0.5e-15, 0.6, 0.0, -0.8)), (std::numbers::pi - 1e-15) * Vec3(0.6, 0.0, -0.8)));
  error.see(ulps(rotation_log(Quat(std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5))),
                 Vec3(0.0, 0.0, 0.5 * std::numbers::pi)));
  EXPECT_EQ(rotation_log(Quat::Identity()), Vec3(0, 0, 0));
  EXPECT_EQ(rotation_log(Quat(-1.0, 0.0, 0.0, 0.0)), Vec3(0, 0, 0));
}

TEST(RotationLog, AHalfTurnIsAboutTheAxisWhoseFirstComponentIsPositive) {
  Held error("error of a component, ulp", 4.0);
  for (const double w : {0.0, -0.0})
    for (const double sign : {-1.0, 1.0}) {
      const double pi = std::numbers::pi;
      error.see(ulps(rotation_log(Quat(w, sign, 0, 0)), {pi, 0, 0}));
      error.see(ulps(rotation_log(Quat(w, 0, sign, 0)), {0, pi, 0}));
      error.see(ulps(rotation_log(Quat(w, 0, 0, sign)), {0, 0, pi}));
      error.see(ulps(rotation_log(Quat(w, sign * 0.6, sign * -0.8, 0)), pi * Vec3(0.6, -0.8, 0)));
      error.see(ulps(rotation_log(Quat(w, 0, sign * 0.6, sign * -0.8)), pi * Vec3(0, 0.6, -0.8)));
    }
}

TEST(RotationLog, IsTheShortestArcAndTheSameForBothSigns) {
  RandomStream stream(1, 6);
  for (int i = 0; i < 10000; ++i) {
    Quat q = stream.rotation();
    if (i % 4 == 0) q.w() *= 1e-15;  // near a half turn
    if (i % 4 == 1) q.vec() *= 1e-15;
    q.normalize();
    const Vec3 theta = rotation_log(q);
    EXPECT_LE(theta.norm(), std::numbers::pi * (1.0 + 4e-16)) << i;
    EXPECT_EQ(rotation_log(Quat(-q.w(), -q.x(), -q.y(), -q.z())), theta) << i;
    // the same rotation, by either quaternion
    const Quat back = rotation_exp(theta);
    EXPECT_LE(std::min((back.coeffs() - q.coeffs()).norm(), (back.coeffs() + q.coeffs()).norm()), 1e-15) << i;
  }
}

}  // namespace
}  // namespace ifa
