#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ifa/rigid/event_engine.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::kGravity;
using sample::lowest;
using sample::mechanical;

bool same_bits(const State& a, const State& b) {
  const auto equal = [](const auto& x, const auto& y) {
    return std::memcmp(x.data(), y.data(), sizeof(double) * static_cast<std::size_t>(x.size())) == 0;
  };
  return equal(a.position, b.position) && equal(a.orientation.coeffs(), b.orientation.coeffs()) &&
         equal(a.velocity, b.velocity) && equal(a.angular_velocity, b.angular_velocity);
}

void expect_same_bits(const ifa::Run& a, const ifa::Run& b) {
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    ASSERT_EQ(a.nodes[i].time_s, b.nodes[i].time_s);
    ASSERT_TRUE(same_bits(a.nodes[i].state, b.nodes[i].state)) << "node " << i;
  }
  ASSERT_EQ(a.hits.size(), b.hits.size());
}

TEST(Engine, RollingFrictionStopsABall) {
  const double radius = 0.02, lever = 1e-4, speed = 0.5;
  const Body ball = sample::ball(radius, 0.03, {0.5, 0.5, lever, lever});
  State s;
  s.position.z() = radius;
  s.velocity.x() = speed;
  s.angular_velocity.y() = speed / radius;
  const auto run = simulate(ball, s, {}, kNever);
  ASSERT_EQ(run.status, RunStatus::rest);
  // The torque m g b about the contact point slows 7/5 m r^2 w: a = 5/7 g b / r.
  const double slowing = 5.0 / 7.0 * kGravity * lever / radius;
  // it counts as rest below 0.01 m/s over hull points: v + w r is 2 v
  EXPECT_NEAR(run.nodes.back().state.position.x(), speed * speed / (2.0 * slowing),
              0.003 * speed * speed / slowing);
}

struct Thrown {
  const char* name;
  Body body;
};

std::vector<Thrown> thrown_bodies() {
  return {{"cube", sample::box({0.016, 0.016, 0.016}, 0.005)},
          {"eraser", sample::box({0.05, 0.02, 0.012}, 0.02, {0.7, 0.7, 5e-5, 5e-5})},
          {"card", sample::box({0.085, 0.054, 0.0008}, 0.005, {0.35, 0.3, 5e-5, 5e-5})},
          {"ball", sample::ball(0.02, 0.03, {0.6, 0.3, 5e-4, 5e-5})},
          {"rod", sample::rod(0.15, 0.004, 0.02)}};
}

// The laws that hold for any run: it ends at rest on its side, never below the ground, never gaining energy.
// Impacts are exact; in sustained contact poses are corrected to 1e-8 of the size, which lifts the centre of
// mass by as much, and landing points are found to 1e-6 of it.
TEST(Engine, ThrownBodiesComeToRestLawfully) {
  RandomStream random(21, 0);
  constexpr double kDeepest = 1e-12, kGain = 2e-7;
  for (const auto& [name, body] : thrown_bodies()) {
    const double size = body.bounding_radius_m();
    for (int i = 0; i < 12; ++i) {
      const State s = sample::random_state(body, random, 0.15, 2.0, 20.0);
      const auto run = simulate(body, s, {}, 60.0);
      ASSERT_EQ(run.status, RunStatus::rest) << name << " " << i;
      double before = mechanical(body, run.nodes.front().state), time = 0.0;
      for (const Node& n : run.nodes) {
        ASSERT_GE(n.time_s, time);
        ASSERT_NEAR(n.state.orientation.norm(), 1.0, 1e-14);
        ASSERT_GT(lowest(body, n.state), -kDeepest * size) << name << " " << i << " at " << n.time_s;
        const double now = mechanical(body, n.state);
        ASSERT_LE(now, before + kGain * mechanical(body, s)) << name << " " << i << " at " << n.time_s;
        before = now;
        time = n.time_s;
      }
      const State& end = run.nodes.back().state;
      EXPECT_EQ(run.nodes.back().phase, Phase::rest);
      EXPECT_LE(run.rest_s, run.nodes.back().time_s);
      EXPECT_NEAR(lowest(body, end), 0.0, 1e-8 * size);
      if (body.vertices().size() == 8) {  // flat on a face: one axis is vertical, or it would fall over
        const double upright = (end.orientation.conjugate() * kUp).cwiseAbs().maxCoeff();
        EXPECT_GT(upright, 1.0 - 1e-9) << name << " " << i;
      }
    }
  }
}

TEST(Engine, HitsAreTheNodesWhereVelocitiesJump) {
  RandomStream random(22, 0);
  for (const auto& [name, body] : thrown_bodies()) {
    const auto run = simulate(body, sample::random_state(body, random, 0.2, 2.0, 20.0), {}, 60.0);
    for (const Hit& hit : run.hits) {
      const auto after = std::find_if(run.nodes.rbegin(), run.nodes.rend(),
                                      [&](const Node& n) { return n.time_s == hit.time_s; });
      const auto before = std::find_if(run.nodes.begin(), run.nodes.end(),
                                       [&](const Node& n) { return n.time_s == hit.time_s; });
      ASSERT_TRUE(after != run.nodes.rend()) << name;
      ASSERT_LT(&*before, &*after) << name << " at " << hit.time_s;
      const Vec3 change = body.mass_kg() * (after->state.velocity - before->state.velocity);
      EXPECT_LT((change - hit.impulse_n_s).norm(), 1e-9 * body.mass_kg() * (1.0 + hit.approach_speed_m_s))
          << name;
      EXPECT_LT((after->state.position - before->state.position).norm(), 1e-15);
      EXPECT_NEAR(hit.position_m.z(), 0.0, 1e-6 * body.bounding_radius_m());
    }
  }
}

