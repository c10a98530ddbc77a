// Hard cases 12, 13 and 14: sliding, rolling, tipping.
#include <cmath>
#include <numbers>

#include "held.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::kGravity;

// A block that slides flat stops after v^2 / (2 mu g) on its heading. The last step, in which it stops, is
// the error: mu g step^2 / 2 of the way at most.
TEST(HardCase12, SlidingBlockStopsWhereCoulombSays) {
  const double friction = 0.3, speed = 2.0, distance = speed * speed / (2.0 * friction * kGravity);
  const Body block = sample::box({0.1, 0.08, 0.02}, 0.2, sample::ideal(0.0, friction));
  Held way("distance, relative", 3e-3), heading("heading, degrees", 1e-6), turned("yaw, degrees", 1e-6),
      time("time of the stop, s",
           0.01 / (friction * kGravity) + 1e-3);  // rest begins below 0.01 m/s, one step
  for (int i = 0; i < 64; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 64, degree = std::numbers::pi / 180.0;
    const Vec3 along(std::cos(angle), std::sin(angle), 0.0);
    State s;
    s.position.z() = 0.01;
    s.velocity = speed * along;
    const auto run = simulate(block, s, {}, kNever);
    ASSERT_EQ(run.status, RunStatus::rest);
    const State& end = run.nodes.back().state;
    way.see(std::abs(end.position.dot(along) / distance - 1.0), i);
    heading.see(std::abs(std::atan2(end.position.dot(kUp.cross(along)), end.position.dot(along))) / degree,
                i);
    turned.see(sample::angle_between(end.orientation, s.orientation) / degree, i);
    time.see(std::abs(run.rest_s - speed / (friction * kGravity)), i);
  }
}

// A solid cylinder on its side: a capsule rolls as one, both its ends touching.
Body cylinder(double length_m, double radius_m, double mass_kg, const Material& material) {
  Body::Definition d;
  d.vertices_m = {Vec3(0.0, -0.5 * length_m, 0.0), Vec3(0.0, 0.5 * length_m, 0.0)};
  d.radius_m = radius_m;
  const double axial = 0.5 * mass_kg * radius_m * radius_m;
  const double across = 0.5 * axial + mass_kg * length_m * length_m / 12.0;
  d.inertia_kg_m2 = Vec3(across, axial, across).asDiagonal();
  d.mass_kg = mass_kg;
  d.material = material;
  return Body::make(d);
}

// I = c m r^2: slip falls at mu g (1 + 1 / c) from v0, and rolling begins at v0 / (1 + c) after
// v0 / (mu g) c / (1 + c): 5/7 after 2/7 for the ball (c = 2/5), 2/3 after 1/3 for the cylinder (c = 1/2).
TEST(HardCase13, BallAndCylinderBeginToRoll) {
  const double radius = 0.05, friction = 0.2, speed = 3.0;
  struct Roller {
    const char* name;
    Body body;
    double c;
  };
  for (const Roller& roller :
       {Roller{"ball", sample::ball(radius, 0.3, sample::ideal(0.0, friction)), 0.4},
        Roller{"cylinder", cylinder(0.1, radius, 0.3, sample::ideal(0.0, friction)), 0.5}}) {
    const std::string name = std::string(" (") + roller.name + ")";
    Held rolling("rolling speed, relative" + name, 1e-6), slip("slip while rolling, relative" + name, 1e-6),
        time("when rolling begins, s" + name, 1e-3 + 1e-9), way("way, relative" + name, 1e-3);
    for (int i = 0; i < 8; ++i) {
      const Quat yaw(Eigen::AngleAxisd(i, kUp));
      State s;
      s.position.z() = radius;
      s.orientation = yaw;
      s.velocity = yaw * Vec3(speed, 0.0, 0.0);
      const double began = speed / (friction * kGravity) * roller.c / (1.0 + roller.c);
      const auto run = simulate(roller.body, s, {}, 2.0 * began);
      const auto slip_of = [&](const State& now) {
        return (now.velocity + now.angular_velocity.cross(Vec3(0, 0, -radius))).norm() / speed;
      };
      const State& end = run.nodes.back().state;
      rolling.see((end.velocity / speed - yaw * Vec3(1.0 / (1.0 + roller.c), 0.0, 0.0)).norm(), i);
      double first = kNever;
      for (const Node& n : run.nodes) {
        if (first == kNever && slip_of(n.state) < 1e-6) first = n.time_s;
        if (first < kNever) slip.see(slip_of(n.state), i);
      }
      time.see(std::abs(first - began), i);
      const double expected =
          speed * began - 0.5 * friction * kGravity * began * began + speed / (1.0 + roller.c) * began;
      way.see(std::abs(end.position.head<2>().norm() / expected - 1.0), i);
    }
  }
}

