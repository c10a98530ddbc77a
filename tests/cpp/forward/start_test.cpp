#include "ifa/forward/start.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ifa/rigid/flight.hpp"
#include "solutions.hpp"

namespace ifa {
namespace {

using sample::cube;
using sample::marks_at;

TEST(SampleStart, TouchesApproachesAndComesFromFreeFlight) {
  const Body body = cube();
  const SearchPhysics physics;
  const StartOptions options = start_options(body, marks_at({0.5, 0.7}), sample::kGravity);
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
  // A second of flight leaves the ground at g / 2, after an impact at g / 2 / e.
  EXPECT_GE(start_options(cube(), marks_at({0.0, 1.0}), sample::kGravity).most_speed_m_s,
            0.5 * sample::kGravity / 0.5);
}

TEST(SampleTouchdown, ComesDownGentlyWhereItCanRest) {
  const Body body = cube();
  const SearchPhysics physics;
  const StartOptions options = start_options(body, marks_at({0.5}), sample::kGravity);
  int made = 0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    RandomStream random(8, i);
    const auto s = sample_touchdown(body, physics, options, random);
    if (!s) continue;
    ++made;
    EXPECT_NEAR(sample::lowest(body, *s), 0.0, 1e-16);
    EXPECT_LE(s->velocity.z(), -0.06);
    EXPECT_GE(s->velocity.z(), -1.0);
    // Tilted by 0.1 rad at most from lying on a face, which a drop ends on to 0.01 rad.
    EXPECT_GT((s->orientation.conjugate() * kUp).cwiseAbs().maxCoeff(), std::cos(0.11));
  }
  EXPECT_GT(made, 60);
}

TEST(ClearBefore, OfABallIsItsParabola) {
  const Body ball = sample::ball(0.02, 0.03);
  State s;
  s.position.z() = 0.02;
  s.velocity.z() = -1.0;
  EXPECT_NEAR(clear_before(ball, s, sample::downwards(), 9.0), 2.0 / sample::kGravity, 1e-12);
  EXPECT_EQ(clear_before(ball, s, sample::downwards(), 0.1), 0.1);
}

std::vector<Candidate> begun(const Body& body, const Marks& marks) {
  const std::vector<Body> bodies{body};
  const SearchPhysics physics;
  const Problem problem{bodies, physics, marks};
  Passages passages(body, physics);
  std::vector<RandomStream> random;
  for (std::uint64_t i = 0; i < 100; ++i) random.emplace_back(9, i);
  std::vector<Candidate> candidates;
  begin_candidates(problem, 0, passages, random, candidates, nullptr);
  return candidates;
}

// Each start's speed is such that the second mark is met without a change: most within what is retimed away.
TEST(BeginCandidates, MeetTheSecondMark) {
  const Body body = cube();
  const Marks marks = marks_at({0.2, 0.35}, Ending::open);
  const SearchPhysics physics;
  const auto candidates = begun(body, marks);
  int in_time = 0;
  for (const Candidate& c : candidates) {
    EXPECT_GE(c.onset.hit.approach_speed_m_s, physics.least_onset_speed_m_s());
    EXPECT_NEAR(sample::lowest(body, c.onset.before), 0.0, 1e-16);
    EXPECT_GE(clear_before(body, c.onset.before, sample::downwards(), 0.03), 0.03);
    Record record;
    const Passage passage = record_passage(body, physics, {c.onset.hit, c.onset.after, 0.0, 1.0}, record);
    in_time += passage.next == Next::hit && std::abs(passage.interval_s - 0.15) <= 1e-5;
  }
  EXPECT_GT(candidates.size(), 30u);
  EXPECT_GT(2 * in_time, static_cast<int>(candidates.size()));
}

// A ball that rebounds with half its speed: a gap T follows an impact at g T / (2 e), in closed form.
TEST(BeginCandidates, OfABallFallAsFastAsTheGapAsks) {
  const Body ball = sample::ball(0.02, 0.03, {0.5, 0.3, 1e-3, 1e-3});
  constexpr double kGap_s = 0.25;
  const double speed = 0.5 * sample::kGravity * kGap_s / 0.5;
  const auto candidates = begun(ball, marks_at({0.2, 0.2 + kGap_s}, Ending::open));
  int in_time = 0;
  for (const Candidate& c : candidates) {
    const Vec3& v = c.onset.before.velocity;
    if (v.norm() > 4.0 - 1e-12) {  // the fastest throw along its heading, and still too flat
      EXPECT_GT(v.z(), -speed);
    } else {
      EXPECT_NEAR(v.z(), -speed, 1e-5 * sample::kGravity);  // in time to 1e-5 s
      ++in_time;
    }
  }
  EXPECT_GT(in_time, 30);
}

}  // namespace
}  // namespace ifa
