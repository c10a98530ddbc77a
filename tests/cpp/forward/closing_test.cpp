#include "ifa/forward/closing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

// A ball that has come down at 2 m/s and leaves at 1 m/s, or at 1 m/s and what a change adds; the impact's
// velocity change of 3 m/s makes the plausible region 1.2 m/s high. A flight that leaves at v takes 2 v / g.
constexpr double kHalfHeight_m_s = 0.4 * 3.0;

class BallAtItsFirstMark : public ::testing::Test {
 protected:
  explicit BallAtItsFirstMark(double target_s = 0.24) {
    marks_.times_s = {0.1, 0.1 + target_s};
    marks_.durations_s = {0.0, 0.0};
    marks_.centroids_s = {std::nan(""), std::nan("")};
    marks_.ending = Ending::open;
    State before;
    before.position.z() = 0.02;
    before.velocity.z() = -2.0;
    Candidate candidate;
    candidate.onset = strike(bodies_[0], physics_, before);
    candidates_.assign(2, candidate);
  }

  Trial tried(const Vec6& y, std::size_t candidate = 0) {
    auto trial = trials_.propose(candidates_, candidate, y, 1.0);
    EXPECT_TRUE(trial);
    trials_.run(candidates_, 0, {&*trial, 1});
    return *trial;
  }

  double target_s() const { return problem_.target_s(0); }
  static double flight_s(const State& after) { return 2.0 * after.velocity.z() / sample::kGravity; }

  std::vector<Body> bodies_{sample::ball(0.02, 0.03)};
  SearchPhysics physics_;
  Marks marks_;
  Problem problem_{bodies_, physics_, marks_};
  Trials trials_{problem_, 0, nullptr};
  std::vector<Candidate> candidates_;
};

TEST_F(BallAtItsFirstMark, ProposalsAreTheRegionsPointsAndKeepTheEnergy) {
  const auto up = trials_.propose(candidates_, 0, Vec6(0.5 * Vec6::Unit(0)), 1.0);
  ASSERT_TRUE(up);
  EXPECT_NEAR(up->after.velocity.z(), 1.0 + 0.5 * kHalfHeight_m_s, 1e-15);
  EXPECT_EQ(up->excess, 0.25);
  // Leaving faster than it came, 2 m/s, is not for a body without a motor.
  EXPECT_TRUE(trials_.propose(candidates_, 0, Vec6(0.83 * Vec6::Unit(0)), 1.0));
  EXPECT_FALSE(trials_.propose(candidates_, 0, Vec6(0.84 * Vec6::Unit(0)), 1.0));
  // Into the ground: it does not bounce at all, which is the change that counts.
  const auto down = trials_.propose(candidates_, 0, Vec6(-0.9 * Vec6::Unit(0)), 1.0);
  ASSERT_TRUE(down);
  EXPECT_NEAR(down->after.velocity.z(), 0.0, 1e-12);
  EXPECT_NEAR(down->excess, std::pow(1.0 / kHalfHeight_m_s, 2), 1e-12);
  EXPECT_FALSE(trials_.propose(candidates_, 0, Vec6(-0.9 * Vec6::Unit(0)), 0.5));
}

TEST_F(BallAtItsFirstMark, LatenessIsThatOfTheNextHit) {
  const Trial trial = tried(Vec6::Zero());
  EXPECT_TRUE(trial.meets);
  EXPECT_NEAR(trial.lateness_s, 2.0 / sample::kGravity - target_s(), 1e-12);
  const Trial late = tried(Vec6(0.8 * Vec6::Unit(0)));  // 0.4 s, followed for 1.35 x 0.24 s
  EXPECT_FALSE(late.meets);
  EXPECT_EQ(late.lateness_s, kNever);
}