SimulationOptions tilted(double tangent) {
  SimulationOptions options;
  const double angle = std::atan(tangent);
  options.gravity_m_s2 = kGravity * Vec3(std::sin(angle), 0.0, -std::cos(angle));
  options.rest_speed_m_s = 0.0;  // without the rule for rest, which takes a slow start for standing still
  return options;
}

bool tips(double width, double height, double tangent) {
  const Body block = sample::box({width, 0.04, height}, 0.05, sample::ideal(0.0, 5.0));
  State s;
  s.position.z() = 0.5 * height;
  EventSimulation simulation(block, tilted(tangent));
  simulation.start(s, 0.0);
  // Beyond the critical angle it falls as e^(rate t), rate^2 about g / h: a ten-thousandth grows to a radian
  // in 1 s.
  for (double until = 0.05; until < 3.0; until += 0.05) {
    while (simulation.advance(until) == EventSimulation::Stop::impact) simulation.resolve();
    if ((simulation.state().orientation.conjugate() * kUp).z() < 0.99) return true;
  }
  return false;
}

// A block that cannot slide tips where its mass centre leaves its base, at tan a = w / h: found by halving.
TEST(HardCase14, BlockTipsBeyondItsBase) {
  Held critical("tangent of the critical angle, relative", 1e-4);
  const double height = 0.05;
  for (const double width : {0.01, 0.02, 0.03, 0.05})
    for (const double side : {-1.0, 1.0}) {
      double stands = 0.9, falls = 1.1;
      const double tangent = side * width / height;
      EXPECT_FALSE(tips(width, height, stands * tangent)) << width;
      EXPECT_TRUE(tips(width, height, falls * tangent)) << width;
      while (falls - stands > 1e-6) {
        const double share = 0.5 * (stands + falls);
        (tips(width, height, share * tangent) ? falls : stands) = share;
      }
      critical.see(std::abs(0.5 * (stands + falls) - 1.0), width, side, stands);
    }
}

// A low block slides before it tips: from tan a = mu on, with g (sin a - mu cos a). Below that it stays: in a
// second the solver's 1e-8 m/s in each of its thousand steps would move it by 5e-6 m at most.
TEST(HardCase14, LowBlockSlidesInstead) {
  Held stays("creep in a second below the angle of friction, m", 5e-6),
      slides("acceleration beyond it, of g", 1e-4);
  for (const double friction : {0.1, 0.4, 0.8})
    for (const double share : {0.9, 0.9999, 1.0001, 1.1}) {
      const Body block = sample::box({0.05, 0.04, 0.02}, 0.05, sample::ideal(0.0, friction));
      State s;
      s.position.z() = 0.01;
      const double tangent = share * friction, angle = std::atan(tangent);
      const double way = simulate(block, s, tilted(tangent), 1.0).nodes.back().state.position.x();
      if (share < 1.0) {
        stays.see(std::abs(way), friction, share);
      } else {
        slides.see(std::abs(2.0 * way / kGravity - (std::sin(angle) - friction * std::cos(angle))), friction,
                   share);
        EXPECT_GT(way, 1e-5);
      }
    }
}

}  // namespace
}  // namespace ifa
