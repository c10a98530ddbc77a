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
