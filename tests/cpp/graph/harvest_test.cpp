// The nodes of a simulation against the simulation itself, event by event.
#include "ifa/graph/harvest.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "contact_intervals.hpp"
#include "ifa/signature/signature_of.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

constexpr std::uint64_t kSeed = 11;
constexpr double kUntil_s = 60.0;

struct Sample {
  std::string name;
  Body body;
  std::size_t simulations;
};

std::vector<Sample> bodies() {
  return {{"cube", sample::box({0.016, 0.016, 0.016}, 0.005), 60},
          {"slab", sample::box({0.05, 0.03, 0.008}, 0.01, {0.3, 0.6, 1e-4, 1e-4}), 60},
          {"ball", sample::ball(0.02, 0.03, {0.6, 0.3, 1e-3, 1e-3}), 20},
          {"rod", sample::rod(0.06, 0.004, 0.01, {0.7, 0.2, 5e-5, 5e-5}), 30},
          {"coin", sample::coin(), 15}};
}

Run run_of(const Body& body, std::uint64_t simulation, double until_s = kUntil_s) {
  State start[1];
  sample_states(body, {}, kSeed, simulation, start, 1);
  return simulate(body, start[0], {}, until_s);
}

// What an event of a run should be as a node, and how nearly the amplitude is known.
struct Expected {
  double time_s, length_s, amplitude, off_n_s;
};

// Floats hold 24 bits, and so a sum of two of them a relative 1.2e-7.
constexpr double kFloat = 2e-7;

std::vector<Expected> audible_events(const Run& run) {
  const bool heard = std::ranges::any_of(
      run.hits, [](const Hit& hit) { return hit.approach_speed_m_s >= HearingOptions{}.audible_speed_m_s; });
  if (!heard) return {};
  const Marks marks = signature_of(run);
  std::vector<Expected> events;
  for (std::size_t i = 0; i < marks.times_s.size(); ++i)
    events.push_back(
        {marks.times_s[i], marks.durations_s[i], marks.amplitudes[i], kFloat * marks.amplitudes[i]});
  return events;
}

// None where a flight is so nearly as long as the merge gap that rounding decides.
std::vector<Expected> contact_events(const Sample& s, const Run& run) {
  const double gap_s = HearingOptions{}.merge_gap_s;
  const double until_s = run.status == RunStatus::rest ? run.rest_s : kNever;
  const auto [intervals, nearest_gap] =
      sample::contact_intervals(s.body, run.nodes, run.hits, gap_s, until_s);
  if (std::abs(nearest_gap - 1.0) < 1e-9) return {};
  std::vector<Expected> events;
  for (const auto& interval : intervals) {
    const double length_s = interval.end_s - interval.begin_s;
    // What is pressed is known from the momentum: holding its points on the ground may push a body a tenth of
    // a micrometre in a step of a millisecond, the last 0.01 m/s are taken away at rest, and a landing slower
    // than that within sustained contact has no load of its own; a wobbling coin has many.
    const double pushed_m_s = &interval == &intervals.back() ? 1e-2 : 1e-4;
    const double off_n_s =
        pushed_m_s * s.body.mass_kg() + (s.name == "coin" ? 2e-2 : 5e-3) * interval.pressed;
    events.push_back({interval.begin_s, length_s < gap_s ? 0.0 : length_s, interval.amplitude(), off_n_s});
  }
  return events;
}

// The first node of the run at or after `time_s`.
std::size_t node_at(const Run& run, double time_s) {
  return static_cast<std::size_t>(std::ranges::lower_bound(run.nodes, time_s, {}, &Node::time_s) -
                                  run.nodes.begin());
}

// A passage gives up after 60 impacts, and its event ends there by definition.
bool chatters(const Run& run, const std::vector<Expected>& events) {
  for (std::size_t i = 0; i < events.size(); ++i) {
    const double end_s = i + 1 < events.size() ? events[i + 1].time_s : kNever;
    if (std::ranges::count_if(run.hits, [&](const Hit& hit) {
          return hit.time_s >= events[i].time_s && hit.time_s < end_s;
        }) > 60)
      return true;
  }
  return false;
}

struct Slice {
  std::size_t begin, end;
};

Slice slice_of(const NodeColumns& nodes, std::size_t simulation) {
  const auto [begin, end] = std::ranges::equal_range(nodes.simulation, simulation);
  return {static_cast<std::size_t>(begin - nodes.simulation.begin()),
          static_cast<std::size_t>(end - nodes.simulation.begin())};
}

class Harvested : public ::testing::TestWithParam<Events> {};

