#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ifa/rigid/event_engine.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::kinetic;
using sample::lowest;

std::vector<ContactPoint> touching(const Body& body, const State& s, double within_m) {
  std::vector<ContactPoint> points;
  for (const Vec3& vertex : body.principal_vertices()) {
    ContactPoint p;
    p.arm = s.orientation * vertex - body.radius_m() * kUp;
    if (s.position.z() + p.arm.z() <= within_m) points.push_back(p);
  }
  return points;
}

ImpactResult strike(const Body& body, State& s, double within_m = 1e-12) {
  auto points = touching(body, s, within_m);
  EXPECT_FALSE(points.empty());
  return resolve_impact(body, 0.0, points, s);
}

// Rests on the ground by its lowest point.
State grounded(const Body& body, const Quat& orientation) {
  State s;
  s.orientation = orientation;
  s.position.z() = -lowest(body, s);
  return s;
}

// Hard case 9.
TEST(Impact, CubeFallingFlatOnAnEdgeAndOnACornerBouncesStraightUp) {
  const double tilt = std::atan(std::sqrt(2.0));
  const Quat flat = Quat::Identity(), edge(Eigen::AngleAxisd(0.25 * std::numbers::pi, Vec3::UnitX()));
  const Quat corner(Eigen::AngleAxisd(tilt, Vec3(1, -1, 0).normalized()));
  for (const double restitution : {0.0, 0.3, 0.5, 0.9, 1.0})
    for (const double friction : {0.0, 0.3, 1.0}) {
      const Body cube = sample::box({0.02, 0.02, 0.02}, 0.01, sample::ideal(restitution, friction));
      const std::vector<std::pair<Quat, std::size_t>> cases{{flat, 4}, {edge, 2}, {corner, 1}};
      for (const auto& [orientation, count] : cases) {
        State s = grounded(cube, orientation);
        ASSERT_EQ(touching(cube, s, 1e-12).size(), count);
        s.velocity.z() = -2.0;
        const ImpactResult hit = strike(cube, s);
        EXPECT_LT((s.velocity - Vec3(0, 0, 2.0 * restitution)).norm(), 2.0 * 1e-12);
        EXPECT_LT(s.angular_velocity.norm() * 0.01, 2.0 * 1e-12);
        EXPECT_LT((hit.impulse_n_s - Vec3(0, 0, 0.01 * 2.0 * (1.0 + restitution))).norm(), 1e-12 * 0.02);
        EXPECT_LT((hit.position_m - Vec3(0, 0, 0)).norm(), 1e-12 * 0.02);
      }
    }
}

// Hard case 10.
TEST(Impact, RodAtAnAngleWithoutFriction) {
  const double length = 0.3, mass = 0.05, speed = 1.7;
  for (const double restitution : {0.0, 0.4, 1.0})
    for (const double angle : {0.05, 0.5, 1.0, 1.5}) {
      const Body rod = sample::rod(length, 0.002, mass, sample::ideal(restitution, 0.0));
      State s = grounded(rod, Quat(Eigen::AngleAxisd(angle, Vec3::UnitY())));  // the +x end down
      s.velocity.z() = -speed;
      const ImpactResult hit = strike(rod, s);
      const double c = std::cos(angle);
      const double impulse = mass * (1.0 + restitution) * speed / (1.0 + 3.0 * c * c);
      EXPECT_NEAR(hit.impulse_n_s.z(), impulse, 1e-12 * impulse);
      // the end is thrown up: about -y
      const double spin = 6.0 * impulse * c / (mass * length);
      EXPECT_LT((s.angular_velocity - Vec3(0, -spin, 0)).norm(), 1e-12 * spin);
    }
}

