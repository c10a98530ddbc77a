#include "ifa/motion/motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ifa/base/error.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

// A box whose mesh axes are not its principal ones, so that a mix-up of axes shows.
Body turned_box() {
  Body::Definition d = sample::box({0.03, 0.02, 0.012}, 0.02).definition();
  const Mat3 turn = rotation_exp({0.4, -0.7, 1.1}).toRotationMatrix();
  for (Vec3& v : d.vertices_m) v = turn * v;
  d.inertia_kg_m2 = turn * d.inertia_kg_m2 * turn.transpose();
  return Body::make(d);
}

struct Case {
  Body body = turned_box();
  ifa::Run run;

  Case() {
    RandomStream random(31, 0);
    run = simulate(body, sample::random_state(body, random, 0.2, 1.0, 20.0), {}, kNever);
  }
  Motion motion(const TimeMap& time = {}) const {
    return {body, sample::downwards(), run.nodes, run.hits, time};
  }
};

// From hit to hit, slower and faster in turn.
TimeMap retimed(const Case& c) {
  TimeMap map;
  double motion = 0.5;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i) motion += (c.run.hits[i].time_s - c.run.hits[i - 1].time_s) * (i % 2 ? 1.2 : 0.85);
    map.simulated_s.push_back(c.run.hits[i].time_s);
    map.motion_s.push_back(motion);
  }
  return map;
}

// Metres and radians; the sign of a quaternion does not count.
double difference(const State& a, const State& b) {
  return (a.position - b.position).norm() + sample::angle_between(a.orientation, b.orientation);
}

TEST(Motion, NeedsNodes) {
  EXPECT_THROW(Motion(turned_box(), sample::downwards(), {}, {}, {}), ArgumentError);
}

TEST(Motion, GoesThroughItsNodesOnBothSidesOfImpacts) {
  const Case c;
  const Motion motion = c.motion();
  ASSERT_GT(c.run.hits.size(), 3u);
  for (std::size_t i = 0; i + 1 < c.run.nodes.size(); ++i) {
    const Node& node = c.run.nodes[i];
    const State wanted = to_body(c.body, node.state);
    // The first of two nodes at one time is the side before.
    const Side side = c.run.nodes[i + 1].time_s == node.time_s ? Side::before : Side::after;
    const State got = motion.sample({node.time_s}, side)[0];
    EXPECT_LT(difference(got, wanted), 1e-14) << i;
    EXPECT_LT((got.velocity - wanted.velocity).norm(), 1e-14) << i;
    EXPECT_LT((got.angular_velocity - wanted.angular_velocity).norm(), 1e-13) << i;
  }
}

TEST(Motion, FlightBetweenNodesIsExact) {
  const Case c;
  const Motion motion = c.motion();
  Flight flight(c.body);
  int flights = 0;
  for (std::size_t i = 0; i + 1 < c.run.nodes.size(); ++i) {
    const Node &a = c.run.nodes[i], &b = c.run.nodes[i + 1];
    if (a.phase != Phase::flight || b.time_s - a.time_s < 1e-6) continue;
    flight.start(a.state, sample::downwards());
    for (const double u : {0.1, 0.5, 0.9}) {
      const double t = a.time_s + u * (b.time_s - a.time_s);
      const State wanted = to_body(c.body, flight.at(t - a.time_s)), got = motion.sample({t})[0];
      EXPECT_LT(difference(got, wanted), 1e-14);
      EXPECT_LT((got.velocity - wanted.velocity).norm(), 1e-14);
    }
    ++flights;
  }
  EXPECT_GE(flights, 3);
}

