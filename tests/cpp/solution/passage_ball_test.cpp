// Passages of a ball, whose closed forms are known.
#include <gtest/gtest.h>

#include <vector>

#include "sample_bodies.hpp"
#include "solution/passages.hpp"

namespace ifa {
namespace {

using sample::run_one;
using sample::strike_one;

TEST(Passages, BallsPassageIsItsParabola) {
  const Body ball = sample::ball(0.02, 0.03);
  const SearchPhysics physics;
  Passages passages(ball, physics);
  State s;
  s.position.z() = 0.02;
  s.velocity.z() = -2.0;
  const Onset onset = strike_one(passages, s);
  EXPECT_NEAR(onset.hit.approach_speed_m_s, 2.0, 1e-15);
  EXPECT_NEAR(onset.after.velocity.z(), 1.0, 1e-15);
  EXPECT_EQ(onset.before.velocity.z(), -2.0);
  State livelier = onset.after;
  livelier.velocity.z() = 1.3;
  const Passage passage = run_one(passages, {onset.hit, livelier, 0.0, kNever});
  EXPECT_EQ(passage.next, Next::hit);
  EXPECT_NEAR(passage.interval_s, 2.6 / sample::kGravity, 1e-12);
  EXPECT_NEAR(passage.onset.before.velocity.z(), -1.3, 1e-12);
  EXPECT_NEAR(passage.onset.after.velocity.z(), 0.65, 1e-12);
  EXPECT_NEAR(passage.event.amplitude, 0.03 * 3.0, 1e-15);  // of the impact, not of the change
  EXPECT_NEAR(passages.simulated_s(), 2.6 / sample::kGravity, 1e-12);
  Record record;
  record_passage(ball, physics, {onset.hit, livelier, 0.0, kNever}, record);
  EXPECT_TRUE(record.hits.empty());
  EXPECT_EQ(record.nodes.front().time_s, 0.0);
  const Passage late = run_one(passages, {onset.hit, livelier, 0.0, 0.2});
  EXPECT_EQ(late.next, Next::late);
  EXPECT_EQ(late.interval_s, 0.2);
}

// A ball that has ceased to bounce is not watched any more while it rolls and slips on. It is said to rest no
// sooner than it does, and what would roll beyond the limit is late.
TEST(Passages, BallsShortcutBoundsItsRest) {
  const Material materials[] = {
      {0.5, 0.3, 1e-3, 1e-3}, {0.2, 0.05, 2e-4, 5e-4}, {0.7, 1.0, 3e-3, 2e-5}, {0.0, 0.3, 5e-4, 5e-4}};
  RandomStream random(45, 0);
  int rested = 0, late = 0;
  for (const Material& material : materials) {
    const Body ball = sample::ball(0.02, 0.03, material);
    const SearchPhysics physics;
    Passages passages(ball, physics);
    for (int i = 0; i < 60; ++i) {
      State s = sample::random_state(ball, random, 0.0, 1.0, 60.0);
      s.velocity.z() = -random.uniform(0.06, 0.12);
      const Onset onset = strike_one(passages, s);
      const Departure departure{onset.hit, onset.after, 0.0, 60.0};
      Record record;
      const Passage watched = record_passage(ball, physics, departure, record);
      const Passage taken = run_one(passages, departure);
      if (watched.next != Next::rest) {  // it bounces on
        EXPECT_EQ(taken.next, watched.next);
        continue;
      }
      ASSERT_EQ(taken.next, Next::rest);
      ++rested;
      EXPECT_LT(taken.interval_s, watched.interval_s);  // that is the point of it
      // Rest begins below a speed, not at 0: the bound is never tight.
      EXPECT_GE(taken.rest_s, watched.rest_s);
      Departure shorter = departure;
      shorter.limit_s = 0.5 * (taken.interval_s + watched.rest_s);
      const Passage cut = run_one(passages, shorter);
      EXPECT_EQ(cut.next, Next::late);
      EXPECT_EQ(cut.interval_s, shorter.limit_s);
      ++late;
    }
  }
  EXPECT_GT(rested, 150);
  EXPECT_GT(late, 150);
}

// A ball that rolls without slipping stops after v / a, with a = c g / (R (1 + 2/5)), c the rolling friction.
// The shortcut adds up slip and rolling as if they were two, which makes twice that.
TEST(Passages, BallsBoundIsTwiceItsRolling) {
  const Body ball = sample::ball(0.02, 0.03, {0.5, 0.3, 1e-3, 1e-3});
  const SearchPhysics physics;
  Passages passages(ball, physics);
  State rolling;
  rolling.position.z() = 0.02;
  rolling.velocity.x() = 0.4;
  rolling.angular_velocity.y() = 0.4 / 0.02;
  Hit first;
  first.impulse_n_s.z() = 1.0;
  const double stops_s = 0.4 * 0.02 * 1.4 / (1e-3 * sample::kGravity);
  const Passage passage = run_one(passages, {first, rolling, 0.0, 60.0});
  EXPECT_EQ(passage.next, Next::rest);
  // the first step is watched: 1 to 4 ms
  EXPECT_NEAR(passage.rest_s, 2.0 * stops_s, 8e-3);
  EXPECT_LE(passage.interval_s, 4e-3);
}

TEST(Passages, BallIsWatchedWithinASpan) {
  const Body ball = sample::ball(0.02, 0.03, {0.5, 0.3, 1e-3, 1e-3});
  const SearchPhysics physics;
  Passages passages(ball, physics);
  State slides;
  slides.position.z() = 0.02;
  slides.velocity.x() = 2.0;
  Hit first;
  first.impulse_n_s.z() = 0.01;
  // It slips for 2 v / (7 mu g) = 0.194 s; the span ends before, and up to there its weight sounds.
  const double span = 0.15;
  const Passage passage = run_one(passages, {first, slides, span, 60.0});
  EXPECT_EQ(passage.next, Next::rest);
  EXPECT_GT(passage.interval_s, span);
  constexpr double kStep_s = 4e-3;  // a step that reaches beyond the span does not count
  EXPECT_NEAR(passage.event.length_s, span, kStep_s);
  EXPECT_NEAR(passage.event.amplitude, 0.01 + 0.03 * sample::kGravity * span,
              0.03 * sample::kGravity * kStep_s);
}

// A ball that lands with 0.0524 m/s might as well be taken for silent (0.05 and 5 %).
TEST(Passages, HitsNearTheAudibleSpeedAreDubious) {
  const Body ball = sample::ball(0.02, 0.03);
  const SearchPhysics physics;
  Passages passages(ball, physics);
  Hit first;
  const auto next = [&](double speed) {
    State after;
    after.position.z() = 0.02;
    after.velocity.z() = speed;
    return run_one(passages, {first, after, 0.0, kNever}).next;
  };
  EXPECT_EQ(next(0.0530), Next::hit);
  EXPECT_EQ(next(0.0524), Next::dubious);
  EXPECT_EQ(next(0.0476), Next::dubious);
  EXPECT_EQ(next(0.0470), Next::rest);
}

// Gaps near 10 ms likewise: within 5 % where hits chain, 1 % where contact does, which ends sharply. A
// marked span holds its hits together whatever the gap; contact knows no such excuse.
TEST(Passages, GapsNearTheMergeGapAreDubious) {
  const Body ball = sample::ball(0.02, 0.03);
  SearchPhysics heavy;
  heavy.simulation.gravity_m_s2 = {0, 0, -200.0};  // on earth a hit after 10 ms would not be audible
  const auto next = [&](Events events, double gap, double span) {
    heavy.hearing.events = events;
    Passages passages(ball, heavy);
    State after;
    after.position.z() = 0.02;
    after.velocity.z() = 100.0 * gap;
    return run_one(passages, {Hit{}, after, span, kNever}).next;
  };
  for (const double gap : {0.0097, 0.0103}) EXPECT_EQ(next(Events::audible, gap, 0.0), Next::dubious) << gap;
  EXPECT_EQ(next(Events::audible, 0.0107, 0.0), Next::hit);
  EXPECT_NE(next(Events::audible, 0.0093, 0.0), Next::dubious);
  for (const double gap : {0.0097, 0.0103, 0.0107})
    EXPECT_NE(next(Events::audible, gap, 0.02), Next::dubious);
  for (const double span : {0.0, 0.02}) {
    for (const double gap : {0.00995, 0.01005})
      EXPECT_EQ(next(Events::contact, gap, span), Next::dubious) << gap;
    for (const double gap : {0.0102, 0.0107}) EXPECT_EQ(next(Events::contact, gap, span), Next::hit) << gap;
    EXPECT_EQ(next(Events::contact, 0.0097, span), Next::rest);
  }
}

// A bounce too soft to hear that never ends: given up after 60 impacts, as nobody could follow it.
TEST(Passages, EndlessChatterIsDubious) {
  const Body ball = sample::ball(0.02, 0.03, sample::ideal(1.0, 0.0));
  const SearchPhysics physics;
  Passages passages(ball, physics);
  State after;
  after.position.z() = 0.02;
  after.velocity.z() = 0.03;
  const Passage passage = run_one(passages, {Hit{}, after, 0.0, kNever});
  EXPECT_EQ(passage.next, Next::dubious);
  EXPECT_NEAR(passage.interval_s, 61 * 0.06 / sample::kGravity, 1e-9);  // a nanosecond: 61 roundings
}

TEST(Passages, MarkedSpanTakesItsHits) {
  const Body ball = sample::ball(0.02, 0.03);
  const SearchPhysics physics;
  Passages passages(ball, physics);
  State s;
  s.position.z() = 0.02;
  s.velocity.z() = -2.0;
  const Onset onset = strike_one(passages, s);
  // lands after 0.204, then every half of that: 0.306, 0.357, 0.382, 0.395, ...
  const double first = 2.0 / sample::kGravity;
  const Departure departure{onset.hit, onset.after, 0.36, kNever};
  const Passage passage = run_one(passages, departure);
  EXPECT_EQ(passage.next, Next::hit);
  EXPECT_NEAR(passage.interval_s, first * 1.875, 1e-9);
  EXPECT_EQ(passage.event.hits, 4);
  EXPECT_NEAR(passage.event.length_s, first * 1.75, 1e-9);
  EXPECT_NEAR(passage.event.loose_s, first * 1.75, 1e-9);  // the span alone holds them together
  Record record;
  record_passage(ball, physics, departure, record);
  EXPECT_EQ(record.hits.size(), 3u);
}

}  // namespace
}  // namespace ifa
