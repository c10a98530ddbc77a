#include "ifa/forward/estimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ifa/base/error.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::kGravity;

Marks marks_at(std::vector<double> times_s, Ending ending = Ending::open) {
  Marks marks;
  marks.times_s = std::move(times_s);
  marks.durations_s.assign(marks.size(), 0.0);
  marks.centroids_s.assign(marks.size(), std::numeric_limits<double>::quiet_NaN());
  marks.ending = ending;
  return marks;
}

Marks marks_of_gaps(const std::vector<double>& gaps_s, Ending ending = Ending::open) {
  std::vector<double> times{0.25};
  for (const double gap : gaps_s) times.push_back(times.back() + gap);
  return marks_at(times, ending);
}

std::vector<std::string> texts(const Estimate& e) {
  std::vector<std::string> out;
  for (const Finding& f : e.findings) out.push_back(std::to_string(f.mark + 1) + ": " + f.text);
  return out;
}

// A ball dropped from 0.5 m: bounce k lasts 2 e^k sqrt(2 h / g) and reaches e^2k h.
TEST(Estimate, OfABouncingBallIsExact) {
  const double height_m = 0.5, mass_kg = 0.02;
  const Body ball = sample::ball(0.02, mass_kg, {0.1, 0.4, 0.0, 0.0});
  for (const double e : {0.3, 0.5, 0.85, 1.0}) {
    std::vector<double> gaps;
    for (int k = 1; k <= 8; ++k) gaps.push_back(2.0 * std::pow(e, k) * std::sqrt(2.0 * height_m / kGravity));
    const Estimate got = estimate(ball, marks_of_gaps(gaps));
    EXPECT_TRUE(got.ball);
    EXPECT_TRUE(got.restitution_from_gaps);
    // times of some seconds are rounded to 4e-16 s, gaps of 0.06 ms and more to 1e-11 of themselves, and the
    // sum of all gaps to 1e-14
    EXPECT_NEAR(got.restitution, e, 1e-12);
    EXPECT_EQ(got.friction, 0.4);
    for (int k = 1; k <= 8; ++k) {
      const GapEstimate& gap = got.gaps[k - 1];
      const double apex_m = std::pow(e, 2 * k) * height_m;
      EXPECT_NEAR(gap.apex_m, apex_m, 1e-10 * apex_m);
      EXPECT_NEAR(gap.takeoff_speed_m_s, std::sqrt(2.0 * kGravity * apex_m), 1e-10 * gap.takeoff_speed_m_s);
      EXPECT_NEAR(gap.energy_j, mass_kg * kGravity * apex_m, 1e-10 * gap.energy_j);
      // no pose matters
      EXPECT_EQ(gap.apex_range_m.least, gap.apex_m);
      EXPECT_EQ(gap.apex_range_m.most, gap.apex_m);
      EXPECT_EQ(gap.most_energy_j, gap.energy_j);
      EXPECT_NEAR(gap.needed_j, gap.energy_j, 1e-10 * gap.energy_j);  // what comes later is lower
      EXPECT_EQ(gap.surplus_j, 0.0);
    }
    EXPECT_TRUE(got.findings.empty());
  }
}

TEST(Estimate, CentreHeightsOfABoxABallAndACoin) {
  const Range box = estimate(sample::box({0.06, 0.04, 0.02}, 1.0), marks_at({0.0})).centre_height_m;
  EXPECT_NEAR(box.least, 0.01, 1e-15);
  EXPECT_NEAR(box.most, 0.5 * std::sqrt(0.06 * 0.06 + 0.04 * 0.04 + 0.02 * 0.02), 1e-15);
  const Range ball = estimate(sample::ball(0.03, 1.0), marks_at({0.0})).centre_height_m;
  EXPECT_EQ(ball.least, 0.03);
  EXPECT_EQ(ball.most, 0.03);
  const Range coin = estimate(sample::coin(), marks_at({0.0})).centre_height_m;
  EXPECT_NEAR(coin.least, 1.1e-3, 1e-15);  // flat
  EXPECT_NEAR(coin.most, 0.2e-3 + std::hypot(12.675e-3, 0.9e-3), 1e-15);
  EXPECT_FALSE(estimate(sample::coin(), marks_at({0.0})).ball);
}

