// Hard case 16: circular edges. A disk rolls, precesses and lands as a disk, not as a polygon.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "held.hpp"
#include "ifa/rigid/flight.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::kGravity;

constexpr double kRadius = 0.0375, kMass = 0.44;  // of the toy "Euler's disk"

// Uniform and thin, its axis z.
Body thin_disk(const Material& material) {
  Body::Definition d;
  d.rings_m = {{Vec3::Zero(), kUp, kRadius}};
  d.mass_kg = kMass;
  d.inertia_kg_m2 = (kMass * kRadius * kRadius * Vec3(0.25, 0.25, 0.5)).asDiagonal();
  d.material = material;
  return Body::make(d);
}

// Steady rolling about a centre of mass at rest: the disk, inclined by `tilt`, turns about its steepest
// diameter, which precesses at W with W^2 sin(tilt) = 4 g / R.
State steady(double tilt, double& precession) {
  precession = std::sqrt(4.0 * kGravity / (kRadius * std::sin(tilt)));
  State s;
  s.orientation = Quat(Eigen::AngleAxisd(tilt, Vec3::UnitY()));
  s.position.z() = kRadius * std::sin(tilt);
  s.angular_velocity = -precession * std::sin(tilt) * (s.orientation * Vec3::UnitX());
  return s;
}

TEST(HardCase16, SteadyPrecession) {
  Held rate("precession over 5 turns, of sqrt(4 g / (R sin tilt))", 0.01);
  Held lean("tilt, of it", 0.01);
  Held energy("energy, of it", 0.01);
  const Body disk = thin_disk(sample::ideal(0.0, 1e3));
  for (const double tilt : {1.2, 0.8, 0.4, 0.1, 0.03, 0.01, 0.003}) {
    double precession = 0.0;
    const State start = steady(tilt, precession);
    const double turns = 5.0;
    const ifa::Run run = simulate(disk, start, {}, turns * 2.0 * std::numbers::pi / precession);
    EXPECT_EQ(run.hits.size(), 0u) << tilt;
    double turned = 0.0, last = 0.0;
    for (const Node& node : run.nodes) {
      EXPECT_EQ(node.phase, Phase::contact) << tilt << " " << node.time_s;
      const Vec3 axis = node.state.orientation * kUp;
      const double heading = std::atan2(axis.y(), axis.x());
      turned += std::remainder(heading - last, 2.0 * std::numbers::pi);
      last = heading;
      lean.see(std::abs(std::atan2(axis.head<2>().norm(), axis.z()) / tilt - 1.0), tilt, node.time_s);
      energy.see(std::abs(sample::mechanical(disk, node.state) / sample::mechanical(disk, start) - 1.0),
                 tilt);
    }
    rate.see(std::abs(turned / (2.0 * std::numbers::pi * turns) - 1.0), tilt);
  }
}

// The same with 64 corners on each ring.
Body cornered_coin(const Material& material) {
  Body::Definition d = sample::coin(material).definition();
  d.vertices_m = ring_points(d.rings_m, 64);
  d.rings_m.clear();
  return Body::make(d);
}

State upright(const Body& body, double speed) {
  State s;
  s.orientation = Quat(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX()));
  s.position.z() = -sample::lowest(body, s);
  s.velocity.x() = speed;
  s.angular_velocity.y() = speed / s.position.z();
  return s;
}

TEST(HardCase16, CoinRollsOnItsEdgeWithoutRattle) {
  constexpr double kSpeed = 1.0;
  const Material no_rolling_friction = sample::ideal(0.45, 0.3);
  const auto roll = [&](const Body& body) {
    return simulate(body, upright(body, kSpeed), {}, 1.0);  // a metre
  };
  const Body round = sample::coin(no_rolling_friction), cornered = cornered_coin(no_rolling_friction);
  const ifa::Run run = roll(round);
  EXPECT_EQ(run.hits.size(), 0u);
  // Nothing takes energy. The tolerance of the contact problem, 1e-8 of g h = 1e-10 m/s a step, of one sign
  // in all of 1600 steps, would come to 1.6e-7 of the speed.
  Held speed("speed of a coin on its edge after 1 m, of it", 2e-7);
  speed.see(std::abs(run.nodes.back().state.velocity.x() / kSpeed - 1.0));
  Held way("its way, of it", 2e-7);
  way.see(std::abs(run.nodes.back().state.position.x() / kSpeed - 1.0));
  // Falling from corner to corner, the polygon hits the ground 64 times a turn, unless it flies over some.
  const ifa::Run rattle = roll(cornered);
  EXPECT_GT(rattle.hits.size(), 50u);
  EXPECT_LT(rattle.nodes.back().state.velocity.norm(), 0.9 * kSpeed);
}