TEST_F(BallAtItsFirstMark, ClosesInOnTheMark) {
  RandomStream random(21, 0);
  std::vector<Trial> tries;
  for (std::size_t candidate = 0; candidate < 2; ++candidate)
    for (int i = 0; i < 30; ++i) {
      const auto trial = trials_.propose(candidates_, candidate, random_change(1.0, random), 1.0);
      if (trial) tries.push_back(*trial);
    }
  trials_.run(candidates_, 0, tries);
  std::vector<char> used(tries.size(), 0);
  auto closings = enclose(problem_, tries, candidates_, 0, 5, used);
  ASSERT_EQ(closings.size(), 10u);
  const std::vector<Closing> before = closings;
  close_in(trials_, candidates_, 0, 1.0, closings);
  for (std::size_t i = 0; i < closings.size(); ++i) {
    const Closing& closing = closings[i];
    EXPECT_FALSE(closing.open);  // it found the mark, or left what is allowed
    const Trial& best = closing.best;
    ASSERT_TRUE(best.meets);
    EXPECT_EQ(best.candidate, before[i].best.candidate);
    EXPECT_NEAR(best.passage.interval_s, flight_s(best.after), 1e-12);
    // In time, or so mild that being late costs less than any change would.
    const auto cost = [&](const Trial& t) {
      return t.excess - std::log(time_factor(t.passage.interval_s, target_s()));
    };
    EXPECT_LE(cost(best), cost(before[i].best) + 1e-15);
    const bool in_time = std::abs(best.lateness_s) <= 1e-4 * target_s();
    if (in_time) {
      EXPECT_NEAR(best.after.velocity.z(), 0.5 * sample::kGravity * target_s(),
                  0.5 * sample::kGravity * 1e-4 * target_s());
    } else {
      EXPECT_EQ(cost(best), cost(before[i].best));
    }
    // On the segment between the two it began with.
    const double x = (best.y - closing.from).dot(closing.along) / closing.along.squaredNorm();
    EXPECT_TRUE(x >= -1e-12 && x <= 1.0 + 1e-12);
    EXPECT_LE((closing.from + x * closing.along - best.y).norm(), 1e-12);
  }
  const auto in_time = [&](const Closing& c) { return std::abs(c.best.lateness_s) <= 1e-4 * target_s(); };
  EXPECT_GT(std::ranges::count_if(closings, in_time), 5);
}

// The slope of the lateness, where it is known, is 2 / g times the vertical change along the line.
TEST_F(BallAtItsFirstMark, SlopeIsThatOfTheParabola) {
  std::vector<Trial> tries{tried(Vec6(-0.1 * Vec6::Unit(0))), tried(Vec6(0.8 * Vec6::Unit(0)))};
  ASSERT_EQ(tries[1].lateness_s, kNever);  // so the first value is a halving, and a second is needed
  std::vector<char> used(2, 0);
  auto closings = enclose(problem_, tries, std::span(candidates_).first(1), 0, 1, used);
  ASSERT_EQ(closings.size(), 1u);
  close_in(trials_, candidates_, 0, 1.0, closings);
  const double slope = 2.0 / sample::kGravity * kHalfHeight_m_s * 0.9;
  EXPECT_NEAR(closings[0].slope_s, slope, 1e-9 * slope);  // 1e-12 s of rounding over a step of some ms
  EXPECT_LE(std::abs(closings[0].best.lateness_s), 1e-4 * target_s());
  const auto anchors = anchors_of(closings, target_s(), kPlausible);
  ASSERT_EQ(anchors.size(), 1u);
  EXPECT_EQ(anchors[0].slope_s, closings[0].slope_s);
  Closing unknown = closings[0], off = closings[0], missed = closings[0];
  unknown.slope_s = 0.0;
  off.best.passage.interval_s = 1.08 * target_s();
  missed.best.excess = kNever;
  EXPECT_TRUE(anchors_of({unknown, off, missed}, target_s(), kPlausible).empty());
}

