#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "ifa/base/error.hpp"
#include "ifa/forward/trial.hpp"
#include "ifa/solution/solution.hpp"
#include "solutions.hpp"

namespace ifa {
namespace {

using sample::cube;
using sample::expect_honest;
using sample::expect_same_bytes;
using sample::first_rung;
using sample::marks_at;
using sample::of_a_throw;

TEST(Search, MeetsTheMarksOfAThrow) {
  const Body body = cube();
  int succeeded = 0, on_a_face = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Marks marks = of_a_throw(body, seed, 6);
    try {
      const Solution s = solve_forward(body, marks, first_rung(), nullptr);
      expect_honest(body, marks, s);
      EXPECT_EQ(s.rung, 0);
      EXPECT_GT(s.simulated_s, 0.0);
      EXPECT_EQ(s.restitution, body.material().restitution);
      EXPECT_LE(s.max_energy_gain_j, 1e-9);
      if (!s.succeeded) continue;
      ++succeeded;
      const State end = s.motion->sample({s.motion->end_s()})[0];
      on_a_face += (end.orientation.conjugate() * kUp).cwiseAbs().maxCoeff() > 1.0 - 1e-6;
    } catch (const NoMotionError&) {  // the smallest beam may miss one
    }
  }
  // Rolling friction can hold a cube on its edge; no search may end so.
  EXPECT_EQ(on_a_face, succeeded);
  EXPECT_GE(succeeded, 14);  // each has a motion by construction
}

TEST(Search, SameBytesForAnyNumberOfThreadsAndAgain) {
  const Body body = cube();
  const Marks marks = of_a_throw(body, 1, 5);
  const Solution one = solve_forward(body, marks, first_rung(3, 1), nullptr);
  for (const int threads : {1, 2, 3})
    expect_same_bytes(one, solve_forward(body, marks, first_rung(3, threads), nullptr));
  // climbing from the first rung with no time left gives it too
  SolveOptions climbing = first_rung(3);
  climbing.rung = -1;
  climbing.time_budget_s = 1e-9;
  expect_same_bytes(one, solve_forward(body, marks, climbing, nullptr));
}

// A climb is made of its rungs, each of which depends on its beam alone.
TEST(Search, ClimbsTheLadderAskedFor) {
  const Body body = cube();
  int climbed_past_success = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Marks marks = of_a_throw(body, seed, 6);
    const int ladder[] = {6, 20, 60};
    std::vector<Solution> alone;
    for (const int beam : ladder) {
      SolveOptions options = first_rung();
      options.ladder = {beam};
      try {
        alone.push_back(solve_forward(body, marks, options, nullptr));
      } catch (const NoMotionError&) {
        break;
      }
    }
    if (alone.size() < std::size(ladder)) continue;
    for (const Goal goal : {Goal::plausible, Goal::succeeded})
      for (const int least : {0, 2}) {
        // what the description says, rung by rung
        std::size_t best = 0, k = 0;
        for (;; ++k) {
          if (k > 0 && better(alone[k], alone[best])) best = k;
          const bool content = goal == Goal::plausible ? alone[best].plausible : alone[best].succeeded;
          if (k + 1 == alone.size() || (content && static_cast<int>(k) >= least)) break;
        }
        SolveOptions options = first_rung();
        options.rung = -1;
        options.time_budget_s = 1e6;
        options.ladder.assign(std::begin(ladder), std::end(ladder));
        options.goal = goal;
        options.least_rung = least;
        const Solution s = solve_forward(body, marks, options, nullptr);
        EXPECT_EQ(s.rung, static_cast<int>(best));
        expect_same_bytes(s, alone[best]);
        climbed_past_success += best > 0 && alone[0].succeeded;
      }
  }
  EXPECT_GT(climbed_past_success, 0);  // or nothing above was a choice
}