// The lowest point of all rings by looking at 512 points and refining the best by a parabola through three:
// the height around a ring is a cosine, so that is good to (2 pi / 512)^4 / 100 of the radius.
double lowest_by_search(const Body& body, const State& s) {
  constexpr int kPoints = 512;
  double least = 1e300;
  for (const Ring& ring : body.principal_rings()) {
    std::vector<double> heights;
    for (const Vec3& p : ring_points({ring}, kPoints)) heights.push_back((s.orientation * p).z());
    const int i = static_cast<int>(std::min_element(heights.begin(), heights.end()) - heights.begin());
    const double before = heights[(i + kPoints - 1) % kPoints], after = heights[(i + 1) % kPoints];
    const double bend = before + after - 2.0 * heights[i];
    least =
        std::min(least, heights[i] - (bend > 0.0 ? 0.125 * (after - before) * (after - before) / bend : 0.0));
  }
  return least + s.position.z() - body.radius_m();
}

TEST(HardCase16, CoinRocksFromSideToSide) {
  // Tilted and released with a little spin, it nearly lands flat, rolls half round within a millisecond and
  // rises on the other side. Without friction, or without slip, nothing takes energy; and nothing strikes.
  constexpr double kLength = 0.5;
  // The lowest point runs by 0.2 rad a step, of which the velocities' second order is 0.2^2 / 4.
  Held step("energy a coin that rocks loses in a step, of it", 0.01);
  for (const double friction : {0.0, 5.0}) {
    const Body body = sample::coin(sample::ideal(0.45, friction));
    for (const double tilt : {0.1, 0.2, 0.3})
      for (const double spin : {0.3, 1.0, 3.0}) {
        State s;
        s.orientation = Quat(Eigen::AngleAxisd(tilt, Vec3::UnitX()));
        s.position.z() = -sample::lowest(body, s);
        // about the lowest point, which is at rest
        const Ring& ring = body.principal_rings()[1];
        const Vec3 lowest =
            s.orientation * (ring.centre_m - ring.radius_m * Vec3::UnitY()) - body.radius_m() * kUp;
        s.angular_velocity.y() = spin;
        s.velocity = -s.angular_velocity.cross(lowest);
        const ifa::Run run = simulate(body, s, {}, kLength);
        EXPECT_EQ(run.hits.size(), 0u) << tilt << " " << spin;
        EXPECT_EQ(run.status, RunStatus::time_limit) << tilt << " " << spin;
        const double flat = body.mass_kg() * kGravity * 1.1e-3;  // what it has when it lies
        for (std::size_t i = 0; i + 1 < run.nodes.size(); ++i) {
          const double energy = sample::mechanical(body, run.nodes[i].state) - flat;
          const double next = sample::mechanical(body, run.nodes[i + 1].state) - flat;
          step.see(1.0 - next / energy, tilt, spin, run.nodes[i].time_s);
        }
      }
  }
}

TEST(HardCase16, VerticalFallOfATiltedDisk) {
  Held time("first contact against sqrt(2 h / g), s", 1e-13);
  for (const Body& body : {thin_disk({}), sample::coin({})}) {
    const double radius = body.principal_rings()[0].radius_m, half = body.principal_rings()[0].centre_m.z();
    Flight flight(body);
    for (int i = 0; i <= 32; ++i) {
      const double tilt = std::numbers::pi * i / 64.0, height = 0.1 + 0.01 * i;
      State s;
      s.orientation = Quat(Eigen::AngleAxisd(0.3 * i, kUp) * Eigen::AngleAxisd(tilt, Vec3::UnitX()));
      const double below = radius * std::sin(tilt) + half * std::cos(tilt) + body.radius_m();
      s.position.z() = height + below;
      flight.start(s, sample::downwards());
      time.see(std::abs(flight.next_contact(kNever) - std::sqrt(2.0 * height / kGravity)), tilt);
    }
  }
}

