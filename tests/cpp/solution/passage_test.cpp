#include "ifa/solution/passage.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "contact_intervals.hpp"
#include "sample_bodies.hpp"
#include "solution/passages.hpp"

namespace ifa {
namespace {

using sample::physics_of;
using sample::run_one;
using sample::strike_one;

struct Sample {
  std::string name;
  Body body;
};

std::vector<Sample> bodies() {
  return {{"cube", sample::box({0.016, 0.016, 0.016}, 0.005)},
          {"slab", sample::box({0.05, 0.03, 0.008}, 0.01, {0.3, 0.6, 1e-4, 1e-4})},
          {"ball", sample::ball(0.02, 0.03, {0.6, 0.3, 1e-3, 1e-3})},
          {"rod", sample::rod(0.06, 0.004, 0.01, {0.7, 0.2, 5e-5, 5e-5})},
          {"coin", sample::coin()}};
}

// Thrown so that it strikes the ground now.
State striking(const Body& body, RandomStream& random) {
  State s = sample::random_state(body, random, 0.0, 1.5, 20.0);
  s.velocity.z() = -random.uniform(0.5, 2.0);
  return s;
}

// Every number of a passage, so that two can be compared bit by bit.
std::vector<std::uint64_t> bits(const State& s) {
  std::vector<std::uint64_t> out;
  for (const auto& v : {s.position, s.velocity, s.angular_velocity})
    for (const double x : v) out.push_back(std::bit_cast<std::uint64_t>(x));
  for (const double x : s.orientation.coeffs()) out.push_back(std::bit_cast<std::uint64_t>(x));
  return out;
}

std::vector<std::uint64_t> bits(const Hit& hit) {
  std::vector<std::uint64_t> out;
  for (const double x : {hit.time_s, hit.approach_speed_m_s, hit.impulse_n_s.x(), hit.impulse_n_s.y(),
                         hit.impulse_n_s.z(), hit.position_m.x(), hit.position_m.y(), hit.position_m.z()})
    out.push_back(std::bit_cast<std::uint64_t>(x));
  return out;
}

// Without the onset of the next event.
std::vector<std::uint64_t> bits(const Passage& p) {
  std::vector<std::uint64_t> out = bits(p.end);
  out.push_back(static_cast<std::uint64_t>(p.next));
  out.push_back(static_cast<std::uint64_t>(p.event.hits));
  for (const double x : {p.interval_s, p.rest_s, p.event.time_s, p.event.length_s, p.event.amplitude,
                         p.event.centroid_s, p.event.loose_s, p.event.gap_s})
    out.push_back(std::bit_cast<std::uint64_t>(x));
  return out;
}

// Impacts left at random, as a search does: with what physics says or with another velocity, with or without
// a span, followed for long or not.
std::vector<Departure> random_departures(const Body& body, Passages& passages, RandomStream& random,
                                         int count) {
  std::vector<State> before;
  for (int i = 0; i < count; ++i) before.push_back(striking(body, random));
  std::vector<Onset> onsets(before.size());
  passages.strike(before, onsets);
  std::vector<Departure> departures;
  for (const Onset& onset : onsets) {
    State after = onset.after;
    if (random.uniform() < 0.7) {
      after.velocity += 0.3 * random.uniform() * after.velocity.norm() * random.unit_vector();
      after.angular_velocity += 0.1 * random.uniform() * after.angular_velocity.norm() * random.unit_vector();
      passages.settle(after);
    }
    const double span = random.uniform() < 0.3 ? random.uniform(0.02, 0.2) : 0.0;
    departures.push_back({onset.hit, after, span, random.uniform() < 0.2 ? 5.0 : random.uniform(0.05, 0.4)});
  }
  return departures;
}

struct Heard {
  double time_s, squares = 0.0;
  int hits = 0;
};

struct HeardRun {
  std::vector<Heard> events;
  bool clear = true;  // no hit is so near to a threshold that a passage may refuse to judge it
};

// The events of a run by their definition: chains of audible hits less than the merge gap apart.
HeardRun events_of(const ifa::Run& run, const SearchPhysics& physics) {
  HeardRun heard;
  double last = -1.0;
  int since = 0;
  for (const Hit& hit : run.hits) {
    const double speed = hit.approach_speed_m_s, gap = hit.time_s - last;
    heard.clear &= std::abs(speed / physics.hearing.audible_speed_m_s - 1.0) > 0.06;
    heard.clear &= ++since < 60;  // chatter
    if (speed < physics.hearing.audible_speed_m_s) continue;
    heard.clear &= heard.events.empty() || std::abs(gap / physics.hearing.merge_gap_s - 1.0) > 0.06;
    if (heard.events.empty() || gap >= physics.hearing.merge_gap_s) {
      heard.events.push_back({hit.time_s});
      since = 0;
    }
    heard.events.back().squares += hit.impulse_n_s.squaredNorm();
    ++heard.events.back().hits;
    last = hit.time_s;
  }
  return heard;
}

// Event by event, passages give what one run of the simulator gives: the same times, amplitudes and the same
// rest.
TEST(Passages, AddUpToTheRun) {
  const SearchPhysics physics;
  for (const Sample& s : bodies()) {
    const int throws = s.body.rings().empty() ? 150 : 30;  // coins roll on for seconds
    Passages passages(s.body, physics);
    RandomStream random(41, 0);
    int compared = 0, rested = 0;
    for (int i = 0; i < throws; ++i) {
      const State start = striking(s.body, random);
      const auto run = simulate(s.body, start, physics.simulation, 60.0);
      const auto [events, clear] = events_of(run, physics);
      if (!clear || events.empty() || run.status != RunStatus::rest) continue;
      ASSERT_EQ(events[0].time_s, 0.0);
      Onset onset = strike_one(passages, start);
      double now = 0.0;
      for (std::size_t k = 0; k < events.size(); ++k) {
        const Passage passage = run_one(passages, {onset.hit, onset.after, 0.0, kNever});
        EXPECT_EQ(passage.event.hits, events[k].hits);
        const double amplitude = std::sqrt(events[k].squares);
        EXPECT_NEAR(passage.event.amplitude, amplitude, 1e-6 * amplitude);
        if (k + 1 == events.size()) {
          ASSERT_EQ(passage.next, Next::rest) << s.name << i;
          constexpr double kTwoSteps_s = 2e-3;  // steps of contact begin at another instant
          EXPECT_GT(now + passage.rest_s, run.rest_s - kTwoSteps_s);
          // A ball's is a bound: passage_ball_test.cpp
          if (s.name != "ball") {
            EXPECT_LT(now + passage.rest_s, run.rest_s + kTwoSteps_s) << s.name << i;
          }
          ++rested;
          break;
        }
        ASSERT_EQ(passage.next, Next::hit) << s.name << i << " event " << k;
        now += passage.interval_s;
        // Starting anew at each event rounds its time by 1e-16, which each impact raises a few times.
        EXPECT_NEAR(now, events[k + 1].time_s, 1e-9) << s.name << i << " event " << k;
        onset = passage.onset;
        ++compared;
      }
    }
    EXPECT_GT(compared, throws / 5) << s.name;
    EXPECT_GT(rested, throws / 15) << s.name;
  }
}

// What the search has seen side by side is what the motion is made of, one after the other.
TEST(Passages, AreTheSameBytesAloneTogetherAndRecorded) {
  for (const Events events : {Events::audible, Events::contact}) {
    const SearchPhysics physics = physics_of(events);
    for (const Sample& s : bodies()) {
      RandomStream random(43, events == Events::contact);
      Passages passages(s.body, physics);
      const auto departures = random_departures(s.body, passages, random, s.body.rings().empty() ? 300 : 60);
      std::vector<Passage> together(departures.size()), reversed(departures.size());
      passages.run(departures, together, nullptr);
      const std::vector<Departure> backwards(departures.rbegin(), departures.rend());
      passages.run(backwards, reversed, nullptr);
      int seen[4] = {};
      const bool shortcut = s.name == "ball" && events == Events::audible;
      for (std::size_t i = 0; i < departures.size(); ++i) {
        const Passage& passage = together[i];
        ++seen[static_cast<int>(passage.next)];
        EXPECT_EQ(bits(reversed[departures.size() - 1 - i]), bits(passage)) << s.name << i;
        Passages alone(s.body, physics);
        EXPECT_EQ(bits(run_one(alone, departures[i])), bits(passage)) << s.name << i;
        Record record;
        const Passage recorded = record_passage(s.body, physics, departures[i], record);
        if (shortcut && recorded.next != Next::hit && passage.next != Next::dubious)
          EXPECT_NE(passage.next, Next::hit);  // passage_ball_test.cpp
        else
          EXPECT_EQ(bits(recorded), bits(passage)) << s.name << i;
        if (passage.next != Next::hit) continue;
        const Onset onset = strike(s.body, physics, recorded.end);
        EXPECT_EQ(bits(passage.onset.before), bits(onset.before)) << s.name << i;
        EXPECT_EQ(bits(passage.onset.after), bits(onset.after)) << s.name << i;
        EXPECT_EQ(bits(passage.onset.hit), bits(onset.hit)) << s.name << i;
      }
      EXPECT_GT(seen[static_cast<int>(Next::hit)], 15) << s.name;
      EXPECT_GT(seen[static_cast<int>(Next::late)], 3) << s.name;
    }
  }
}

TEST(Passages, CountWhatTheySimulate) {
  const Body body = sample::box({0.016, 0.016, 0.016}, 0.005);
  const SearchPhysics physics;
  Passages passages(body, physics);
  RandomStream random(44, 0);
  const auto departures = random_departures(body, passages, random, 50);
  std::vector<Passage> out(departures.size());
  EXPECT_EQ(passages.simulated_s(), 0.0);
  passages.run(departures, out, nullptr);
  double sum = 0.0;
  for (const Passage& p : out) sum += p.interval_s;
  EXPECT_NEAR(passages.simulated_s(), sum, 1e-12 * sum);  // added in another order
  passages.run({}, {}, nullptr);
  EXPECT_NEAR(passages.simulated_s(), sum, 1e-12 * sum);
}

// With contact events, the events of passages are the intervals of contact of the whole run.
TEST(Passages, ContactEventsAreIntervalsOfContact) {
  const SearchPhysics physics = physics_of(Events::contact);
  for (const Sample& s : bodies()) {
    const int throws = s.body.rings().empty() ? 120 : 40;
    Passages passages(s.body, physics);
    RandomStream random(46, 0);
    int compared = 0, rested = 0, pressed = 0;
    for (int i = 0; i < throws; ++i) {
      const State start = striking(s.body, random);
      const auto run = simulate(s.body, start, physics.simulation, 60.0);
      if (run.status != RunStatus::rest) continue;
      const auto [intervals, nearest_gap] =
          sample::contact_intervals(s.body, run.nodes, run.hits, physics.hearing.merge_gap_s, run.rest_s);
      if (std::abs(nearest_gap - 1.0) < 0.012) continue;  // 1 % is dubious
      if (std::ranges::any_of(intervals, [](const auto& one) { return one.hits >= 60; })) continue;
      Onset onset = strike_one(passages, start);
      double now = 0.0;
      for (std::size_t k = 0; k < intervals.size(); ++k) {
        const auto& interval = intervals[k];
        const Passage passage = run_one(passages, {onset.hit, onset.after, 0.0, kNever});
        EXPECT_EQ(passage.event.hits, interval.hits) << s.name << i << " event " << k;
        const bool last = k + 1 == intervals.size();
        // Starting anew rounds times by 1e-16, raised a few times at each impact; rest is told to two steps.
        const double off_s = last ? 2e-3 : 1e-9;
        // Holding its points on the ground may push a body a tenth of a micrometre in a step of a
        // millisecond.
        constexpr double kPushed_m_s = 1e-4;
        // A landing slower than 0.01 m/s within sustained contact has no load of its own and shows in the
        // momentum alone; a wobbling coin has many.
        const double off_n_s = off_s * s.body.mass_kg() * sample::kGravity +
                               (s.name == "coin" ? 2e-2 : 2e-3) * interval.pressed +
                               kPushed_m_s * s.body.mass_kg() + 1e-6 * std::sqrt(interval.squares);
        const double length = interval.end_s - interval.begin_s;
        if (std::abs(length - physics.hearing.merge_gap_s) > off_s) {
          EXPECT_NEAR(passage.event.length_s, length < physics.hearing.merge_gap_s ? 0.0 : length, off_s)
              << s.name << i << " event " << k;
        }
        EXPECT_NEAR(passage.event.amplitude, interval.amplitude(), off_n_s) << s.name << i << " event " << k;
        pressed += interval.pressed > 0.01 * interval.amplitude();
        if (last) {
          ASSERT_EQ(passage.next, Next::rest) << s.name << i;
          EXPECT_NEAR(now + passage.rest_s, run.rest_s, off_s) << s.name << i;
          ++rested;
          break;
        }
        ASSERT_EQ(passage.next, Next::hit) << s.name << i << " event " << k;
        now += passage.interval_s;
        EXPECT_NEAR(now, intervals[k + 1].begin_s, off_s) << s.name << i << " event " << k;
        onset = passage.onset;
        ++compared;
      }
    }
    EXPECT_GT(compared, throws / 4) << s.name;
    EXPECT_GT(rested, throws / 6) << s.name;
    EXPECT_GT(pressed, throws / 6) << s.name;
  }
}

TEST(Passages, SettleStopsApproachingPointsAndNothingElse) {
  for (const Sample& s : bodies()) {
    const SearchPhysics physics;
    const Passages passages(s.body, physics);
    RandomStream random(42, 0);
    int settled = 0;
    for (int i = 0; i < 200; ++i) {
      State state = sample::random_state(s.body, random, 0.0, 1.0, 30.0);
      EventSimulation at(s.body, physics.simulation);
      at.start(state, 0.0);
      const double separation = at.separation_speed(), energy = sample::kinetic(s.body, state);
      const State before = state;
      if (passages.settle(state)) {
        EXPECT_LT(separation, 0.0);
        at.start(state, 0.0);
        EXPECT_GE(at.separation_speed(), -1e-9);
        EXPECT_LE(sample::kinetic(s.body, state), energy * (1.0 + 1e-12));
        ++settled;
      } else {
        EXPECT_GE(separation, -1e-9);
        EXPECT_EQ(bits(state), bits(before));
      }
    }
    EXPECT_GT(settled, 40) << s.name;
    State high = sample::random_state(s.body, random, 0.1, 1.0, 30.0);
    high.velocity.z() = -5.0;
    EXPECT_FALSE(passages.settle(high));
  }
}

TEST(Stands, OnAFaceAndNotOnAnEdgeOrACorner) {
  const Body box = sample::box({0.03, 0.02, 0.012}, 0.02);
  const auto turned = [](double angle, const Vec3& axis) {
    State s;
    s.orientation = Quat(Eigen::AngleAxisd(angle, axis.normalized()));
    return s;
  };
  const double right = 0.5 * std::numbers::pi;
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0)})
    for (int quarter = 0; quarter < 4; ++quarter) EXPECT_TRUE(stands(box, turned(quarter * right, axis)));
  EXPECT_TRUE(stands(box, turned(1e-6, {1, 2, 0})));  // as flat as a face at rest is
  // Balanced: the mass centre is just above an edge, then just above a corner.
  EXPECT_FALSE(stands(box, turned(std::atan2(0.012, 0.02) + right, {1, 0, 0})));
  const Quat corner = Quat::FromTwoVectors(Vec3(0.03, 0.02, 0.012), Vec3(0, 0, -1));
  State on_corner;
  on_corner.orientation = corner;
  EXPECT_FALSE(stands(box, on_corner));
  EXPECT_TRUE(stands(sample::ball(0.02, 0.03), turned(1.0, {1, 0, 0})));
  EXPECT_TRUE(stands(sample::coin({}), turned(right, {1, 0, 0})));
}

}  // namespace
}  // namespace ifa