TEST(Search, OtherSeedsFindOtherMotions) {
  const Body body = cube();
  const Marks marks = marks_at({0.2, 0.32, 0.4}, Ending::open);
  const Solution a = solve_forward(body, marks, first_rung(1), nullptr);
  const Solution b = solve_forward(body, marks, first_rung(2), nullptr);
  const double t = 0.3;
  EXPECT_GT((a.motion->sample({t})[0].velocity - b.motion->sample({t})[0].velocity).norm(), 1e-6);
}

// A ball that rebounds with e v leaves no choice but the first speed and up to 40 % of the impact's change.
TEST(Search, BallMeetsItsOwnBounces) {
  const Body ball = sample::ball(0.02, 0.03, {0.5, 0.3, 1e-3, 1e-3});
  const double first = 0.3;
  const Marks marks = marks_at({0.1, 0.1 + first, 0.1 + 1.5 * first, 0.1 + 1.75 * first}, Ending::open);
  const Solution s = solve_forward(ball, marks, first_rung(), nullptr);
  expect_honest(ball, marks, s);
  EXPECT_TRUE(s.plausible);
  // Its own bounces need no change of any impact.
  EXPECT_GT(s.score, 0.9);
}

TEST(Search, OpenEndingAsksNothingAfterTheLastMark) {
  const Body body = cube();
  const Marks marks = marks_at({0.3, 0.45, 0.55}, Ending::open);
  const Solution s = solve_forward(body, marks, first_rung(), nullptr);
  expect_honest(body, marks, s);
  EXPECT_TRUE(s.succeeded);
  EXPECT_GE(s.motion->end_s(), 0.55);
  EXPECT_LE(s.motion->end_s(), 0.55 + kOpenTail_s + 1e-9);
}

TEST(Search, OneMark) {
  const Body body = cube();
  for (const Ending ending : {Ending::open, Ending::rest}) {
    const Marks marks = marks_at({0.4}, ending);
    const Solution s = solve_forward(body, marks, first_rung(), nullptr);
    expect_honest(body, marks, s);
    EXPECT_TRUE(s.succeeded);
    EXPECT_EQ(s.events[0].achieved_s, 0.4);
    EXPECT_LT(s.motion->start_s(), 0.4);
    if (ending == Ending::open) {
      EXPECT_EQ(s.score, 1.0);  // free start, nothing changed
    }
  }
}

// A ball without restitution may leave the ground with 40 % of the speed it came with, and never with more
// than that of the flight before: a gap of 0.5 s after one of 0.1 s is out of reach. The best is shown all
// the same, and says so.
TEST(Search, ReportsTheMarkThatNoMotionReaches) {
  const Body ball = sample::ball(0.02, 0.03, {0.4, 0.3, 1e-3, 1e-3});
  const Marks marks = marks_at({0.2, 0.3, 0.8}, Ending::open);
  const Solution s = solve_forward(ball, marks, first_rung(), nullptr);
  expect_honest(ball, marks, s);
  EXPECT_FALSE(s.succeeded);
  EXPECT_FALSE(s.plausible);
  EXPECT_EQ(s.missed_hits, 1);
  EXPECT_NEAR(s.events[1].achieved_s, 0.3, 1e-9);
  EXPECT_GT(std::abs(s.events[2].error_s), 0.1);
  EXPECT_NEAR(s.events[2].achieved_s, 0.8 + s.events[2].error_retimed_s, 1e-15);
  EXPECT_LT(s.score, 0.3);
  EXPECT_GE(s.max_abs_error_s, std::abs(s.events[2].error_retimed_s));
}

