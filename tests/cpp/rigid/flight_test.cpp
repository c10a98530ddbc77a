#include "ifa/rigid/flight.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::angle_between;
using sample::angular_momentum;
using sample::kinetic;
using sample::lowest;

// 1 x 2 x 3: moments 13, 10 and 5 in units of m / 12 of the squared unit.
Body brick() { return sample::box({0.01, 0.02, 0.03}, 0.05); }

Body symmetric(double axial_over_transverse) {
  Body::Definition d = sample::box({0.02, 0.02, 0.02}, 0.03).definition();
  const double transverse = 2e-6;
  d.inertia_kg_m2 = Vec3(transverse, transverse, axial_over_transverse * transverse).asDiagonal();
  return Body::make(d);
}

State spinning(const Vec3& spin, const Quat& orientation = Quat::Identity()) {
  State s;
  s.position.z() = 1.0;
  s.orientation = orientation;
  s.angular_velocity = spin;
  return s;
}

TEST(Flight, PositionIsAParabola) {
  const Body body = brick();
  State s = spinning({1, 2, 3});
  s.velocity = {0.3, -0.2, 1.5};
  const Vec3 gravity(0.5, -1.0, -9.0);
  Flight flight(body);
  flight.start(s, gravity);
  for (const double t : {-0.7, 0.0, 0.1, 2.0}) {
    const State now = flight.at(t);
    EXPECT_LT((now.position - (s.position + t * s.velocity + 0.5 * t * t * gravity)).norm(), 1e-14);
    EXPECT_LT((now.velocity - (s.velocity + t * gravity)).norm(), 1e-14);
  }
}

TEST(Flight, IsotropicBodyTurnsAboutOneAxis) {
  const Body cube = sample::box({0.02, 0.02, 0.02}, 0.01);
  ASSERT_TRUE(cube.isotropic());
  RandomStream random(1, 0);
  Flight flight(cube);
  for (int i = 0; i < 50; ++i) {
    const Vec3 axis = random.unit_vector();
    const double rate = random.uniform(0.1, 300.0), t = random.uniform(-1.0, 1.0);
    const State s = spinning(rate * axis, random.rotation());
    flight.start(s, Vec3::Zero());
    const Quat expected = Quat(Eigen::AngleAxisd(rate * t, axis)) * s.orientation;
    // An angle of up to 300 rad is rounded by 3e-14 before its sine is taken.
    EXPECT_LT(angle_between(flight.at(t).orientation, expected), 2e-13);
    EXPECT_EQ(flight.at(t).angular_velocity, s.angular_velocity);
  }
}

// Hard case 3: q(t) = exp(L t / I1) q0 exp(-lambda t e3), lambda = (I3 - I1) w3 / I1.
TEST(Flight, SymmetricBodyPrecesses) {
  RandomStream random(2, 0);
  for (const double ratio : {0.01, 0.5, 0.999, 1.3, 1.99}) {
    const Body body = symmetric(ratio);
    Flight flight(body);
    for (int i = 0; i < 10; ++i) {
      State s = spinning(random.uniform(1.0, 20.0) * random.unit_vector(), random.rotation());
      flight.start(s, sample::downwards());
      const Vec3 precession = angular_momentum(body, s) / body.principal_inertia().x();
      const double axial = (s.orientation.conjugate() * s.angular_velocity).z();
      const double rate = (ratio - 1.0) * axial;
      for (const double t : {-0.5, 0.3, 1.0}) {
        const Quat expected = Quat(Eigen::AngleAxisd(precession.norm() * t, precession.normalized())) *
                              s.orientation * Quat(Eigen::AngleAxisd(-rate * t, Vec3::UnitZ()));
        const State now = flight.at(t);
        EXPECT_LT(angle_between(now.orientation, expected), 1e-12) << ratio << " at " << t;
        EXPECT_LT((angular_momentum(body, now) - angular_momentum(body, s)).norm(),
                  1e-13 * angular_momentum(body, s).norm());
      }
    }
  }
}