TEST_P(Harvested, EventsAreThoseOfTheSimulation) {
  SearchPhysics physics;
  physics.hearing.events = GetParam();
  for (const Sample& s : bodies()) {
    SCOPED_TRACE(s.name);
    const NodeColumns nodes = harvest(s.body, physics, {}, kSeed, 0, s.simulations, kUntil_s);
    std::size_t compared = 0;
    for (std::size_t k = 0; k < s.simulations; ++k) {
      SCOPED_TRACE("simulation " + std::to_string(k));
      const auto run = run_of(s.body, k);
      const auto events = GetParam() == Events::audible ? audible_events(run) : contact_events(s, run);
      if (events.empty() || chatters(run, events)) continue;
      const auto [begin, end] = slice_of(nodes, k);
      ASSERT_EQ(end - begin, events.size());
      ++compared;
      for (std::size_t i = 0; i < events.size(); ++i) {
        const std::size_t n = begin + i;
        EXPECT_NEAR(nodes.amplitude[n], events[i].amplitude,
                    events[i].off_n_s + kFloat * events[i].amplitude);
        EXPECT_NEAR(nodes.length_s[n], events[i].length_s, 2 * kFloat * events[i].length_s + 1e-9);
        const bool last = i + 1 == events.size();
        const bool rests = last && run.status == RunStatus::rest && stands(s.body, run.nodes.back().state);
        EXPECT_EQ((nodes.flags[n] & kTerminal) != 0, rests);
        EXPECT_EQ((nodes.flags[n] & kEdge) != 0, !last);
        if (nodes.flight_s[n] > 0.0f) {
          ASSERT_FALSE(last);
          const double interval_s = events[i + 1].time_s - events[i].time_s;
          EXPECT_NEAR(static_cast<double>(nodes.delay_s[n]) + static_cast<double>(nodes.flight_s[n]),
                      interval_s, kFloat * interval_s);
        }
      }
    }
    EXPECT_GE(compared, s.simulations * 9 / 10);
  }
}

// In body axes and from rotation matrices, unlike the code.
struct ExpectedView {
  Vec3 up, velocity, spin, velocity_change, spin_change;
};

ExpectedView view(const State& take_off, const State& before) {
  const Mat3 to_body = take_off.orientation.toRotationMatrix().transpose();
  return {to_body * Vec3(0, 0, 1), to_body * take_off.velocity, to_body * take_off.angular_velocity,
          to_body * (take_off.velocity - before.velocity),
          to_body * (take_off.angular_velocity - before.angular_velocity)};
}

void expect_row(const float* row, const Vec3& expected) {
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(static_cast<double>(row[i]), expected[i], kFloat * expected.norm() + 1e-12);
}

TEST(Harvest, StatesAreThoseOfTheSimulation) {
  for (const Sample& s : bodies()) {
    SCOPED_TRACE(s.name);
    const NodeColumns nodes = harvest(s.body, {}, {}, kSeed, 0, s.simulations, kUntil_s);
    std::size_t flights = 0, delayed = 0;
    for (std::size_t k = 0; k < s.simulations; ++k) {
      SCOPED_TRACE("simulation " + std::to_string(k));
      const auto run = run_of(s.body, k);
      const auto events = audible_events(run);
      if (chatters(run, events)) continue;
      const std::size_t begin = slice_of(nodes, k).begin;
      for (std::size_t i = 0; i < events.size(); ++i) {
        const std::size_t n = begin + i, at = node_at(run, events[i].time_s);
        ASSERT_EQ(run.nodes[at + 1].time_s, run.nodes[at].time_s);
        const State &before = run.nodes[at].state, &after = run.nodes[at + 1].state;
        const State onset = onset_of(view_of(nodes), n);
        // The same simulation, so the same bits.
        EXPECT_EQ(onset.position.z(), after.position.z());
        EXPECT_EQ(onset.orientation.coeffs(), after.orientation.coeffs());
        EXPECT_EQ(onset.velocity, after.velocity);
        EXPECT_EQ(onset.angular_velocity, after.angular_velocity);

        // The last flight begins at the node before the next onset, if it flies from there.
        const bool last = i + 1 == events.size();
        const std::size_t end = last ? run.nodes.size() - 1 : node_at(run, events[i + 1].time_s);
        const std::size_t off = last ? end : end - 1;
        const bool flies = !last && run.nodes[off].phase == Phase::flight;
        EXPECT_EQ(nodes.flight_s[n] > 0.0f, flies);
        if (!flies && !last) continue;
        const State& take_off = run.nodes[off].state;
        const double delay_s = run.nodes[off].time_s - events[i].time_s;
        EXPECT_NEAR(static_cast<double>(nodes.delay_s[n]), delay_s, kFloat * delay_s);
        const ExpectedView expected = view(take_off, before);
        expect_row(&nodes.take_off[10 * n], expected.up);
        expect_row(&nodes.take_off[10 * n + 3], expected.velocity);
        expect_row(&nodes.take_off[10 * n + 6], expected.spin);
        EXPECT_NEAR(static_cast<double>(nodes.take_off[10 * n + 9]), take_off.position.z(),
                    kFloat * take_off.position.z());
        expect_row(&nodes.change[6 * n], expected.velocity_change);
        expect_row(&nodes.change[6 * n + 3], expected.spin_change);
        // Before the impact that it takes off with; after the step, where it was one.
        const bool impact = run.nodes[off - 1].time_s == run.nodes[off].time_s;
        const double energy_j = sample::mechanical(s.body, impact ? run.nodes[off - 1].state : take_off);
        EXPECT_NEAR(static_cast<double>(nodes.energy_j[n]), energy_j, kFloat * energy_j);
        flights += flies;
        delayed += flies && delay_s > 0.0;
      }
    }
    EXPECT_GT(flights, s.simulations);
    EXPECT_TRUE(s.name == "ball" || delayed > s.simulations / 10);  // a ball has no chains
  }
}

