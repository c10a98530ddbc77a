#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numeric>
#include <thread>

#include "ifa/base/error.hpp"
#include "ifa/forward/report.hpp"
#include "ifa/forward/solve.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

Body cube() { return sample::box({0.016, 0.016, 0.016}, 0.005); }

Marks marks_at(std::vector<double> times, Ending ending = Ending::rest) {
  Marks m;
  m.durations_s.assign(times.size(), 0.0);
  m.centroids_s.assign(times.size(), std::nan(""));
  m.times_s = std::move(times);
  m.ending = ending;
  return m;
}

// Of a throw: when its audible hits came, those less than 10 ms after another left out. The body comes to
// rest after the last of them, so some motion meets the marks exactly.
Marks of_a_throw(const Body& body, std::uint64_t seed, std::size_t most) {
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

// What must hold of any solution, from its motion alone.
void expect_honest(const Body& body, const Marks& marks, const Solution& s) {
  ASSERT_EQ(s.events.size(), marks.size());
  // Its own hits: each mark is met by the first of a chain, and nothing else sounds.
  std::vector<double> onsets;
  double last = -1e9;
  for (const Hit& hit : s.motion->hits()) {
    if (hit.approach_speed_m_s < 0.05) continue;
    // chains are judged before retiming
    const double simulated = s.motion->time().to_simulated(hit.time_s);
    if (simulated - last >= 0.010) onsets.push_back(hit.time_s);
    last = simulated;
  }
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
      EXPECT_GT((end.orientation.conjugate() * kUp).cwiseAbs().maxCoeff(), 1.0 - 1e-6);  // on a face
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

void expect_same_bytes(const Solution& a, const Solution& b) {
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

SolveOptions first_rung(std::uint64_t seed = 0, int threads = 2) {
  SolveOptions o;
  o.rung = 0;
  o.seed = seed;
  o.threads = threads;
  return o;
}

TEST(Search, MeetsTheMarksOfAThrow) {
  const Body body = cube();
  int succeeded = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Marks marks = of_a_throw(body, seed, 6);
    try {
      const Solution s = solve_forward(body, marks, first_rung(), nullptr);
      expect_honest(body, marks, s);
      EXPECT_EQ(s.rung, 0);
      EXPECT_GT(s.simulated_s, 0.0);
      EXPECT_EQ(s.restitution, body.material().restitution);
      EXPECT_LE(s.max_energy_gain_j, 1e-9);
      succeeded += s.succeeded;
    } catch (const NoMotionError&) {  // the smallest beam may miss one
    }
  }
  EXPECT_GE(succeeded, 3);  // each has a motion by construction
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

TEST(Search, ProgressEndsAtOne) {
  Progress progress;
  solve_forward(cube(), marks_at({0.3, 0.45}, Ending::open), first_rung(), &progress);
  EXPECT_EQ(progress.fraction(), 1.0);
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
