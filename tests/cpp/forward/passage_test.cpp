#include "ifa/forward/transition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ifa/forward/start.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

Body cube() { return sample::box({0.016, 0.016, 0.016}, 0.005); }

// Thrown so that it strikes the ground now.
State striking(const Body& body, RandomStream& random) {
  State s = sample::random_state(body, random, 0.0, 1.5, 20.0);
  s.velocity.z() = -random.uniform(0.5, 2.0);
  return s;
}

struct Heard {
  double time_s, squares = 0.0;
  int hits = 0;
};

// The events of a run by their definition: chains of audible hits less than the merge gap apart. `clear` is
// false where a hit is so near to a threshold that a passage may refuse to judge it.
std::vector<Heard> events_of(const ifa::Run& run, const SearchPhysics& physics, bool& clear) {
  std::vector<Heard> events;
  double last = -1.0;
  clear = true;
  for (const Hit& hit : run.hits) {
    const double speed = hit.approach_speed_m_s, gap = hit.time_s - last;
    clear &= std::abs(speed / physics.hearing.audible_speed_m_s - 1.0) > 0.06;
    if (speed < physics.hearing.audible_speed_m_s) continue;
    clear &= events.empty() || std::abs(gap / physics.hearing.merge_gap_s - 1.0) > 0.06;
    if (events.empty() || gap >= physics.hearing.merge_gap_s) events.push_back({hit.time_s});
    events.back().squares += hit.impulse_n_s.squaredNorm();
    ++events.back().hits;
    last = hit.time_s;
  }
  return events;
}