// A hit within 5 % of the audible speed, or chained or not by a gap within 5 % of 10 ms, could be heard
// either way.
TEST(Harvest, DoubtfulEdgesAreMarked) {
  const Sample s = bodies()[0];
  const NodeColumns nodes = harvest(s.body, {}, {}, kSeed, 0, s.simulations, kUntil_s);
  std::size_t dubious = 0;
  for (std::size_t k = 0; k < s.simulations; ++k) {
    const auto run = run_of(s.body, k);
    const auto events = audible_events(run);
    if (chatters(run, events)) continue;
    for (std::size_t i = 0; i < events.size(); ++i) {
      const double end_s = i + 1 < events.size() ? events[i + 1].time_s : kNever;
      double heard_s = events[i].time_s;
      bool expected = false;
      for (const Hit& hit : run.hits) {
        if (hit.time_s <= events[i].time_s || hit.time_s > end_s) continue;
        const double share = hit.approach_speed_m_s / 0.05;
        expected |= std::abs(share - 1.0) < 0.05;
        if (share < 1.0) continue;
        expected |= std::abs((hit.time_s - heard_s) / 0.010 - 1.0) < 0.05;
        heard_s = hit.time_s;
      }
      EXPECT_EQ((nodes.flags[slice_of(nodes, k).begin + i] & kDubious) != 0, expected)
          << "simulation " << k << ", event " << i;
      dubious += expected;
    }
  }
  EXPECT_GT(dubious, 0u);
}

TEST(Harvest, ASimulationThatIsCutOffHasNoTerminalNode) {
  const Body die = bodies()[0].body;
  constexpr double kShort_s = 0.2;  // dice roll for longer
  const NodeColumns nodes = harvest(die, {}, {}, kSeed, 0, 50, kShort_s);
  std::size_t cut = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const bool last = n + 1 == nodes.size() || nodes.simulation[n + 1] != nodes.simulation[n];
    const bool rests = last && run_of(die, nodes.simulation[n], kShort_s).status == RunStatus::rest;
    EXPECT_EQ(nodes.flags[n] & (kTerminal | kEdge), last ? (rests ? kTerminal : 0) : kEdge);
    cut += last && !rests;
  }
  EXPECT_GT(cut, 10u);
}

TEST(Harvest, TheSameBytesForAnyChunks) {
  for (const Sample& s : bodies()) {
    if (s.name == "coin") continue;  // slow, and nothing that the others have not
    const NodeColumns whole = harvest(s.body, {}, {}, kSeed, 5, 20, kUntil_s);
    NodeColumns joined;
    for (const auto& [first, count] : {std::pair{5, 1}, {6, 12}, {18, 0}, {18, 7}})
      append(joined, harvest(s.body, {}, {}, kSeed, static_cast<std::uint64_t>(first),
                             static_cast<std::size_t>(count), kUntil_s));
    EXPECT_GT(whole.size(), 0u);
    std::vector<std::string> a, b;
    const auto bytes = [](std::vector<std::string>& out) {
      return [&out](const auto& column, int, const char*) {
        const auto view = std::as_bytes(std::span(column));
        out.emplace_back(reinterpret_cast<const char*>(view.data()), view.size());
      };
    };
    NodeColumns::each(whole, bytes(a));
    NodeColumns::each(joined, bytes(b));
    EXPECT_EQ(a, b) << s.name;
  }
}

TEST(Harvest, IsCancelled) {
  Progress progress;
  progress.cancel();
  EXPECT_THROW(harvest(bodies()[0].body, {}, {}, kSeed, 0, 10, kUntil_s, &progress), Cancelled);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Harvested, ::testing::Values(Events::audible, Events::contact));

}  // namespace
}  // namespace ifa