// The engine's own flights from impact to impact keep within what is said of gaps of their length.
TEST(Estimate, SimulatedFlightsAreWithinTheRanges) {
  const Body body = sample::box({0.03, 0.02, 0.012}, 0.02, sample::ideal(0.7, 0.3));
  RandomStream random(8, 0);
  int flights = 0;
  double low_share = 1.0, high_share = 0.0;
  for (int n = 0; n < 100; ++n) {
    const ifa::Run run = simulate(body, sample::random_state(body, random, 0.1, 1.0, 30.0), {}, 2.0);
    for (std::size_t i = 1; i + 1 < run.nodes.size(); ++i) {
      const Node &a = run.nodes[i], &b = run.nodes[i + 1];
      if (a.phase != Phase::flight || b.time_s - a.time_s < 1e-3) continue;
      const Estimate e = estimate(body, marks_at({a.time_s, b.time_s}));
      const GapEstimate& gap = e.gaps[0];
      const double v = a.state.velocity.z(), above_m = a.state.position.z() - e.centre_height_m.least;
      const double energy_j = body.mass_kg() * (0.5 * v * v + kGravity * above_m);
      constexpr double kSlack = 1e-9;  // contacts are found to 1e-12 m, over 1 ms a speed to 1e-9 m/s
      EXPECT_GE(above_m, -kSlack);
      EXPECT_GE(v, gap.takeoff_speed_range_m_s.least - kSlack);
      EXPECT_LE(v, gap.takeoff_speed_range_m_s.most + kSlack);
      EXPECT_GE(energy_j, gap.energy_j - kSlack);
      EXPECT_LE(energy_j, gap.most_energy_j + kSlack);
      const double share = (energy_j - gap.energy_j) / (gap.most_energy_j - gap.energy_j);
      low_share = std::min(low_share, share);
      high_share = std::max(high_share, share);
      ++flights;
    }
  }
  EXPECT_GT(flights, 500);
  EXPECT_LT(low_share, 0.2);  // the range is not much wider than what happens
  EXPECT_GT(high_share, 0.7);
}

TEST(Estimate, NamesAPauseThatNeedsTooHighAFlight) {
  const Body die = sample::box({0.016, 0.016, 0.016}, 0.005);
  const Estimate e = estimate(die, marks_at({0.25, 60.25, 60.3}));
  EXPECT_NEAR(e.gaps[0].apex_m, kGravity * 3600.0 / 8.0, 1e-9);  // 4414.5 m, to rounding
  EXPECT_EQ(texts(e), std::vector<std::string>{"2: the gap before it needs an apex of 4.4 km if the body "
                                               "flies, and a take-off at 290 m/s"});
  // the paper's fastest throw, 4 m/s, flies for 0.8155 s; the pose may change 3 mm of 815
  EXPECT_TRUE(estimate(die, marks_at({0.0, 0.81})).findings.empty());
  EXPECT_EQ(texts(estimate(die, marks_at({0.0, 0.82}))),
            std::vector<std::string>{
                "2: the gap before it needs an apex of 820 mm if the body flies, and a take-off at 4 m/s"});
}

TEST(Estimate, NamesAGapThatGrows) {
  const double mass_kg = 0.005;
  const Body die = sample::box({0.016, 0.016, 0.016}, mass_kg);
  const std::vector<double> gaps{0.1, 0.18, 0.18};
  // by hand: 0.18 s take m g^2 T^2 / 8, and 0.1 s have had m g (R - r) more at most, each 7 % off
  const double spread_m = 0.008 * (std::sqrt(3.0) - 1.0);
  const double surplus_j =
      mass_kg *
      (kGravity * kGravity / 8.0 * (std::pow(0.18 / 1.07, 2) - std::pow(0.107, 2)) - kGravity * spread_m);
  const Estimate e = estimate(die, marks_of_gaps(gaps));
  EXPECT_NEAR(e.gaps[1].surplus_j, surplus_j, 1e-15);  // some roundings of 1e-3
  EXPECT_EQ(e.gaps[0].surplus_j, 0.0);
  EXPECT_EQ(e.gaps[2].surplus_j, 0.0);
  EXPECT_EQ(e.gaps[0].needed_j, e.gaps[1].energy_j);
  EXPECT_EQ(texts(e), std::vector<std::string>{
                          "3: the gap before it is 1.8 times as long as the one before that: if the body "
                          "flies, at least 730 uJ "
                          "must come from its spin or travel, or be given; it may also roll in between"});
  // A ball has no pose to take it from, and 1.07^2 = 1.145 is what retiming allows.
  const Body ball = sample::ball(0.02, mass_kg);
  EXPECT_EQ(texts(estimate(ball, marks_of_gaps({0.1, 0.12}))),
            std::vector<std::string>{
                "3: the gap before it is 1.2 times as long as the one before that: a ball's bounces do not "
                "grow, so "
                "at least 68 uJ must be given, or be taken from its travel by changing the impact"});
  EXPECT_TRUE(estimate(ball, marks_of_gaps({0.1, 0.1144})).findings.empty());
}

