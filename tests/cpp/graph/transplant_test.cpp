// Transplants compose, and registration is the best turn: against search.
#include "ifa/graph/transplant.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ifa/base/random.hpp"

namespace ifa {
namespace {

Quat about_z(double angle) { return Quat(std::cos(0.5 * angle), 0.0, 0.0, std::sin(0.5 * angle)); }

State random_state(RandomStream& random) {
  State s;
  s.position = random.unit_vector();
  s.orientation = rotation_exp(std::numbers::pi * random.uniform() * random.unit_vector());
  s.velocity = 3.0 * random.unit_vector();
  s.angular_velocity = 20.0 * random.unit_vector();
  return s;
}

Transplant random_transplant(RandomStream& random) {
  Transplant p;
  const Mat3 axes = rotation_exp(3.0 * random.unit_vector()).toRotationMatrix();
  p.element.proper = random.uniform() < 0.5;
  p.element.map = p.element.proper ? axes : Mat3(-axes);
  p.turn = about_z(random.uniform(-3.0, 3.0));
  p.shift = {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.0};
  return p;
}

double apart(const State& a, const State& b) {
  return std::max({(a.position - b.position).norm(), 1.0 - std::abs(a.orientation.dot(b.orientation)),
                   (a.velocity - b.velocity).norm(), (a.angular_velocity - b.angular_velocity).norm()});
}

TEST(Transplant, OneAfterAnotherIsOneAfterTheOther) {
  RandomStream random(1, 0);
  for (int i = 0; i < 200; ++i) {
    const Transplant p = random_transplant(random), q = random_transplant(random);
    const State s = random_state(random);
    EXPECT_LT(apart(p.after(q).of(s), p.of(q.of(s))), 1e-12);  // products of a few rotations, speeds of 20
  }
}

TEST(Transplant, TheGroundStaysTheGround) {
  RandomStream random(2, 0);
  for (int i = 0; i < 100; ++i) {
    const State s = random_state(random), t = random_transplant(random).of(s);
    EXPECT_EQ(t.position.z(), s.position.z());
    EXPECT_NEAR(t.velocity.z(), s.velocity.z(), 1e-14);
    EXPECT_NEAR(t.velocity.norm(), s.velocity.norm(), 1e-14);
  }
}

TEST(Registration, NoTurnIsBetter) {
  RandomStream random(3, 0);
  for (int i = 0; i < 50; ++i) {
    const State from = random_state(random), to = random_state(random);
    const auto angle_at = [&](const Quat& turn) {
      return rotation_log(turn * from.orientation * to.orientation.conjugate()).norm();
    };
    const Transplant p = registration(from, to);
    double best = 10.0;
    for (int a = 0; a < 3600; ++a) best = std::min(best, angle_at(about_z(a * std::numbers::pi / 1800.0)));
    EXPECT_LE(angle_at(p.turn), best + 1e-12);
    EXPECT_LT((p.of(from).position - to.position).head<2>().norm(), 1e-14);
    // Erratum: what is left is the angle between the two ups, seen from the body.
    const Vec3 a = from.orientation.conjugate() * kUp, b = to.orientation.conjugate() * kUp;
    EXPECT_NEAR(angle_at(p.turn), std::atan2(a.cross(b).norm(), a.dot(b)), 1e-12);
  }
}

}  // namespace
}  // namespace ifa