// A ball bouncing up: each gap longer than the last one takes energy that only a gain allows.
TEST(Search, EnergyGainAllowsLongerGaps) {
  const Body ball = sample::ball(0.02, 0.03, {0.9, 0.3, 1e-4, 1e-4});
  const Marks marks = marks_at({0.1, 0.3, 0.54}, Ending::open);
  // Leaving with g T / 2 after arriving with g T / 2 of the gap before: 0.5 m g^2 / 4 (T2^2 - T1^2) is
  // missing.
  const double missing = 0.125 * 0.03 * sample::kGravity * sample::kGravity * (0.24 * 0.24 - 0.2 * 0.2);
  SolveOptions options = first_rung();
  double without = 0.0;
  try {
    without = solve_forward(ball, marks, options, nullptr).max_energy_gain_j;
  } catch (const NoMotionError&) {
  }
  EXPECT_LE(without, 1e-12);
  options.energy_gain_j = 1.5 * missing;
  const Solution s = solve_forward(ball, marks, options, nullptr);
  expect_honest(ball, marks, s);
  EXPECT_TRUE(s.plausible);
  EXPECT_LE(s.max_energy_gain_j, options.energy_gain_j + 1e-12);
  EXPECT_GT(s.max_energy_gain_j, 0.3 * missing);
}

TEST(Search, FitChoosesAMaterialAndSaysWhich) {
  const Body ball = sample::ball(0.02, 0.03, {0.2, 0.3, 1e-4, 1e-4});
  const Marks marks = marks_at({0.1, 0.35, 0.5, 0.59}, Ending::open);  // gaps shrink by 0.6
  SolveOptions options = first_rung();
  options.fit_material = true;
  const Solution s = solve_forward(ball, marks, options, nullptr);
  EXPECT_TRUE(s.plausible);
  EXPECT_NEAR(s.restitution, 0.6, 0.16);
  EXPECT_EQ(s.restitution, s.motion->body().material().restitution);
  EXPECT_EQ(s.friction, 0.3);
}

TEST(Search, CancelStopsIt) {
  const Body body = cube();
  const Marks marks = of_a_throw(body, 2, 6);
  Progress progress;
  progress.cancel();
  EXPECT_THROW(solve_forward(body, marks, {}, &progress), Cancelled);
  Progress later;
  std::thread other([&] {
    while (later.fraction() == 0.0) std::this_thread::yield();
    later.cancel();
  });
  SolveOptions large;
  large.rung = rung_count() - 1;
  EXPECT_THROW(solve_forward(body, marks, large, &later), Cancelled);
  other.join();
}

TEST(Search, ProgressRisesToOne) {
  const Body body = cube();
  const Marks marks = of_a_throw(body, 2, 6);
  Progress progress;
  std::atomic<bool> done = false;
  std::vector<double> seen;
  std::thread watcher([&] {
    while (!done.load()) {
      const double now = progress.fraction();
      if (seen.empty() || now != seen.back()) seen.push_back(now);
      std::this_thread::yield();
    }
  });
  solve_forward(body, marks, first_rung(), &progress);
  EXPECT_EQ(progress.fraction(), 1.0);
  done = true;
  watcher.join();
  EXPECT_TRUE(std::ranges::is_sorted(seen));
}