// In sustained contact poses are interpolated: continuous, and moving as the sampled velocity says. Over a
// step of 1 ms with at most 1000 rad/s^2 the two orientations' rates differ by 1 rad/s.
TEST(Motion, ContactBetweenNodesIsContinuous) {
  const Case c;
  const Motion motion = c.motion();
  int steps = 0;
  for (std::size_t i = 0; i + 1 < c.run.nodes.size(); ++i) {
    const Node &a = c.run.nodes[i], &b = c.run.nodes[i + 1];
    if (a.phase != Phase::contact || b.time_s - a.time_s < 1e-5) continue;
    const double h = 1e-9;
    const auto near_a = motion.sample({a.time_s, a.time_s + h}),
               near_b = motion.sample({b.time_s - h, b.time_s}, Side::before);
    EXPECT_LT((near_a[1].position - near_a[0].position).norm(), 10.0 * h);
    EXPECT_LT((near_b[1].position - near_b[0].position).norm(), 10.0 * h);
    EXPECT_LT(difference(near_a[1], near_a[0]), 1000.0 * h);
    EXPECT_LT(difference(near_b[1], near_b[0]), 1000.0 * h);
    const double t = 0.5 * (a.time_s + b.time_s), d = 1e-6;
    const auto three = motion.sample({t - d, t, t + d});
    EXPECT_LT(((three[2].position - three[0].position) / (2 * d) - three[1].velocity).norm(), 1e-5);
    ++steps;
  }
  EXPECT_GT(steps, 10);
}

TEST(Motion, ContactStepsEndWithTheVelocityTheyLeadTo) {
  const Body body = sample::ball(0.02, 0.03);
  constexpr double kLength = 2e-3, kClose = 1e-7;
  const auto step = [&](const Vec3& way, const Vec3& v0, const Vec3& v1) {
    State a, b;
    a.position.z() = 0.02;
    a.velocity = v0;
    b.position = a.position + way;
    b.velocity = v1;
    return Motion(body, sample::downwards(), {{0.0, a, Phase::contact}, {kLength, b, Phase::contact}}, {},
                  {});
  };
  const auto speed = [&](const Motion& motion, double from) {
    const auto s = motion.sample({from, from + kClose}, Side::before);
    return Vec3((s[1].position - s[0].position) / kClose);
  };
  // By the mean velocity, and 5 um off it, towards either end's: an impact that follows is as fast as the
  // node says.
  const Vec3 v0{0.10, 0.0, 0.007}, v1{0.11, 0.0, -0.01};
  for (const double off : {0.0, -5e-6, 5e-6}) {
    const Motion motion = step(kLength * 0.5 * (v0 + v1) + Vec3(0, 0, off), v0, v1);
    // within a cubic's curvature of 6 off / length^2 and the change of velocity over the length
    EXPECT_LT((speed(motion, 0.0) - v0).norm(), 20.0 * kClose);
    EXPECT_LT((speed(motion, kLength - kClose) - v1).norm(), 20.0 * kClose);
  }
  // What settles moves by the velocity at the end all the way, and so not below the ground.
  const Motion settles = step(Vec3(kLength * 0.01, 0, 0), {0.01, 0, -0.01}, {0.01, 0, 0});
  for (const double t : {0.0, 0.3 * kLength, kLength - kClose})
    EXPECT_LT((speed(settles, t) - Vec3(0.01, 0, 0)).norm(), 1e-8);  // rounding of 0.02 over kClose
}

TEST(Motion, IsHeldStillOutside) {
  const Case c;
  const Motion motion = c.motion();
  const State first = motion.sample({motion.start_s()})[0], last = motion.sample({motion.end_s()})[0];
  for (const Side side : {Side::before, Side::after}) {
    const auto outside = motion.sample({motion.start_s() - 3.0, motion.end_s() + 3.0}, side);
    EXPECT_EQ(outside[0].position, first.position);
    EXPECT_EQ(outside[1].position, last.position);
    for (const State& s : outside) {
      EXPECT_EQ(s.velocity, Vec3(0, 0, 0));
      EXPECT_EQ(s.angular_velocity, Vec3(0, 0, 0));
    }
  }
}

TEST(Motion, ASampleDoesNotDependOnTheOthers) {
  const Case c;
  const Motion motion = c.motion(retimed(c));
  std::vector<double> times;
  for (int i = 0; i <= 500; ++i)
    times.push_back(motion.start_s() + (motion.end_s() - motion.start_s()) * i / 500.0);
  const auto forward = motion.sample(times);
  std::reverse(times.begin(), times.end());
  const auto backward = motion.sample(times);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const State &a = forward[i], &b = backward[times.size() - 1 - i],
                alone = motion.sample({times[times.size() - 1 - i]})[0];
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.position, alone.position);
    // up to the sign, which follows the neighbours
    EXPECT_EQ(a.orientation.toRotationMatrix(), b.orientation.toRotationMatrix());
    EXPECT_EQ(a.velocity, alone.velocity);
  }
}