TEST(HardCase16, FirstContactOfASpinningDisk) {
  RandomStream random(216, 0);
  Held at("height at the first contact, of the size", 1e-9);
  Held before("depth before it, of the size", 1e-9);
  const Body bodies[] = {thin_disk({}), sample::coin({})};
  for (int i = 0; i < 200; ++i) {
    const Body& body = bodies[i % 2];
    // from above the ball about the centre, with any spin, so that the disk turns several times
    State s;
    s.orientation = random.rotation();
    s.position.z() = body.bounding_radius_m() * (1.0 + std::pow(10.0, random.uniform(-3.0, 1.0)));
    s.velocity = 2.0 * random.unit_vector();
    s.angular_velocity = std::pow(10.0, random.uniform(-1.0, 2.5)) * random.unit_vector();
    Flight flight(body);
    flight.start(s, sample::downwards());
    const double contact = flight.next_contact(kNever);
    ASSERT_LT(contact, kNever);
    at.see(std::abs(lowest_by_search(body, flight.at(contact))) / body.bounding_radius_m(), i);
    for (int k = 0; k < 100; ++k)
      before.see(-lowest_by_search(body, flight.at(contact * k / 100.0)) / body.bounding_radius_m(), i, k);
  }
}

// Thrown coins in the sense of a batch: from a touching pose, with speeds and spins of a hand's throw.
constexpr double kFastest = 3.0, kFastestSpin = 60.0;

std::vector<State> throws(const Body& body, int n) {
  RandomStream random(217, 0);
  std::vector<State> states;
  for (int i = 0; i < n; ++i) {
    const double clearance = 0.05 * random.uniform();
    states.push_back(sample::random_state(body, random, clearance, kFastest, kFastestSpin));
  }
  return states;
}

TEST(HardCase16, ThrownCoinsComeToRest) {
  const int n = trials(1000, 0.1);
  // Rounding of the poses (1e-16 of the size) against 1e-4 of the first energy near rest, and in flight the
  // rounding of its closed form.
  Held gain("energy gained from node to node, of the first", 1e-11);
  Held depth("depth at a node, of the size", 1e-12);
  Held rest("rest after, of the time that rolling friction needs", 1.0);
  for (const Body& body : {sample::coin({0.45, 0.2, 5e-5, 5e-5}), thin_disk({0.45, 0.2, 5e-4, 5e-5})}) {
    // A disk that rolls away with speed and spin in one loses 2 c g / (3 R) m/s each second.
    const double radius = body.bounding_radius_m();
    const double longest =
        (kFastest + kFastestSpin * radius) * 1.5 * radius / (body.material().rolling_friction_m * kGravity);
    const std::vector<State> starts = throws(body, n);
    for (int i = 0; i < n; ++i) {
      const ifa::Run run = simulate(body, starts[i], {}, longest);
      ASSERT_EQ(run.status, RunStatus::rest) << i;
      rest.see(run.rest_s / longest, i);
      const double first = sample::mechanical(body, starts[i]);
      double last = first;
      for (const Node& node : run.nodes) {
        const double energy = sample::mechanical(body, node.state);
        gain.see((energy - last) / first, i, node.time_s);
        last = energy;
        depth.see(-sample::lowest(body, node.state) / body.bounding_radius_m(), i, node.time_s);
      }
    }
  }
}

TEST(HardCase16, YawTurnsTheMotion) {
  // Rounding alone differs, which a throw's impacts multiply: a few of them, then the place must agree to
  // 1e-6.
  Held place("place at the third impact, m", 1e-6);
  const Body body = sample::coin({0.45, 0.2, 5e-5, 5e-5});
  for (const State& start : throws(body, 20)) {
    const ifa::Run plain = simulate(body, start, {}, 0.5);
    if (plain.hits.size() < 3) continue;
    for (const double yaw : {0.5, 2.0, 3.0}) {
      const Quat turn(Eigen::AngleAxisd(yaw, kUp));
      const State turned{turn * start.position, turn * start.orientation, turn * start.velocity,
                         turn * start.angular_velocity};
      const ifa::Run run = simulate(body, turned, {}, 0.5);
      ASSERT_GE(run.hits.size(), 3u);
      place.see((turn * plain.hits[2].position_m - run.hits[2].position_m).norm(), yaw);
    }
  }
}

}  // namespace
}  // namespace ifa