// A motion begins so long before the first mark as asked, with flight backwards from it, but not with the
// contact before, nor (0.1 s aside) before the sound. What comes after does not depend on it.
TEST(Search, LeadInIsAsLongAsAskedOrClear) {
  const Body body = cube();
  const auto clear_until = [&](const Motion& motion) {  // just before it began: is the ground near?
    const Node& first = motion.nodes().front();
    State reversed = first.state;
    reversed.velocity = -reversed.velocity;
    reversed.angular_velocity = -reversed.angular_velocity;
    Flight flight(body);
    flight.start(reversed, sample::downwards());
    return flight.next_contact(10.0);
  };
  int short_of_it = 0;
  for (const double first_s : {0.02, 0.3, 3.0}) {
    const Marks marks = marks_at({first_s, first_s + 0.12, first_s + 0.2}, Ending::open);
    std::vector<Solution> solutions;
    for (const double lead_in_s : {0.01, 0.1, 0.5, 2.5}) {
      SolveOptions options = first_rung();
      options.lead_in_s = lead_in_s;
      const Solution s = solve_forward(body, marks, options, nullptr);
      expect_honest(body, marks, s);
      const double wanted = std::min(lead_in_s, std::max(first_s, 0.1));
      const double lead = marks.times_s[0] - s.motion->start_s();
      EXPECT_LE(lead, wanted + 1e-12);
      if (lead < wanted - 1e-12) {
        ++short_of_it;
        EXPECT_LT(clear_until(*s.motion), 2e-3 * (lead + 0.01));  // a thousandth of the lead is left
      }
      EXPECT_EQ(s.motion->nodes().front().phase, Phase::flight);
      for (const double t : {marks.times_s[0], marks.times_s[1], s.motion->end_s()}) {
        const State here = s.motion->sample({t})[0];
        if (solutions.empty()) continue;
        const State there = solutions.front().motion->sample({t})[0];
        EXPECT_EQ(here.position, there.position);
        EXPECT_EQ(here.velocity, there.velocity);
      }
      solutions.push_back(s);
    }
  }
  EXPECT_GT(short_of_it, 0);
}

TEST(Search, BadOptionsAreNamed) {
  const Marks marks = marks_at({0.3});
  const auto message = [&](const SolveOptions& options, const Marks& m) {
    try {
      solve_forward(cube(), m, options, nullptr);
    } catch (const ArgumentError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  SolveOptions o = first_rung();
  o.time_budget_s = 0.0;
  EXPECT_EQ(message(o, marks).rfind("time_budget_s:", 0), 0u);
  o.time_budget_s = std::nan("");
  EXPECT_EQ(message(o, marks).rfind("time_budget_s:", 0), 0u);
  o = first_rung();
  o.energy_gain_j = -1.0;
  EXPECT_EQ(message(o, marks).rfind("energy_gain_j:", 0), 0u);
  o.energy_gain_j = std::nan("");
  EXPECT_EQ(message(o, marks).rfind("energy_gain_j:", 0), 0u);
  o = first_rung();
  o.rung = rung_count();
  EXPECT_EQ(message(o, marks).rfind("rung:", 0), 0u);
  for (const auto& ladder : std::vector<std::vector<int>>{{0, 10}, {10, 10}, {20, 10}, {1'000'000}}) {
    o = first_rung();
    o.ladder = ladder;
    EXPECT_EQ(message(o, marks).rfind("ladder:", 0), 0u);
  }
  for (const int least : {-1, rung_count()}) {
    o = first_rung();
    o.least_rung = least;
    EXPECT_EQ(message(o, marks).rfind("least_rung:", 0), 0u);
  }
  o = first_rung();
  o.takes = 0;
  EXPECT_EQ(message(o, marks).rfind("takes:", 0), 0u);
  for (const double lead_in_s : {0.0, -1.0, std::nan("")}) {
    o = first_rung();
    o.lead_in_s = lead_in_s;
    EXPECT_EQ(message(o, marks).rfind("lead_in_s:", 0), 0u);
  }
  EXPECT_NE(message(first_rung(), marks_at({0.3, 0.305})).find("mark 2"), std::string::npos);
  EXPECT_NE(message(first_rung(), marks_at({})).find("mark"), std::string::npos);
}

TEST(Better, PlausibleBeforeSucceededBeforeScore) {
  Solution plausible, succeeded, failed;
  plausible.plausible = plausible.succeeded = succeeded.succeeded = true;
  plausible.score = 0.4;
  succeeded.score = 0.5;
  failed.score = 0.9;
  EXPECT_TRUE(better(plausible, succeeded));
  EXPECT_TRUE(better(succeeded, failed));
  EXPECT_FALSE(better(failed, plausible));
  Solution higher = plausible;
  higher.score = 0.41;
  EXPECT_TRUE(better(higher, plausible));
  EXPECT_FALSE(better(plausible, plausible));
}

}  // namespace
}  // namespace ifa