TEST(Motion, SignOfTheQuaternionFollowsItsPredecessor) {
  const Body box = sample::box({0.03, 0.02, 0.012}, 0.02);
  State s;
  s.position.z() = 10.0;
  s.angular_velocity = {0.0, 0.0, 20.0};
  Flight flight(box);
  flight.start(s, sample::downwards());
  const Motion motion(box, sample::downwards(),
                      {{0.0, s, Phase::flight}, {1.2, flight.at(1.2), Phase::flight}}, {}, {});
  std::vector<double> times;
  for (int i = 0; i <= 120; ++i) times.push_back(0.01 * i);
  const auto states = motion.sample(times);
  double least_w = 1.0;
  for (std::size_t i = 1; i < states.size(); ++i) {
    EXPECT_GT(states[i].orientation.dot(states[i - 1].orientation), 0.0);
    least_w = std::min(least_w, states[i].orientation.w());
  }
  EXPECT_LT(least_w, -0.99);  // a whole turn: w is not forced to be positive
}

TEST(TimeMap, EachWayUndoesTheOther) {
  const TimeMap map{{1.0, 1.4, 2.0}, {0.7, 1.2, 1.6}};
  for (double t = -1.0; t < 4.0; t += 0.0137) {
    EXPECT_NEAR(map.to_simulated(map.to_motion(t)), t, 1e-15 * 8);
    EXPECT_NEAR(map.to_motion(map.to_simulated(t)), t, 1e-15 * 8);
  }
  for (std::size_t i = 0; i < 3; ++i) {  // marks are met to the bit
    EXPECT_EQ(map.to_motion(map.simulated_s[i]), map.motion_s[i]);
    EXPECT_EQ(map.to_simulated(map.motion_s[i]), map.simulated_s[i]);
  }
  EXPECT_EQ(TimeMap{}.to_motion(1.25), 1.25);
  EXPECT_EQ(TimeMap{}.rate(1.25, true), 1.0);
  const TimeMap one{{1.0}, {3.0}};
  EXPECT_EQ(one.to_motion(1.5), 3.5);
  EXPECT_EQ(one.rate(3.0, true), 1.0);
}

TEST(TimeMap, RateIsTheSlopeOnTheAskedSide) {
  const TimeMap map{{1.0, 1.5, 2.0}, {2.0, 3.0, 3.25}};
  EXPECT_EQ(map.rate(2.5, true), 0.5);
  EXPECT_EQ(map.rate(3.1, false), 2.0);
  EXPECT_EQ(map.rate(3.0, false), 0.5);
  EXPECT_EQ(map.rate(3.0, true), 2.0);
  EXPECT_EQ(map.rate(2.0, false), 1.0);
  EXPECT_EQ(map.rate(2.0, true), 0.5);
  EXPECT_EQ(map.rate(3.25, true), 1.0);
  EXPECT_EQ(map.rate(9.0, true), 1.0);
}

// What is seen: velocity is the change of the shown position, whatever the retiming.
TEST(Motion, RetimingScalesVelocitiesWithTheShownTime) {
  const Case c;
  const Motion motion = c.motion(retimed(c));
  int compared = 0;
  for (std::size_t i = 0; i + 1 < 4; ++i) {
    const double a = motion.time().motion_s[i], b = motion.time().motion_s[i + 1];
    if (b - a < 0.01) continue;
    const double t = 0.5 * (a + b), h = 1e-5;
    const auto s = motion.sample({t - h, t, t + h});
    // differences of second order: g h^2 / 6 at most, and rounding of 1e-16 / h
    EXPECT_LT(((s[2].position - s[0].position) / (2 * h) - s[1].velocity).norm(), 1e-8);
    const Quat change = s[2].orientation * s[0].orientation.conjugate();
    EXPECT_LT((change.vec() / h * (change.w() < 0 ? -1 : 1) - s[1].angular_velocity).norm(), 1e-4);
    // and slower by the ratio than simulated
    const State simulated = c.motion().sample({motion.time().to_simulated(t)})[0];
    const double ratio = i % 2 ? 0.85 : 1.2;
    EXPECT_LT((s[1].velocity * ratio - simulated.velocity).norm(), 1e-12);
    ++compared;
  }
  EXPECT_GE(compared, 2);
}