// Two finite ends of a parabola's line: the first value already hits, and the slope is known all the same.
TEST_F(BallAtItsFirstMark, SlopeIsKnownWhereTheFirstValueHits) {
  std::vector<Trial> tries{tried(Vec6(-0.1 * Vec6::Unit(0))), tried(Vec6(0.4 * Vec6::Unit(0)))};
  ASSERT_LT(tries[0].lateness_s, 0.0);
  ASSERT_GT(tries[1].lateness_s, 0.0);
  ASSERT_NE(tries[1].lateness_s, kNever);
  std::vector<char> used(2, 0);
  auto closings = enclose(problem_, tries, std::span(candidates_).first(1), 0, 1, used);
  ASSERT_EQ(closings.size(), 1u);
  close_in(trials_, candidates_, 0, 1.0, closings);
  const double slope = 2.0 / sample::kGravity * kHalfHeight_m_s * 0.5;
  EXPECT_NEAR(closings[0].slope_s, slope, 1e-9 * slope);  // 1e-12 s of rounding over a step of some ms
  EXPECT_LE(std::abs(closings[0].best.lateness_s), 1e-4 * target_s());
  EXPECT_EQ(anchors_of(closings, target_s(), kPlausible).size(), 1u);
}

// Variants leave in other directions and with other spins, all of them as high as the mark asks.
TEST_F(BallAtItsFirstMark, VariantsAreInTimeAndWithinTheRegion) {
  const double y0 = (0.5 * sample::kGravity * target_s() - 1.0) / kHalfHeight_m_s;
  Vec6 along = Vec6::Unit(0);
  along[4] = 0.3;  // a line that also turns it
  const Anchor anchor{tried(Vec6(y0 * Vec6::Unit(0))), along, 2.0 / sample::kGravity * kHalfHeight_m_s};
  const std::vector<Anchor> anchors{anchor};
  for (const Tolerance& tolerance : {kPlausible, kTolerable}) {
    std::vector<RandomStream> random{{22, 0}, {22, 1}}, again = random;
    const auto variants = vary(trials_, candidates_, 0, tolerance, anchors, 200, random);
    const auto same = vary(trials_, candidates_, 0, tolerance, anchors, 200, again);
    ASSERT_EQ(variants.size(), same.size());
    int in_time = 0;
    Vec6 spread = Vec6::Zero();
    for (std::size_t i = 0; i < variants.size(); ++i) {
      const Trial& v = variants[i].trial;
      EXPECT_EQ(v.y, same[i].trial.y);
      EXPECT_LE(v.excess, tolerance.excess);
      EXPECT_LE(v.y.norm(), 0.98 * std::sqrt(tolerance.excess) + 1e-12);
      EXPECT_LE(sample::kinetic(bodies_[0], v.after),
                sample::kinetic(bodies_[0], candidates_[0].onset.before));
      in_time += v.meets && std::abs(v.lateness_s) <= 1e-4 * target_s();
      if (v.meets) {
        EXPECT_NEAR(v.passage.interval_s, flight_s(v.after), 1e-12);
      }
      spread += (v.y - anchor.trial.y).cwiseAbs2();
    }
    EXPECT_GT(variants.size(), 150u);
    // The correction is exact unless it would leave the region.
    EXPECT_GT(in_time, static_cast<int>(0.9 * static_cast<double>(variants.size())));
    for (int axis = 1; axis < 6; ++axis) EXPECT_GT(spread[axis], 0.0) << axis;
  }
}

// From near the edge of the region most ways aside lead out of it; they are cut short there.
TEST_F(BallAtItsFirstMark, VariantsOfAnAnchorAtTheEdgeStayWithin) {
  Vec6 y = Vec6::Zero();
  y[0] = (0.5 * sample::kGravity * target_s() - 1.0) / kHalfHeight_m_s;
  y[1] = y[4] = 0.67;
  const std::vector<Anchor> anchors{
      {tried(y), Vec6(Vec6::Unit(0)), 2.0 / sample::kGravity * kHalfHeight_m_s}};
  ASSERT_GT(y.norm(), 0.95);
  std::vector<RandomStream> random{{25, 0}, {25, 1}};
  const auto variants = vary(trials_, candidates_, 0, kPlausible, anchors, 200, random);
  int at_edge = 0;
  for (const Anchor& v : variants) {
    EXPECT_LE(v.trial.excess, 1.0);
    EXPECT_LE(v.trial.y.norm(), 0.98 + 1e-12);
    at_edge += v.trial.y.norm() > 0.98 - 1e-12;
  }
  EXPECT_GT(at_edge, 20);
}