// Hard case 1, against another formulation by another method: R' = [R I^-1 R^T L]x R with L constant,
// Runge-Kutta 4 in long double. With 2e-4 rad a step its error over 6 rad is about 6 (2e-4)^4 = 1e-14.
TEST(Flight, TriaxialBodyFollowsTheEquationsOfMotion) {
  using Mat = Eigen::Matrix<long double, 3, 3>;
  using Vec = Eigen::Matrix<long double, 3, 1>;
  const Body body = brick();
  RandomStream random(3, 0);
  Flight flight(body);
  for (int i = 0; i < 5; ++i) {
    const State s = spinning(20.0 * random.unit_vector(), random.rotation());
    flight.start(s, sample::downwards());
    const Vec inverse = body.principal_inertia().cwiseInverse().cast<long double>();
    const Vec momentum = angular_momentum(body, s).cast<long double>();
    const auto slope = [&](const Mat& r) {
      const Vec w = r * inverse.asDiagonal() * r.transpose() * momentum;
      Mat cross;
      cross << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
      return Mat(cross * r);
    };
    Mat r = s.orientation.toRotationMatrix().cast<long double>();
    constexpr int kSteps = 30000;
    const long double h = 0.3L / kSteps;
    for (int k = 0; k < kSteps; ++k) {
      const Mat a = slope(r), b = slope(r + 0.5L * h * a), c = slope(r + 0.5L * h * b), d = slope(r + h * c);
      r += h / 6.0L * (a + 2.0L * b + 2.0L * c + d);
    }
    const Quat expected(Mat3(r.cast<double>()));
    EXPECT_LT(angle_between(flight.at(0.3).orientation, expected), 1e-12);  // case 1 asks for 1e-10
  }
}

// Hard case 2: a spin about the middle axis, 0.001 rad off, turns over again and again. From Landau and
// Lifshitz, for I1 < I2 < I3 and L^2 > 2 E I2 the spin is periodic with 4 K(k) / rate; half way w1 and w2
// have changed sign.
TEST(Flight, MiddleAxisFlipsWithTheEllipticPeriod) {
  const Body body = sample::box({0.03, 0.02, 0.01}, 0.05);  // moments increase with x, y, z
  const Vec3 moments = body.principal_inertia();
  ASSERT_TRUE(moments.x() < moments.y() && moments.y() < moments.z());
  const State s = spinning({0.0, 15.0, 0.015});
  const double energy2 = 2.0 * kinetic(body, s), momentum2 = angular_momentum(body, s).squaredNorm();
  ASSERT_GT(momentum2, energy2 * moments.y());
  const double a = (moments.z() - moments.y()) * (momentum2 - energy2 * moments.x());
  const double k2 = (moments.y() - moments.x()) * (energy2 * moments.z() - momentum2) / a;
  const double period = 4.0 * std::comp_ellint_1(std::sqrt(k2)) * std::sqrt(moments.prod() / a);
  Flight flight(body);
  flight.start(s, Vec3::Zero());  // so that the energy is the spin's alone
  const auto body_spin = [&](double t) -> Vec3 {
    const State now = flight.at(t);
    return now.orientation.conjugate() * now.angular_velocity;
  };
  const Vec3 start = body_spin(0.0);
  // Departures from the axis grow by e^(rate T / 4) between flips, here a thousandfold: rounding of 1e-16
  // becomes 1e-13, that of k^2 (1 - k^2 is 1e-6) 1e-10 in the period.
  EXPECT_LT((body_spin(0.5 * period) - start.cwiseProduct(Vec3(-1, -1, 1))).norm(), 15.0 * 1e-8);
  EXPECT_LT((body_spin(period) - start).norm(), 15.0 * 1e-8);
  for (const double t : {0.1, 0.5 * period, period, 3.0}) {
    EXPECT_NEAR(kinetic(body, flight.at(t)), kinetic(body, s), 1e-12 * kinetic(body, s));
    EXPECT_LT((angular_momentum(body, flight.at(t)) - angular_momentum(body, s)).norm(),
              1e-12 * angular_momentum(body, s).norm());
  }
}