TEST(Motion, HitsAreRetimedAndElseAsSimulated) {
  const Case c;
  const TimeMap map = retimed(c);
  const auto hits = c.motion(map).hits();
  ASSERT_EQ(hits.size(), c.run.hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (i < 4) {
      EXPECT_EQ(hits[i].time_s, map.motion_s[i]);
    }
    EXPECT_EQ(hits[i].approach_speed_m_s, c.run.hits[i].approach_speed_m_s);
    EXPECT_EQ(hits[i].impulse_n_s, c.run.hits[i].impulse_n_s);
  }
}

TEST(Motion, DenseTimesShowEveryImpact) {
  const Case c;
  for (const TimeMap& map : {TimeMap{}, retimed(c)}) {
    const Motion motion = c.motion(map);
    const auto times = motion.dense_times();
    EXPECT_EQ(times.front(), motion.start_s());
    EXPECT_EQ(times.back(), motion.end_s());
    for (std::size_t i = 1; i < times.size(); ++i) {
      EXPECT_GT(times[i], times[i - 1]);
      EXPECT_LE(times[i] - times[i - 1], 1e-3);
    }
    std::ptrdiff_t before = -1;
    for (const Hit& hit : motion.hits()) {
      const auto place = std::find(times.begin(), times.end(), hit.time_s);
      ASSERT_NE(place, times.end()) << hit.time_s;
      const std::ptrdiff_t at = place - times.begin();
      if (before >= 0 && at != before) {
        EXPECT_GE(at - before, 5);
      }
      before = at;
    }
  }
}

TEST(Motion, DenseTimesFollowShortContactSteps) {
  const Body ball = sample::ball(0.02, 0.03);
  State s;
  s.position.z() = 0.02;
  std::vector<Node> nodes;
  std::vector<double> short_s;
  double t = 0.0;
  for (int i = 0; i < 400; ++i) {
    const bool is_short = i >= 100 && i < 150;
    nodes.push_back({t, s, Phase::contact});
    if (is_short) short_s.push_back(t);
    t += is_short ? 5e-5 : 1e-3;
  }
  nodes.push_back({t, s, Phase::contact});
  nodes.push_back({t + 1e-6, s, Phase::rest});  // a shred is not worth a sample
  nodes.push_back({t + 0.1, s, Phase::rest});
  for (const TimeMap& map : {TimeMap{}, TimeMap{{0.0, 0.2}, {0.0, 0.21}}}) {
    const Motion motion(ball, sample::downwards(), nodes, {}, map);
    const auto times = motion.dense_times();
    for (const double wanted : short_s)
      EXPECT_TRUE(std::binary_search(times.begin(), times.end(), map.to_motion(wanted))) << wanted;
    for (std::size_t i = 1; i < times.size(); ++i) EXPECT_GE(times[i] - times[i - 1], 1e-5);
    // 1 kHz elsewhere, and a step more at either end of the stretch and of each part of the map
    EXPECT_LE(times.size(), 1000.0 * (motion.end_s() - motion.start_s()) + 50 + 5);
  }
}

TEST(Motion, PenetrationIsMeasuredAtTheHull) {
  const Body ball = sample::ball(0.02, 0.03);
  State s;
  for (const double sunk : {-0.1, 0.0, 0.003}) {
    s.position.z() = 0.02 - sunk;
    const Motion motion(ball, sample::downwards(), {{0.0, s, Phase::rest}, {0.1, s, Phase::rest}}, {}, {});
    EXPECT_NEAR(motion.max_penetration_m(motion.dense_times()), std::max(0.0, sunk), 1e-17);
  }
}

}  // namespace
}  // namespace ifa