TEST(Engine, StartForgetsWhatWentBefore) {
  RandomStream random(24, 0);
  const Body cube = sample::box({0.016, 0.016, 0.016}, 0.005);
  const State first = sample::random_state(cube, random, 0.1, 2.0, 20.0);
  const State second = sample::random_state(cube, random, 0.1, 2.0, 20.0);
  const auto expected = simulate(cube, first, {}, kNever);
  EventSimulation simulation(cube, {});
  for (int round = 0; round < 2; ++round) {
    ifa::Run run;
    simulation.start(second, 0.0);
    for (int i = 0; i < 4 && simulation.advance(1.0) == EventSimulation::Stop::impact; ++i)
      simulation.resolve();
    simulation.start(first, 0.0, &run.nodes);
    while (simulation.advance(kNever) == EventSimulation::Stop::impact)
      run.hits.push_back(simulation.resolve());
    expect_same_bits(run, expected);
  }
}

TEST(Engine, TimeShiftsAreExactInIntervals) {
  const Body cube = sample::box({0.016, 0.016, 0.016}, 0.005);
  RandomStream random(25, 0);
  const State s = sample::random_state(cube, random, 0.1, 2.0, 20.0);
  EventSimulation a(cube, {}), b(cube, {});
  a.start(s, 0.0);
  b.start(s, 64.0);
  ASSERT_EQ(a.advance(kNever), EventSimulation::Stop::impact);
  ASSERT_EQ(b.advance(kNever), EventSimulation::Stop::impact);
  EXPECT_NEAR(b.time_s() - 64.0, a.time_s(), 2e-14);  // rounding of 64.x
  EXPECT_TRUE(same_bits(a.state(), b.state()));
}

TEST(Engine, StopsAtTheImpactLimit) {
  const Body ball = sample::ball(0.02, 0.03, sample::ideal(1.0, 0.0));
  State s;
  s.position.z() = 0.52;
  SimulationOptions options;
  options.max_impacts = 25;
  const auto run = simulate(ball, s, options, kNever);
  EXPECT_EQ(run.status, RunStatus::impact_limit);
  EXPECT_EQ(run.hits.size(), 25u);
  // e = 1 without friction: as fast as ever, exact to rounding that adds up
  EXPECT_NEAR(run.hits.back().approach_speed_m_s, std::sqrt(2.0 * kGravity * 0.5), 1e-12);
}

TEST(Engine, StopsAtTheTimeLimit) {
  const Body ball = sample::ball(0.02, 0.03, sample::ideal(0.9, 0.3));
  State s;
  s.position.z() = 0.52;
  for (const double until : {0.0, 0.1, 0.5, 1.0}) {
    const auto run = simulate(ball, s, {}, until);
    EXPECT_EQ(run.status, RunStatus::time_limit);
    EXPECT_EQ(run.nodes.back().time_s, until);
  }
}

TEST(Engine, CancelsWithinARun) {
  const Body ball = sample::ball(0.02, 0.03);
  State s;
  s.position.z() = 0.52;
  Progress progress;
  progress.cancel();
  EXPECT_THROW(simulate(ball, s, {}, kNever, &progress), Cancelled);
}

TEST(Engine, TouchingSeparatingBodyFlies) {
  const Body cube = sample::box({0.016, 0.016, 0.016}, 0.005);
  State s;
  s.position.z() = 0.008;
  s.velocity.z() = 1.0;
  EventSimulation simulation(cube, {});
  simulation.start(s, 0.0);
  EXPECT_FALSE(simulation.in_contact());
  EXPECT_NEAR(simulation.separation_speed(), 1.0, 1e-15);
  ASSERT_EQ(simulation.advance(kNever), EventSimulation::Stop::impact);
  EXPECT_NEAR(simulation.time_s(), 2.0 / kGravity, 1e-12);
  EXPECT_NEAR(simulation.approach_speed(), 1.0, 1e-12);
}

// A coin's rim lands point after point: settling must not cut it into steps without end.
TEST(Engine, CoinComesToRest) {
  RandomStream random(29, 0);
  Body::Definition d;
  const double radius = 0.0125;
  for (int i = 0; i < 40; ++i)
    for (const double side : {-1.0, 1.0})
      d.vertices_m.push_back({radius * std::cos(0.05 * std::numbers::pi * i),
                              radius * std::sin(0.05 * std::numbers::pi * i), side * 4e-4});
  d.mass_kg = 0.003;
  const double across = 0.25 * d.mass_kg * radius * radius;  // a thin disc
  d.inertia_kg_m2 = Vec3(across, across, 2.0 * across).asDiagonal();
  const Body coin = Body::make(d);
  SimulationOptions options;
  options.max_impacts = 10000;
  for (int i = 0; i < 5; ++i) {
    const auto run = simulate(coin, sample::random_state(coin, random, 0.03, 0.3, 20.0), options, 30.0);
    EXPECT_EQ(run.status, RunStatus::rest) << i << ": " << run.hits.size() << " impacts";
    EXPECT_GT(std::abs((run.nodes.back().state.orientation.conjugate() * kUp).z()), 1.0 - 1e-9);
  }
}

}  // namespace
}  // namespace ifa
