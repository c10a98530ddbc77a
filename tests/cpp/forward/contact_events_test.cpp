// Solving with Events::contact: marks are intervals of contact, which the motions' nodes show.
#include <gtest/gtest.h>

#include <cmath>

#include "solutions.hpp"

namespace ifa {
namespace {

using sample::expect_honest;
using sample::expect_same_bytes;
using sample::first_rung;
using sample::marks_at;

SolveOptions contact(std::uint64_t seed = 0, int threads = 2) {
  SolveOptions options = first_rung(seed, threads);
  options.events = Events::contact;
  return options;
}

TEST(ContactEvents, BallMeetsItsOwnBounces) {
  const Body ball = sample::ball(0.02, 0.03, {0.5, 0.3, 1e-2, 1e-3});  // a carpet: it does not roll far
  // 19 ms at the last, which lands with 0.09 m/s; the one after that would be shorter than the merge gap
  const Marks marks = marks_at({0.1, 0.4, 0.55, 0.625, 0.6625, 0.68125}, Ending::rest);
  SolveOptions options = contact();
  options.rung = 1;
  const Solution s = solve_forward(ball, marks, options, nullptr);
  expect_honest(ball, marks, s, Events::contact);
  EXPECT_TRUE(s.plausible);
}

// Bounces of 10.15 ms land with g T / 2 = 0.0498 m/s, which nobody hears.
TEST(ContactEvents, CountWhatIsNotHeard) {
  const Body ball = sample::ball(0.02, 0.03, {1.0, 0.3, 1e-4, 1e-4});
  constexpr double kGap_s = 0.01015;
  const Marks marks = marks_at({0.1, 0.1 + kGap_s, 0.1 + 2 * kGap_s, 0.1 + 3 * kGap_s}, Ending::open);
  SolveOptions options = contact();
  options.rung = 1;
  const Solution s = solve_forward(ball, marks, options, nullptr);
  expect_honest(ball, marks, s, Events::contact);
  EXPECT_TRUE(s.succeeded);
  EXPECT_LT(sample::onsets_of(*s.motion, Events::audible).size(), 4u);
}

// Marks of simulated throws: when their intervals of contact begin.
TEST(ContactEvents, BoxMeetsTheIntervalsOfAThrow) {
  const Body body = sample::box({0.03, 0.02, 0.012}, 0.01);
  int tried = 0, succeeded = 0;
  for (std::uint64_t i = 0; tried < 5; ++i) {
    RandomStream random(51, i);
    State start = sample::random_state(body, random, 0.0, 1.5, 20.0);
    start.velocity.z() = -random.uniform(0.5, 1.5);
    const auto run = simulate(body, start, {}, 60.0);
    const auto [intervals, nearest_gap] =
        sample::contact_intervals(body, run.nodes, run.hits, 0.010, run.rest_s);
    if (run.status != RunStatus::rest || std::abs(nearest_gap - 1.0) < 0.05) continue;
    if (intervals.size() < 3 || intervals.size() > 6) continue;
    ++tried;
    Marks marks = marks_at({});
    for (const auto& interval : intervals) {
      marks.times_s.push_back(0.25 + interval.begin_s);
      const double length = interval.end_s - interval.begin_s;
      marks.durations_s.push_back(length < 0.010 ? 0.0 : length);
      marks.amplitudes.push_back(interval.amplitude());
      marks.centroids_s.push_back(std::nan(""));
    }
    SolveOptions options = contact();
    options.rung = 1;
    const Solution s = solve_forward(body, marks, options, nullptr);
    expect_honest(body, marks, s, Events::contact);
    succeeded += s.succeeded;
    for (const int threads : {1, 3}) {
      options.threads = threads;
      expect_same_bytes(s, solve_forward(body, marks, options, nullptr));
    }
  }
  EXPECT_GE(succeeded, 4);  // each has a motion by construction; a small beam may miss one
}

}  // namespace
}  // namespace ifa
