// Marks to solve, and what must hold of any solution.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "contact_intervals.hpp"
#include "ifa/forward/solve.hpp"
#include "sample_marks.hpp"

namespace ifa::sample {

// Of a throw: when its audible hits came, those less than 10 ms after another left out. The body comes to
// rest after the last of them, so some motion meets the marks exactly.
inline Marks of_a_throw(const Body& body, std::uint64_t seed, std::size_t most) {
  for (std::uint64_t i = 0;; ++i) {
    RandomStream random(seed, i);
    State s = sample::random_state(body, random, 0.0, 1.5, 20.0);
    s.velocity.z() = -random.uniform(0.5, 1.5);
    const auto run = simulate(body, s, {}, 60.0);
    Marks marks = marks_at({});
    double last = -1.0;
    bool clear = run.status == RunStatus::rest;
    for (const Hit& hit : run.hits) {
      clear &= std::abs(hit.approach_speed_m_s / 0.05 - 1.0) > 0.06;
      if (hit.approach_speed_m_s < 0.05) continue;
      if (hit.time_s - last >= 0.010) {
        marks.times_s.push_back(0.25 + hit.time_s);
        marks.amplitudes.push_back(hit.impulse_n_s.norm());
      }
      last = hit.time_s;
    }
    marks.durations_s.assign(marks.size(), 0.0);
    marks.centroids_s.assign(marks.size(), std::nan(""));
    if (clear && marks.size() >= 3 && marks.size() <= most) return marks;
  }
}

// When its events begin, from its hits and nodes alone. What chains is judged before retiming.
inline std::vector<double> onsets_of(const Motion& motion, Events events) {
  constexpr double kMergeGap = 0.010;
  std::vector<double> onsets;
  std::vector<Hit> hits = motion.hits();
  if (events == Events::audible) {
    double last = -1e9;
    for (const Hit& hit : hits) {
      if (hit.approach_speed_m_s < 0.05) continue;
      const double simulated = motion.time().to_simulated(hit.time_s);
      if (simulated - last >= kMergeGap) onsets.push_back(hit.time_s);
      last = simulated;
    }
    return onsets;
  }
  for (Hit& hit : hits) {  // to the instant of its node, which retiming there and back rounds
    const double simulated = motion.time().to_simulated(hit.time_s);
    const auto off = [&](const Node& node) { return std::abs(node.time_s - simulated); };
    hit.time_s = std::ranges::min_element(motion.nodes(), {}, off)->time_s;
  }
  for (const auto& interval : contact_intervals(motion.body(), motion.nodes(), hits, kMergeGap, kNever).all)
    onsets.push_back(motion.time().to_motion(interval.begin_s));
  return onsets;
}

// How far, seen from above, the centre of mass is from the segments between touching vertices; 0 where three
// or more touch, which every flat face of a box at rest does. Body axes.
inline double off_support_m(const Body& body, const State& s) {
  const auto& vertices = body.vertices();
  std::vector<Vec3> touching;
  double lowest = kNever;
  for (const Vec3& v : vertices) lowest = std::min(lowest, (s.orientation * v).z());
  for (const Vec3& v : vertices)
    if ((s.orientation * v).z() < lowest + 1e-4 * body.bounding_radius_m())
      touching.push_back(s.orientation * v);
  if (touching.size() >= 3) return 0.0;
  const Eigen::Vector2d a = touching.front().head<2>(), along = touching.back().head<2>() - a;
  const double length2 = along.squaredNorm();
  const double at = length2 > 0.0 ? std::clamp(-a.dot(along) / length2, 0.0, 1.0) : 0.0;
  return (a + at * along).norm();
}

// What must hold of any solution, from its motion alone.
inline void expect_honest(const Body& body, const Marks& marks, const Solution& s,
                          Events events = Events::audible) {
  ASSERT_EQ(s.events.size(), marks.size());
  // Each mark is met by the beginning of an event, and nothing else sounds.
  const std::vector<double> onsets = onsets_of(*s.motion, events);
  double sum = 0.0;
  for (std::size_t k = 0; k < marks.size(); ++k) {
    const EventReport& e = s.events[k];
    EXPECT_EQ(e.target_s, marks.times_s[k]);
    if (k > 0 && e.factors.time > 0.0) {  // met
      const double target = marks.times_s[k] - marks.times_s[k - 1];
      EXPECT_NEAR(e.retime, target / (target + e.error_s), 1e-12);
      EXPECT_NEAR(e.factors.time, time_factor(target + e.error_s, target), 1e-12);
    }
    EXPECT_EQ(e.factors.orientation, 1.0);  // nothing is spliced
    for (const double f :
         {e.factors.velocity, e.factors.time, e.factors.amplitude, e.factors.length, e.factors.centroid}) {
      EXPECT_TRUE(f >= 0.0 && f <= 1.0);
      sum += std::log(std::max(f, 1e-300));  // as the Score has it
    }
  }
  EXPECT_NEAR(s.score, std::exp(sum / (6.0 * static_cast<double>(marks.size()))), 1e-12);
  if (s.succeeded) {
    ASSERT_EQ(onsets.size(), marks.size());
    for (std::size_t k = 0; k < marks.size(); ++k) {
      EXPECT_NEAR(onsets[k], marks.times_s[k], 1e-9);  // retimed to the mark; rounding only
      EXPECT_TRUE(s.events[k].retime <= 1.3 && s.events[k].retime >= 1.0 / 1.3);
    }
    EXPECT_EQ(s.missed_hits + s.extra_hits, 0);
    EXPECT_GE(s.score, 0.3);
    for (const State& now : s.motion->sample(s.motion->dense_times()))
      EXPECT_GT(sample::lowest(body, now), -1e-4);
    if (marks.ending == Ending::rest) {
      const State before = s.motion->sample({s.motion->end_s() - 0.05})[0];
      const State end = s.motion->sample({s.motion->end_s()})[0];
      EXPECT_LT((end.position - before.position).norm(), 0.05 * 0.01);  // slower than 0.01 m/s
      // It does not tip over: the centre of mass is above what bears it, or so near that rolling friction,
      // with this length as its lever, holds it.
      EXPECT_LE(off_support_m(body, end), body.material().rolling_friction_m + 1e-6);  // its last sinking
    }
  }
  if (s.plausible) {
    EXPECT_TRUE(s.succeeded);
    for (const EventReport& e : s.events) {
      EXPECT_LE(e.excess, 1.0 + 1e-9);
      EXPECT_TRUE(e.retime <= 1.07 + 1e-9 && 1.0 / e.retime <= 1.07 + 1e-9);
    }
  }
}

inline void expect_same_bytes(const Solution& a, const Solution& b) {
  const auto times = a.motion->dense_times();
  ASSERT_EQ(times, b.motion->dense_times());
  const auto sa = a.motion->sample(times), sb = b.motion->sample(times);
  for (std::size_t i = 0; i < times.size(); ++i) {
    ASSERT_EQ(std::memcmp(sa[i].position.data(), sb[i].position.data(), 3 * sizeof(double)), 0);
    ASSERT_EQ(
        std::memcmp(sa[i].orientation.coeffs().data(), sb[i].orientation.coeffs().data(), 4 * sizeof(double)),
        0);
  }
  EXPECT_EQ(a.score, b.score);
  EXPECT_EQ(a.simulated_s, b.simulated_s);
}

inline SolveOptions first_rung(std::uint64_t seed = 0, int threads = 2) {
  SolveOptions o;
  o.rung = 0;
  o.seed = seed;
  o.threads = threads;
  return o;
}

}  // namespace ifa::sample