// Hard case 4.
TEST(Flight, NearTheSeparatrixMomentumIsKept) {
  const Body body = sample::box({0.03, 0.02, 0.01}, 0.05);
  Flight flight(body);
  for (const double off : {0.0, 1e-300, 1e-12, 1e-6})
    for (const double side : {-1.0, 1.0}) {
      const State s = spinning({off, 20.0, side * off});
      flight.start(s, sample::downwards());
      for (const double t : {0.3, 1.0, 5.0}) {
        const State now = flight.at(t);
        ASSERT_TRUE(now.orientation.coeffs().allFinite() && now.angular_velocity.allFinite());
        EXPECT_LT((angular_momentum(body, now) - angular_momentum(body, s)).norm(),
                  1e-10 * angular_momentum(body, s).norm());
      }
    }
}

// Hard case 5.
TEST(Flight, ForwardAndBackIsTheIdentity) {
  RandomStream random(4, 0);
  for (const Body& body : {brick(), sample::rod(0.2, 1e-3, 0.01), sample::box({0.05, 0.08, 1e-4}, 0.005)}) {
    Flight flight(body);
    for (int i = 0; i < 20; ++i) {
      State s = sample::random_state(body, random, 1.0, 4.0, 40.0);
      const double t = random.uniform(0.05, 0.5);
      flight.start(s, sample::downwards());
      const State there = flight.at(t);
      flight.start(there, sample::downwards());
      const State back = flight.at(-t);
      EXPECT_LT(angle_between(back.orientation, s.orientation), 1e-11);
      EXPECT_LT((back.position - s.position).norm(), 1e-14);
      EXPECT_LT((back.velocity - s.velocity).norm(), 1e-14);
      EXPECT_LT((back.angular_velocity - s.angular_velocity).norm(), 1e-11 * 40.0);
    }
  }
}

TEST(Flight, PiecesJoinInAnyOrderOfTimes) {
  const Body body = brick();
  const State s = spinning({30.0, 20.0, -40.0});
  Flight once(body), jumping(body);
  once.start(s, sample::downwards());
  jumping.start(s, sample::downwards());
  for (const double t : {2.0, -1.0, 0.01, 1.0, -0.3, 1.5, 0.0}) {
    once.start(s, sample::downwards());
    EXPECT_EQ(once.at(t).orientation.coeffs(), jumping.at(t).orientation.coeffs());
  }
}

// Hard case 7: the quadratic's root, written without cancellation.
TEST(NextContact, OfABallIsTheQuadraticsRoot) {
  const double radius = 0.02;
  const Body ball = sample::ball(radius, 0.03);
  RandomStream random(5, 0);
  Flight flight(ball);
  for (int i = 0; i < 500; ++i) {
    State s = sample::random_state(ball, random, std::pow(10.0, random.uniform(-6.0, 0.5)), 5.0, 100.0);
    const double h = s.position.z() - radius, v = s.velocity.z(),
                 root = std::sqrt(v * v + 2 * sample::kGravity * h);
    const double expected = v > 0 ? (v + root) / sample::kGravity : 2.0 * h / (root - v);
    flight.start(s, sample::downwards());
    EXPECT_NEAR(flight.next_contact(kNever), expected, 1e-12);
    EXPECT_EQ(flight.next_contact(0.99 * expected), kNever);
  }
}

TEST(NextContact, FromTheGroundIsTheNextLanding) {
  const Body ball = sample::ball(0.02, 0.03);
  Flight flight(ball);
  for (const double speed : {0.011, 0.3, 4.0}) {
    State s;
    s.position.z() = 0.02;
    s.velocity.z() = speed;
    flight.start(s, sample::downwards());
    EXPECT_NEAR(flight.next_contact(kNever), 2.0 * speed / sample::kGravity, 1e-12);
  }
}

