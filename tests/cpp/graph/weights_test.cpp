// The sound-independent weights against the same in world axes, as the paper writes them.
#include "ifa/graph/weights.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "ifa/base/random.hpp"
#include "ifa/graph/transplant.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

State random_take_off(RandomStream& random) {
  State s;
  s.position = {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(0.008, 0.014)};
  s.orientation = rotation_exp(std::numbers::pi * random.uniform() * random.unit_vector());
  s.velocity = 2.0 * random.uniform() * random.unit_vector();
  s.angular_velocity = 40.0 * random.uniform() * random.unit_vector();
  return s;
}

TEST(Splice, IsWhatThePaperComputesInTheWorld) {
  RandomStream random(4, 0);
  for (int n = 0; n < 200; ++n) {
    const State i = random_take_off(random), j = random_take_off(random);
    const Vec3 dv = random.unit_vector(), dw = 30.0 * random.unit_vector();  // of i's impact, world
    const double flight_s = random.uniform(0.02, 0.5);
    const Quat to_body = i.orientation.conjugate();
    const Splice s =
        splice(take_off_of(i), PlausibleRegion(to_body * dv, to_body * dw, 0.01), take_off_of(j), flight_s);

    const State beside = registration(j, i).of(j);
    const Vec3 gravity(0.0, 0.0, -9.81);
    const Vec3 end = beside.position + flight_s * beside.velocity + 0.5 * flight_s * flight_s * gravity;
    const Vec3 v_blend = (end - i.position) / flight_s - 0.5 * flight_s * gravity;
    // rounding of positions of 1 m over 20 ms, and of a near half turn
    EXPECT_LT((i.orientation * s.velocity - v_blend).norm(), 1e-9);
    EXPECT_LT((i.orientation * s.spin - beside.angular_velocity).norm(), 1e-9);
    const double excess = PlausibleRegion(dv, dw, 0.01)
                              .excess(v_blend - i.velocity, beside.angular_velocity - i.angular_velocity);
    EXPECT_NEAR(s.excess, excess, 1e-9 * (1.0 + excess));
    const double theta = rotation_log(i.orientation * beside.orientation.conjugate()).norm();
    EXPECT_NEAR(s.angle_rad, theta, 1e-9);
    EXPECT_NEAR(s.log_orientation, -0.85 * std::pow(theta / std::min(flight_s, 0.2), 2),
                1e-6 * (1.0 - s.log_orientation));
  }
}

TEST(Splice, HeadingAndPlaceDoNotMatter) {
  RandomStream random(5, 0);
  for (int n = 0; n < 50; ++n) {
    const State i = random_take_off(random), j = random_take_off(random);
    Transplant anywhere;
    anywhere.turn = Quat(std::cos(1.0), 0.0, 0.0, std::sin(1.0));
    anywhere.shift = {3.0, -2.0, 0.0};
    const PlausibleRegion region(Vec3(0.0, 0.5, 1.0), Vec3(10.0, 5.0, 0.0), 0.01);
    const Splice a = splice(take_off_of(i), region, take_off_of(j), 0.1);
    const Splice b = splice(take_off_of(i), region, take_off_of(anywhere.of(j)), 0.1);
    EXPECT_NEAR(a.excess, b.excess, 1e-10 * (1.0 + a.excess));  // rotations of speeds of 40
    EXPECT_NEAR(a.angle_rad, b.angle_rad, 1e-12);
  }
}

}  // namespace
}  // namespace ifa