// Throws of a box whose first event is an interval of contact, and shall last a fifth longer than physics has
// it: what is found is within the region and on time as before, and nearer to that length than any that the
// fit began with.
TEST(FitLength, ComesNearerToTheMarksLength) {
  const std::vector<Body> bodies{sample::box({0.03, 0.02, 0.012}, 0.01)};
  SearchPhysics physics;
  physics.hearing.events = Events::contact;
  int throws = 0, nearer = 0;
  for (std::uint64_t i = 0; throws < 12; ++i) {
    RandomStream random(26, i);
    State before = sample::random_state(bodies[0], random, 0.0, 1.5, 20.0);
    before.velocity.z() = -random.uniform(0.5, 1.5);
    Candidate candidate;
    candidate.onset = strike(bodies[0], physics, before);
    Record record;
    const Passage own =
        record_passage(bodies[0], physics, {candidate.onset.hit, candidate.onset.after, 0.0, 1.0}, record);
    if (own.next != Next::hit || own.event.length_s < 0.02) continue;
    Marks marks;
    marks.times_s = {0.1, 0.1 + 1.02 * own.interval_s};
    marks.durations_s = {1.2 * own.event.length_s, 0.0};
    marks.centroids_s = {std::nan(""), std::nan("")};
    marks.ending = Ending::open;
    const Problem problem{bodies, physics, marks};
    Trials trials(problem, 0, nullptr);
    const std::vector<Candidate> candidates{candidate};
    std::vector<Trial> tries;
    for (int t = 0; t < 30; ++t)
      if (const auto trial = trials.propose(candidates, 0, random_change(1.0, random), 1.0))
        tries.push_back(*trial);
    trials.run(candidates, 0, tries);
    std::vector<char> used(tries.size(), 0);
    auto closings = enclose(problem, tries, candidates, 0, 3, used);
    close_in(trials, candidates, 0, 1.0, closings);
    const auto anchors = anchors_of(closings, problem.target_s(0), kPlausible);
    if (anchors.empty()) continue;
    ++throws;
    const auto found = fit_length(trials, candidates, 0, kPlausible, anchors, {&random, 1});
    const auto off_s = [&](const std::vector<Anchor>& all) {
      double least = kNever;
      for (const Anchor& a : all)
        if (a.trial.meets && std::abs(a.trial.lateness_s) <= 0.07 * problem.target_s(0))
          least = std::min(least, std::abs(a.trial.passage.event.length_s - marks.durations_s[0]));
      return least;
    };
    for (const Anchor& a : found) {
      EXPECT_LE(a.trial.excess, 1.0);
      EXPECT_EQ(a.trial.candidate, 0u);
    }
    nearer += off_s(found) < off_s(anchors);
  }
  EXPECT_GE(nearer, 9);  // the length jumps where another corner strikes: not always
}