// Event by event, passages give what one run of the simulator gives: the same times, amplitudes and the same
// rest.
TEST(Runner, PassagesAddUpToTheRun) {
  const Body body = cube();
  const SearchPhysics physics;
  Runner runner(body, physics);
  RandomStream random(41, 0);
  int compared = 0, rested = 0;
  for (int i = 0; i < 150; ++i) {
    const State start = striking(body, random);
    bool clear = true;
    const auto run = simulate(body, start, physics.simulation, 60.0);
    const auto events = events_of(run, physics, clear);
    if (!clear || events.empty()) continue;
    ASSERT_EQ(events[0].time_s, 0.0);
    Onset onset = runner.strike(start);
    double now = 0.0;
    for (std::size_t k = 0; k < events.size() && k < 10; ++k) {
      const Passage passage = runner.pass(onset, onset.after, 0.0, kNever);
      EXPECT_EQ(passage.event.hits, events[k].hits);
      EXPECT_NEAR(passage.event.amplitude, std::sqrt(events[k].squares), 1e-6 * std::sqrt(events[k].squares));
      if (k + 1 == events.size()) {
        ASSERT_EQ(passage.next, Next::rest);
        EXPECT_NEAR(now + passage.rest_s, run.rest_s,
                    2e-3);  // two steps of contact, taken from another start
        ++rested;
      } else {
        ASSERT_EQ(passage.next, Next::hit) << i << " event " << k;
        now += passage.interval_s;
        // Starting anew at each event rounds its time by 1e-16, which each impact raises a few times.
        EXPECT_NEAR(now, events[k + 1].time_s, 1e-9) << i << " event " << k;
        onset = runner.strike(passage.before);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 40);
  EXPECT_GT(rested, 3);
}

TEST(Runner, BallsPassageIsItsParabola) {
  const Body ball = sample::ball(0.02, 0.03);
  const SearchPhysics physics;
  Runner runner(ball, physics);
  State s;
  s.position.z() = 0.02;
  s.velocity.z() = -2.0;
  const Onset onset = runner.strike(s);
  EXPECT_NEAR(onset.hit.approach_speed_m_s, 2.0, 1e-15);
  EXPECT_NEAR(onset.after.velocity.z(), 1.0, 1e-15);
  EXPECT_EQ(onset.before.velocity.z(), -2.0);
  State livelier = onset.after;
  livelier.velocity.z() = 1.3;
  Record record;
  const Passage passage = runner.pass(onset, livelier, 0.0, kNever, &record);
  EXPECT_EQ(passage.next, Next::hit);
  EXPECT_NEAR(passage.interval_s, 2.6 / sample::kGravity, 1e-12);
  EXPECT_NEAR(passage.before.velocity.z(), -1.3, 1e-12);
  EXPECT_NEAR(passage.event.amplitude, 0.03 * 3.0, 1e-15);  // of the impact, not of the change
  EXPECT_TRUE(record.hits.empty());
  EXPECT_EQ(record.nodes.front().time_s, 0.0);
  EXPECT_NEAR(runner.simulated_s(), 2.6 / sample::kGravity, 1e-12);
  EXPECT_EQ(runner.pass(onset, livelier, 0.0, 0.2).next, Next::late);
  EXPECT_EQ(runner.pass(onset, livelier, 0.0, 0.2).interval_s, 0.2);
}

// A ball that lands with 0.0524 m/s might as well be taken for silent (0.05 and 5 %).
TEST(Runner, HitsNearTheThresholdAreDubious) {
  const Body ball = sample::ball(0.02, 0.03);
  const SearchPhysics physics;
  Runner runner(ball, physics);
  State s;
  s.position.z() = 0.02;
  s.velocity.z() = -1.0;
  const Onset onset = runner.strike(s);
  const auto next = [&](double speed) {
    State after = onset.after;
    after.velocity.z() = speed;
    return runner.pass(onset, after, 0.0, kNever).next;
  };
  EXPECT_EQ(next(0.0530), Next::hit);
  EXPECT_EQ(next(0.0524), Next::dubious);
  EXPECT_EQ(next(0.0476), Next::dubious);
  EXPECT_EQ(next(0.0470), Next::rest);
  // 10 ms to land within 5 %: g T / 2 = 0.049 m/s is not audible, so on a heavier planet
  SearchPhysics heavy;
  heavy.simulation.gravity_m_s2 = {0, 0, -200.0};
  Runner there(ball, heavy);
  const auto after_gap = [&](double gap) {
    State after = onset.after;
    after.velocity.z() = 100.0 * gap;
    return there.pass(onset, after, 0.0, 0.015);
  };
  EXPECT_EQ(after_gap(0.0103).next, Next::dubious);
  EXPECT_EQ(after_gap(0.0107).next, Next::hit);
}

TEST(Runner, MarkedSpanTakesItsHits) {
  const Body ball = sample::ball(0.02, 0.03);
  const SearchPhysics physics;
  Runner runner(ball, physics);
  State s;
  s.position.z() = 0.02;
  s.velocity.z() = -2.0;
  const Onset onset = runner.strike(s);
  // lands after 0.204, then every half of that: 0.306, 0.357, 0.382, 0.395, ...
  const double first = 2.0 / sample::kGravity;
  Record record;
  const Passage passage = runner.pass(onset, onset.after, 0.36, kNever, &record);
  EXPECT_EQ(passage.next, Next::hit);
  EXPECT_NEAR(passage.interval_s, first * 1.875, 1e-9);
  EXPECT_EQ(record.hits.size(), 3u);
  EXPECT_EQ(passage.event.hits, 4);
  EXPECT_NEAR(passage.event.length_s, first * 1.75, 1e-9);
}

TEST(Runner, SettleStopsApproachingPointsAndNothingElse) {
  const Body body = cube();
  const SearchPhysics physics;
  Runner runner(body, physics);
  RandomStream random(42, 0);
  int settled = 0;
  for (int i = 0; i < 200; ++i) {
    State s = sample::random_state(body, random, 0.0, 1.0, 30.0);
    EventSimulation at(body, physics.simulation);
    at.start(s, 0.0);
    const double separation = at.separation_speed(), energy = sample::kinetic(body, s);
    const State before = s;
    if (runner.settle(s)) {
      EXPECT_LT(separation, 0.0);
      at.start(s, 0.0);
      EXPECT_GE(at.separation_speed(), -1e-9);
      EXPECT_LE(sample::kinetic(body, s), energy * (1.0 + 1e-12));
      ++settled;
    } else {
      EXPECT_GE(separation, -1e-9);
      EXPECT_EQ(s.velocity, before.velocity);
    }
  }
  EXPECT_GT(settled, 40);
  State high = sample::random_state(body, random, 0.1, 1.0, 30.0);
  high.velocity.z() = -5.0;
  EXPECT_FALSE(runner.settle(high));
}

TEST(SampleStart, TouchesApproachesAndComesFromFreeFlight) {
  const Body body = cube();
  const SearchPhysics physics;
  Marks marks;
  marks.times_s = {0.5, 0.7};
  marks.durations_s = {0.0, 0.0};
  const StartOptions options = start_options(body, marks, sample::kGravity);
  EXPECT_EQ(options.least_speed_m_s, 0.5);
  EXPECT_EQ(options.most_speed_m_s, 4.0);
  int made = 0;
  for (std::uint64_t i = 0; i < 500; ++i) {
    RandomStream random(7, i), again(7, i);
    const auto s = sample_start(body, physics, options, random);
    const auto same = sample_start(body, physics, options, again);
    ASSERT_EQ(s.has_value(), same.has_value());
    if (!s) continue;
    ++made;
    EXPECT_EQ(s->velocity, same->velocity);
    EXPECT_NEAR(sample::lowest(body, *s), 0.0, 1e-16);
    EXPECT_LT(s->velocity.z(), 0.0);
    EXPECT_GE(s->velocity.norm(), 0.5 - 1e-12);
    EXPECT_LE(s->velocity.norm(), 4.0 + 1e-12);
    // Before it, nothing touched the ground for as long as asked.
    Flight flight(body);
    flight.start(*s, physics.simulation.gravity_m_s2);
    for (int k = 1; k < 50; ++k) EXPECT_GT(sample::lowest(body, flight.at(-options.clear_s * k / 50)), 0.0);
  }
  EXPECT_GT(made, 150);
}

TEST(SampleStart, LongGapsAllowFasterStarts) {
  const Body body = cube();
  Marks marks;
  marks.times_s = {0.0, 1.0};
  marks.durations_s = {0.0, 0.0};
  // A second of flight leaves the ground at g / 2, after an impact at g / 2 / e.
  EXPECT_GE(start_options(body, marks, sample::kGravity).most_speed_m_s, 0.5 * sample::kGravity / 0.5);
}

TEST(ClearBefore, OfABallIsItsParabola) {
  const Body ball = sample::ball(0.02, 0.03);
  State s;
  s.position.z() = 0.02;
  s.velocity.z() = -1.0;
  EXPECT_NEAR(clear_before(ball, s, sample::downwards(), 9.0), 2.0 / sample::kGravity, 1e-12);
  EXPECT_EQ(clear_before(ball, s, sample::downwards(), 0.1), 0.1);
}

}  // namespace
}  // namespace ifa