Body random_body(RandomStream& random, const Material& material) {
  const double mass = std::pow(10.0, random.uniform(-3.0, 1.0));
  const double size = std::pow(10.0, random.uniform(-3.0, 0.0));
  const double kind = random.uniform();
  if (kind < 0.2) return sample::ball(size, mass, material);
  if (kind < 0.4) return sample::rod(size, 0.02 * size, mass, material);
  return sample::box(size * Vec3(random.uniform(0.01, 1.0), random.uniform(0.1, 1.0), 1.0), mass, material);
}

// Hard case 11. Half of the bodies lie on an edge or a face within a little of flat, where several points
// touch.
TEST(Impact, EnergyNeverGrows) {
  RandomStream random(11, 0);
  double worst = -1.0;
  for (int i = 0; i < 20000; ++i) {
    const Body body = random_body(random, sample::ideal(random.uniform(), random.uniform(0.0, 1.5)));
    const bool several = i % 2;
    Quat orientation = random.rotation();
    if (several)
      orientation =
          Quat(Eigen::AngleAxisd(random.uniform(0.0, 6.0), kUp)) * rotation_exp(1e-3 * random.unit_vector());
    State s = grounded(body, orientation);
    s.velocity = random.uniform(0.0, 3.0) * random.unit_vector() - Vec3(0, 0, 3.0);
    s.angular_velocity = random.uniform(0.0, 20.0) / body.bounding_radius_m() * 0.1 * random.unit_vector();
    const double before = kinetic(body, s);
    const ImpactResult hit = strike(body, s, several ? 2e-3 * body.bounding_radius_m() : 1e-12);
    ASSERT_TRUE(s.velocity.allFinite() && s.angular_velocity.allFinite() && hit.impulse_n_s.allFinite()) << i;
    worst = std::max(worst, kinetic(body, s) / before - 1.0);
    ASSERT_LE(kinetic(body, s), before * (1.0 + 1e-12)) << i;
    EXPECT_GE(hit.impulse_n_s.z(), 0.0);
    EXPECT_LE(hit.impulse_n_s.head<2>().norm(), body.material().friction * hit.impulse_n_s.z() * (1 + 1e-9));
  }
  EXPECT_LE(worst, 1e-12);
}

TEST(Impact, ElasticWithoutFrictionKeepsTheEnergy) {
  RandomStream random(12, 0);
  for (int i = 0; i < 20000; ++i) {
    const Body body = random_body(random, sample::ideal(1.0, 0.0));
    State s = grounded(body, random.rotation());
    s.velocity = random.uniform(0.0, 3.0) * random.unit_vector() - Vec3(0, 0, 3.0);
    s.angular_velocity = random.uniform(0.0, 2.0) / body.bounding_radius_m() * random.unit_vector();
    const double before = kinetic(body, s);
    strike(body, s);
    ASSERT_NEAR(kinetic(body, s), before, 1e-12 * before) << i;
  }
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

// Hard case 15: with mu > 4/3 a sliding rod may jam. Any answer must be finite, leave the ground and not gain
// energy.
TEST(Impact, PainleveRodJams) {
  for (const double friction : {1.4, 2.0, 5.0, 100.0})
    for (int i = 1; i < 60; ++i)
      for (const double slip : {-3.0, 3.0})
        for (const double sink : {-1e-9, -0.01, -1.0}) {
          const Body rod = sample::rod(1.0, 0.001, 1.0, sample::ideal(0.0, friction));
          State s = grounded(rod, Quat(Eigen::AngleAxisd(i * std::numbers::pi / 120.0, Vec3::UnitY())));
          s.velocity = {slip, 0.0, sink};
          const double before = kinetic(rod, s);
          const ImpactResult hit = strike(rod, s);
          ASSERT_TRUE(s.velocity.allFinite() && hit.impulse_n_s.allFinite());
          EXPECT_LE(kinetic(rod, s), before * (1 + 1e-12))
              << friction << " " << i << " " << slip << " " << sink;
          EXPECT_GE((s.velocity + s.angular_velocity.cross(touching(rod, s, 1e-12)[0].arm)).z(), -1e-9);
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