// Trials made up: each candidate's early and late ones, mildest with mildest.
TEST(Enclose, PairsTheMildestEarlyAndLateOfEachCandidate) {
  constexpr double kTarget_s = 0.2;
  const std::vector<Body> bodies{sample::ball(0.02, 0.03)};
  const SearchPhysics physics;
  Marks marks;
  marks.times_s = {0.0, kTarget_s};
  marks.durations_s = {0.0, 0.0};
  marks.centroids_s = {std::nan(""), std::nan("")};
  const Problem problem{bodies, physics, marks};
  for (std::uint64_t i = 0; i < 100; ++i) {
    RandomStream random(23, i);
    constexpr std::size_t kCandidates = 4;
    std::vector<Trial> trials;
    for (int t = 0; t < 40; ++t) {
      Trial trial;
      trial.candidate = static_cast<std::size_t>(random.uniform(0.0, kCandidates));
      trial.y[0] = t;  // its name
      trial.excess = random.uniform();
      trial.passage.next = random.uniform() < 0.3 ? Next::rest : Next::hit;
      trial.passage.interval_s = kTarget_s * random.uniform(0.9, 1.1);
      trial.meets = trial.passage.next == Next::hit;
      trial.lateness_s = trial.meets ? trial.passage.interval_s - kTarget_s : kNever;
      trials.push_back(trial);
    }
    const std::size_t most = 1 + i % 4;
    std::vector<char> used(trials.size(), 0);
    const std::vector<Candidate> candidates(kCandidates);
    const auto closings = enclose(problem, trials, candidates, 0, most, used);
    std::vector<std::size_t> pairs(kCandidates, 0);
    std::set<std::size_t> ends;
    for (const Closing& closing : closings) {
      const auto a = static_cast<std::size_t>(closing.from[0]);
      const auto b = static_cast<std::size_t>(closing.from[0] + closing.along[0]);
      const Trial &early = trials[a], &late = trials[b];
      EXPECT_LT(early.lateness_s, 0.0);
      EXPECT_GE(late.lateness_s, 0.0);
      ASSERT_EQ(early.candidate, late.candidate);
      EXPECT_EQ(closing.best.candidate, early.candidate);
      EXPECT_TRUE(ends.insert(a).second && ends.insert(b).second);  // each once
      EXPECT_TRUE(used[a] && used[b]);
      EXPECT_TRUE(closing.open);
      EXPECT_EQ(closing.bracket.width(), 1.0);
      // As mild as any that was left for it.
      const std::size_t before = pairs[early.candidate]++;
      const auto milder = [&](const Trial& than) {
        return static_cast<std::size_t>(std::ranges::count_if(trials, [&](const Trial& t) {
          return t.candidate == than.candidate && (t.lateness_s < 0.0) == (than.lateness_s < 0.0) &&
                 t.excess < than.excess;
        }));
      };
      EXPECT_EQ(milder(early), before);
      EXPECT_EQ(milder(late), before);
      // The better of the two that hit.
      const auto cost = [&](const Trial& t) {
        return t.meets ? t.excess - std::log(time_factor(t.passage.interval_s, kTarget_s)) : kNever;
      };
      EXPECT_EQ(cost(closing.best), std::min(cost(early), cost(late)));
    }
    EXPECT_EQ(ends.size(), static_cast<std::size_t>(std::accumulate(used.begin(), used.end(), 0)));
    for (std::size_t c = 0; c < kCandidates; ++c) {
      const auto count = [&](bool early) {
        return static_cast<std::size_t>(std::ranges::count_if(
            trials, [&](const Trial& t) { return t.candidate == c && (t.lateness_s < 0.0) == early; }));
      };
      EXPECT_EQ(pairs[c], std::min({count(true), count(false), most}));
    }
  }
}

TEST(RandomChange, StaysInTheBallAndPrefersTheMild) {
  RandomStream random(24, 0);
  constexpr double kExcess = 4.0;
  constexpr int kDraws = 20000;
  int inner = 0;
  Vec6 mean = Vec6::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Vec6 y = random_change(kExcess, random);
    EXPECT_LE(y.squaredNorm(), kExcess * (1.0 + 1e-15));
    inner += y.squaredNorm() < 0.5 * kExcess;
    mean += y / kDraws;
  }
  // |y|^2 is uniform: half lies within half (1/8 would in an even ball). Four standard deviations.
  EXPECT_NEAR(inner, 0.5 * kDraws, 4.0 * 0.5 * std::sqrt(kDraws));
  EXPECT_LE(mean.norm(), 4.0 * std::sqrt(0.5 * kExcess / kDraws));
}

}  // namespace
}  // namespace ifa