TEST(Estimate, NamesABounceThatIsMissingBeforeRest) {
  const Body ball = sample::ball(0.02, 0.01, {0.8, 0.3, 0.0, 0.0});
  const std::vector<double> gaps{0.5, 0.4, 0.32};
  const Estimate e = estimate(ball, marks_of_gaps(gaps, Ending::rest));
  EXPECT_FALSE(e.rest_is_near);
  EXPECT_NEAR(*e.next_gap_s, 0.256, 1e-14);
  EXPECT_EQ(texts(e),
            std::vector<std::string>{
                "4: if the body flies up to it, it lands at 1.6 m/s and bounces again for 260 ms, more than "
                "a plausible change of the impact takes away, but the ending asks for rest"});
  EXPECT_TRUE(estimate(ball, marks_of_gaps(gaps, Ending::open)).findings.empty());
  // By hand: at e = 0.8, 40 % of the change of velocity 1.8 v leave 0.08 v of a landing at v = g T / 2, and
  // 0.05 m/s are silent.
  const double silent_s = 2.0 * 0.05 / 0.08 / kGravity;
  for (const double share : {0.99, 1.01}) {
    const double last_s = share * silent_s;
    const Marks marks = marks_of_gaps({last_s / 0.64, last_s / 0.8, last_s}, Ending::rest);
    EXPECT_EQ(estimate(ball, marks).rest_is_near, share < 1.0);
  }
}

TEST(Estimate, ASpanIsNoFlight) {
  const Body die = sample::box({0.016, 0.016, 0.016}, 0.005);
  Marks marks = marks_at({0.1, 0.3, 0.5, 0.7}, Ending::rest);
  marks.durations_s = {0.05, 0.2, 0.0, 0.1};
  const Estimate e = estimate(die, marks);
  EXPECT_NEAR(e.gaps[0].flight_s, 0.15, 1e-15);
  EXPECT_NEAR(e.gaps[0].gap_s, 0.2, 1e-15);
  EXPECT_EQ(e.gaps[1].flight_s, 0.0);  // the span ends where the next mark is
  EXPECT_EQ(e.gaps[1].apex_range_m.most, 0.0);
  EXPECT_EQ(e.gaps[1].energy_j, 0.0);
  EXPECT_EQ(e.gaps[1].needed_j, e.gaps[2].energy_j);
  EXPECT_FALSE(e.gaps[1].ratio.has_value());
  EXPECT_FALSE(e.gaps[2].ratio.has_value());
  EXPECT_FALSE(e.next_gap_s.has_value());  // the last mark has a span in which to lose it
  EXPECT_TRUE(e.rest_is_near);
  EXPECT_TRUE(e.findings.empty());
}

TEST(Estimate, TakesTheBodysRestitutionWhereGapsShowNone) {
  const Body die = sample::box({0.016, 0.016, 0.016}, 0.005, {0.37, 0.2, 0.0, 0.0});
  for (const std::vector<double>& gaps :
       {std::vector<double>{}, std::vector<double>{0.1}, std::vector<double>{0.1, 0.2}}) {
    const Estimate e = estimate(die, marks_of_gaps(gaps));
    EXPECT_FALSE(e.restitution_from_gaps);
    EXPECT_EQ(e.restitution, 0.37);
    EXPECT_EQ(e.gaps.size(), gaps.size());
  }
  // The sum of Zeno's series after the longest gap; within what the hint was measured for.
  EXPECT_NEAR(estimate(die, marks_of_gaps({0.05, 0.2, 0.1, 0.05, 0.03})).restitution, 0.18 / 0.38, 1e-14);
  EXPECT_EQ(estimate(die, marks_of_gaps({60.0, 0.1})).restitution, 0.2);
  EXPECT_EQ(estimate(die, marks_of_gaps(std::vector<double>(499, 0.1))).restitution, 0.8);
}

TEST(Estimate, GravityCountsAlongTheNormal) {
  const Body ball = sample::ball(0.02, 0.01);
  const Marks marks = marks_at({0.0, 0.4});
  const GapEstimate tilted = estimate(ball, marks, {3.0, 0.0, -2.0}).gaps[0];
  EXPECT_DOUBLE_EQ(tilted.takeoff_speed_m_s, 0.4);
  EXPECT_DOUBLE_EQ(tilted.apex_m, 0.04);
  EXPECT_THROW(estimate(ball, marks, {0.0, 0.0, 0.0}), ArgumentError);
  EXPECT_THROW(estimate(ball, marks, {0.0, 0.0, 9.81}), ArgumentError);
  EXPECT_THROW(estimate(ball, marks, {0.0, std::nan(""), -9.81}), ArgumentError);
}

TEST(Estimate, RefusesWhatItCannotCompute) {
  const Body ball = sample::ball(0.02, 0.01);
  EXPECT_THROW(estimate(ball, marks_at({})), ArgumentError);
  EXPECT_THROW(estimate(ball, marks_at({0.3, 0.2})), ArgumentError);
  EXPECT_NO_THROW(estimate(ball, marks_at({0.0, 0.005})));  // the merge gap is not its business
  try {
    estimate(ball, marks_at({0.0, 0.2, 1e200}));
    FAIL();
  } catch (const ArgumentError& error) {
    EXPECT_STREQ(error.what(), "mark 3 (1e+200 s): the gap before it is too long to compute with");
  }
}

}  // namespace
}  // namespace ifa
