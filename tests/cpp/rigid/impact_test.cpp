#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ifa/rigid/event_engine.hpp"
#include "sample_bodies.hpp"
#include "strike.hpp"

namespace ifa {
namespace {

using sample::kinetic;
using sample::lowest;
using sample::strike;
using sample::touching;

// Rests on the ground by its lowest point.
State grounded(const Body& body, const Quat& orientation) {
  State s;
  s.orientation = orientation;
  s.position.z() = -lowest(body, s);
  return s;
}

Body random_body(RandomStream& random, const Material& material) {
  const double mass = std::pow(10.0, random.uniform(-3.0, 1.0));
  const double size = std::pow(10.0, random.uniform(-3.0, 0.0));
  const double kind = random.uniform();
  if (kind < 0.2) return sample::ball(size, mass, material);
  if (kind < 0.4) return sample::rod(size, 0.02 * size, mass, material);
  return sample::box(size * Vec3(random.uniform(0.01, 1.0), random.uniform(0.1, 1.0), 1.0), mass, material);
}

TEST(Impact, MomentaChangeByTheImpulse) {
  RandomStream random(13, 0);
  for (int i = 0; i < 1000; ++i) {
    const Body body = random_body(random, sample::ideal(random.uniform(), random.uniform(0.0, 1.0)));
    State s = grounded(body, random.rotation());
    s.velocity = random.uniform(0.0, 3.0) * random.unit_vector() - Vec3(0, 0, 3.0);
    s.angular_velocity = 1.0 / body.bounding_radius_m() * random.unit_vector();
    const State before = s;
    const ImpactResult hit = strike(body, s);
    const double impulse = hit.impulse_n_s.norm(), mass = body.mass_kg();
    EXPECT_EQ(impulse > 0.0,
              (before.velocity + before.angular_velocity.cross(hit.position_m - s.position)).z() < 0.0);
    EXPECT_LT((mass * (s.velocity - before.velocity) - hit.impulse_n_s).norm(), 1e-12 * mass * 10.0);
    const Vec3 torque = sample::angular_momentum(body, s) - sample::angular_momentum(body, before);
    const Vec3 expected = (hit.position_m - s.position).cross(hit.impulse_n_s);
    EXPECT_LT((torque - expected).norm(), 1e-12 * mass * 10.0 * body.bounding_radius_m());
  }
}

// Turning the world about the vertical turns the outcome and changes nothing else: the cone has no corners.
TEST(Impact, AnyYawIsTheSame) {
  RandomStream random(14, 0);
  for (int i = 0; i < 500; ++i) {
    const Body body = random_body(random, sample::ideal(random.uniform(), random.uniform(0.0, 1.0)));
    State s = grounded(body, random.rotation());
    s.velocity = random.uniform(0.0, 3.0) * random.unit_vector() - Vec3(0, 0, 3.0);
    s.angular_velocity = 1.0 / body.bounding_radius_m() * random.unit_vector();
    const Quat yaw(Eigen::AngleAxisd(random.uniform(0.0, 6.0), kUp));
    State turned = s;
    turned.orientation = yaw * s.orientation;
    turned.velocity = yaw * s.velocity;
    turned.angular_velocity = yaw * s.angular_velocity;
    strike(body, s);
    strike(body, turned);
    // a single point: rounding, raised by the Newton iteration for the slip's direction
    EXPECT_LT((turned.velocity - yaw * s.velocity).norm(), 1e-11 * 6.0) << i;
    EXPECT_LT((turned.angular_velocity - yaw * s.angular_velocity).norm() * body.bounding_radius_m(),
              1e-11 * 6.0)
        << i;
  }
}

TEST(Impact, SlowerThanTheMicroSpeedDoesNotBounce) {
  const Body ball = sample::ball(0.02, 0.03, sample::ideal(0.9, 0.2));
  for (const double speed : {0.0099, 0.0101}) {
    State s = grounded(ball, Quat::Identity());
    s.velocity.z() = -speed;
    auto points = touching(ball, s, 1e-12);
    resolve_impact(ball, 0.01, points, s);
    EXPECT_NEAR(s.velocity.z(), speed < 0.01 ? 0.0 : 0.9 * speed, 1e-16);
  }
}

}  // namespace
}  // namespace ifa
