#include "ifa/forward/track.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

// A cube that struck with a change that is known, and struck again after `interval_s`.
struct Known {
  std::vector<Body> bodies{sample::box({0.016, 0.016, 0.016}, 0.005)};
  SearchPhysics physics;
  Candidate candidate;
  Vec6 y;
  Passage passage;  // what came of it

  Problem problem(const Marks& marks) const { return {bodies, physics, marks}; }

  static Marks marks(double interval_s) {
    Marks m;
    m.times_s = {0.0, interval_s};
    m.durations_s = {0.0, 0.0};
    m.centroids_s = {std::nan(""), std::nan("")};
    m.ending = Ending::open;
    return m;
  }
};

std::optional<Known> known(std::uint64_t index) {
  Known k;
  RandomStream random(31, index);
  State s = sample::random_state(k.bodies[0], random, 0.0, 1.5, 20.0);
  s.velocity.z() = -random.uniform(0.5, 2.0);
  k.candidate.onset = strike(k.bodies[0], k.physics, s);
  k.y = random_change(0.5, random);
  const Marks marks = Known::marks(10.0);
  const Problem problem = k.problem(marks);
  Trials trials(problem, 0, nullptr);
  auto trial = trials.propose({&k.candidate, 1}, 0, k.y, 1.0);
  if (!trial) return std::nullopt;
  trials.run({&k.candidate, 1}, 0, {&*trial, 1});
  if (!trial->meets || trial->passage.interval_s < 0.03) return std::nullopt;
  k.passage = trial->passage;
  return k;
}

std::vector<Trial> tracked(const Known& k, double interval_s) {
  const Marks marks = Known::marks(interval_s);
  const Problem problem = k.problem(marks);
  Trials trials(problem, 0, nullptr);
  std::vector<RandomStream> random{{32, 0}};
  return track(trials, {&k.candidate, 1}, 0, k.passage.onset, k.y, random);
}

// How far two strikes are apart as the body sees them, in speeds of the known one.
double apart(const Onset& a, const Onset& b) {
  const Quat to_a = a.before.orientation.conjugate(), to_b = b.before.orientation.conjugate();
  return (to_a * kUp - to_b * kUp).norm() +
         (to_a * a.before.velocity - to_b * b.before.velocity).norm() / b.before.velocity.norm();
}

TEST(Track, ReproducesTheKnownMotionWhereNothingMoved) {
  int seen = 0;
  for (std::uint64_t i = 0; i < 60; ++i) {
    const auto k = known(i);
    if (!k) continue;
    ++seen;
    const auto trials = tracked(*k, k->passage.interval_s);
    ASSERT_FALSE(trials.empty());
    // The same change gives the same bytes; the steps of Gauss and Newton find nothing nearer than that.
    EXPECT_EQ(trials[0].passage.interval_s, k->passage.interval_s);
    EXPECT_EQ(apart(trials[0].passage.onset, k->passage.onset), 0.0);
  }
  EXPECT_GT(seen, 20);
}

// Later by 4 %, which retiming could hide; most are met without it, and nearer to the known strike than the
// change that was made there leads.
TEST(Track, MeetsAMarkThatMovedAndStaysNear) {
  int seen = 0, met = 0, in_time = 0;
  for (std::uint64_t i = 0; i < 120; ++i) {
    const auto k = known(i);
    if (!k) continue;
    ++seen;
    const double target = 1.04 * k->passage.interval_s;
    const auto trials = tracked(*k, target);
    if (trials.empty()) continue;
    ++met;
    for (const Trial& t : trials) {
      EXPECT_TRUE(t.meets);
      EXPECT_LE(t.excess, 1.0);
      EXPECT_LE(std::max(t.passage.interval_s, target) / std::min(t.passage.interval_s, target), 1.07);
    }
    in_time += std::abs(trials[0].lateness_s) < 0.01 * target &&
               apart(trials[0].passage.onset, k->passage.onset) < 0.5;
  }
  EXPECT_GT(seen, 40);
  EXPECT_GT(met, 0.9 * seen);
  EXPECT_GT(in_time, 0.5 * seen);
}

TEST(Track, GivesNothingForAMarkOutOfReach) {
  int seen = 0;
  for (std::uint64_t i = 0; i < 30; ++i) {
    const auto k = known(i);
    if (!k) continue;
    ++seen;
    // A body thrown up ten times as long needs a hundred times the energy.
    EXPECT_TRUE(tracked(*k, 10.0 * k->passage.interval_s + 1.0).empty());
  }
  EXPECT_GT(seen, 10);
}

}  // namespace
}  // namespace ifa