TEST(NextContact, NeverWithoutGravity) {
  const Body ball = sample::ball(0.02, 0.03);
  Flight flight(ball);
  State s;
  s.position.z() = 0.5;
  for (const double speed : {0.0, 1.0}) {
    s.velocity.z() = speed;
    flight.start(s, Vec3::Zero());
    EXPECT_EQ(flight.next_contact(1000.0), kNever);
  }
  s.velocity.z() = -1.0;
  flight.start(s, Vec3::Zero());
  EXPECT_NEAR(flight.next_contact(1000.0), 0.48, 1e-12);
}

// Neither late nor early, for shapes that sweep far in a moment. Dense samples with a parabola through each
// minimum see any excursion below the ground that lasts longer than a thousandth of a sample.
TEST(NextContact, OfATumblingBodyIsTheFirst) {
  RandomStream random(6, 0);
  for (const Body& body : {sample::box({0.02, 0.02, 0.02}, 0.01), brick(), sample::rod(0.2, 5e-4, 0.01),
                           sample::box({0.05, 0.08, 1e-4}, 0.005)}) {
    const double size = body.bounding_radius_m();
    Flight flight(body);
    int landed = 0;
    for (int i = 0; i < 100; ++i) {
      State s = sample::random_state(body, random, std::pow(10.0, random.uniform(-4.0, -0.5)), 2.0,
                                     i % 2 ? 20.0 : 500.0);
      flight.start(s, sample::downwards());
      const double until = 0.2, found = flight.next_contact(until);
      const double end = std::min(found, until);
      landed += found <= until;
      if (found <= until) {
        EXPECT_NEAR(lowest(body, flight.at(found)), 0.0, 1e-12 * size);
        EXPECT_LT(lowest(body, flight.at(found + 1e-9)), 0.0);  // it goes on downwards
      }
      constexpr int kSamples = 2000;
      double before = lowest(body, s), here = before;
      for (int k = 1; k < kSamples; ++k) {
        const double next = lowest(body, flight.at(end * k / kSamples));
        double least = next;
        if (here < before && here < next) {  // vertex of the parabola; the minimum of corners lies above it
          const double curve = before - 2 * here + next, slope = 0.5 * (next - before);
          least = std::min(here - 0.125 * slope * slope / curve, next);
        }
        ASSERT_GT(least, -1e-11 * size) << "missed at " << end * k / kSamples << " of " << found;
        before = here;
        here = next;
      }
    }
    EXPECT_GT(landed, 50);
  }
}

// A rod that spins about a fixed centre: its tip sinks to h - (l / 2) sin(w t). Just above half its length it
// never touches, just below it grazes at asin(2 h / l) / w.
TEST(NextContact, GrazingTip) {
  const double length = 0.2, rate = 30.0;
  const Body body = sample::rod(length, 0.0005, 0.01);
  Flight flight(body);
  for (const double gap : {1e-9, 1e-6, 1e-3}) {
    State s = spinning({0.0, rate, 0.0});  // the +x tip goes down
    s.position.z() = 0.0005 + 0.5 * length * (1.0 + gap);
    flight.start(s, Vec3::Zero());
    EXPECT_EQ(flight.next_contact(0.5), kNever) << gap;
    s.position.z() = 0.0005 + 0.5 * length * (1.0 - gap);
    flight.start(s, Vec3::Zero());
    // A point 1e-14 of the size above the ground touches it, and the tip sinks at w l / 2 sqrt(2 gap).
    EXPECT_NEAR(flight.next_contact(0.5), std::asin(1.0 - gap) / rate, 1e-14 / (rate * std::sqrt(2.0 * gap)))
        << gap;
  }
}

TEST(NextContact, ClearanceAgreesWithThePoses) {
  const Body body = brick();
  RandomStream random(7, 0);
  Flight flight(body);
  for (int i = 0; i < 50; ++i) {
    flight.start(sample::random_state(body, random, 0.1, 3.0, 50.0), sample::downwards());
    const double t = random.uniform(-0.2, 0.4);
    EXPECT_NEAR(flight.clearance(t), lowest(body, flight.at(t)), 1e-14);
  }
}

}  // namespace
}  // namespace ifa
