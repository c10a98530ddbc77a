// Events that are intervals of contact: found again in poses whose contacts are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "motions.hpp"

namespace ifa::verify::test {
namespace {

// One contact of a ball: how long it flies before, and how long it then stays on the ground.
struct Hop {
  double flight_s, stay_s;
};

// Falls at first; then slides on without a bounce, and leaves for each further flight by speed from sliding,
// so that no energy is gained. After the last stay it stands still for 0.1 s. `impact_times_s` are those of
// landing. Samples as an exporter's, or every `every_s`.
Motion hopping_ball(const Body& body, const std::vector<Hop>& hops, double every_s = 0.0) {
  struct Piece {
    double start_s, end_s, x_m, along_m_s, up_m_s, height_m;
    bool flies;
  };
  std::vector<Piece> pieces;
  Motion motion;
  double t = 0.0, x = 0.0, along = 2.0;
  for (const Hop& hop : hops) {
    const bool first = pieces.empty();
    const double up = first ? 0.0 : 0.5 * kG * hop.flight_s;
    along = std::sqrt(along * along - 1.01 * up * up);
    const double height = first ? 0.5 * kG * hop.flight_s * hop.flight_s : 0.0;
    for (const bool flies : {true, false}) {
      const double length = flies ? hop.flight_s : hop.stay_s;
      if (length == 0.0) continue;
      pieces.push_back({t, t + length, x, along, flies ? up : 0.0, flies ? height : 0.0, flies});
      t += length;
      x += along * length;
      if (flies) motion.impact_times_s.push_back(t);
    }
  }
  pieces.push_back({t, t + 0.1, x, 0.0, 0.0, 0.0, false});
  const auto add = [&](const Piece& p, double time_s) {
    const double s = time_s - p.start_s;
    const double z = p.flies ? std::max(0.0, p.height_m + p.up_m_s * s - 0.5 * kG * s * s) : 0.0;
    motion.add(time_s, Vec3(p.x_m + p.along_m_s * s, 0.0, z + body.radius_m()),
               rotation_exp(std::min(time_s, t) * Vec3(1.0, 2.0, -1.5)));
  };
  if (every_s > 0.0) {
    std::size_t piece = 0;
    for (int i = 0; i * every_s <= pieces.back().end_s; ++i) {
      while (i * every_s > pieces[piece].end_s) ++piece;
      add(pieces[piece], i * every_s);
    }
    return motion;
  }
  add(pieces.front(), 0.0);
  for (const Piece& p : pieces) {
    const double length = p.end_s - p.start_s;
    const int n = std::max(5, static_cast<int>(std::ceil(length / 1e-3 - 1e-9)));
    for (int i = 1; i <= n; ++i) add(p, i == n ? p.end_s : p.start_s + length * i / n);
  }
  return motion;
}

Options contact_options() {
  Options options;
  options.events = Events::contact;
  return options;
}

MarkSet marks_at(std::vector<double> times_s, bool rest = true) {
  MarkSet marks;
  marks.times_s = std::move(times_s);
  marks.rest = rest;
  return marks;
}

Certificate check(const Motion& motion, const Body& body, const MarkSet& marks,
                  const Options& options = contact_options(), const std::vector<double>& ratios = {}) {
  return verify(motion.poses, body, marks, {ratios, 0.0}, options);
}

std::string all(const Certificate& c) {
  std::string text;
  for (const auto& f : c.failures) text += f + "\n";
  return text;
}

TEST(ContactEvents, AreTheIntervalsOfContact) {
  const Body body = ball();
  const std::vector<Hop> hops{{0.2, 0.0}, {0.1, 0.06}, {0.05, 0.004}, {0.04, 0.08}};
  const Motion motion = hopping_ball(body, hops);
  const Certificate c = check(motion, body, marks_at(motion.impact_times_s));
  EXPECT_TRUE(c.passed) << all(c);
  ASSERT_EQ(c.events.size(), hops.size());
  for (std::size_t k = 0; k < hops.size(); ++k) {
    // samples lie on both ends: rounding alone. The last is clipped where the ball stops, not at the end.
    EXPECT_NEAR(c.events[k].time_s, motion.impact_times_s[k], 1e-12);
    EXPECT_NEAR(c.events[k].duration_s, hops[k].stay_s, 1e-9);
    EXPECT_EQ(c.events[k].hits, 1);
  }
  EXPECT_EQ(c.max_abs_error_s, 0.0);
}

TEST(ContactEvents, AreFoundWhereImpactsFallBetweenSamples) {
  const Body body = ball();
  const std::vector<Hop> hops{{0.2, 0.0}, {0.1, 0.06}, {0.05, 0.004}, {0.04, 0.08}};
  for (const double every : {1e-3, 0.37e-3}) {
    const Motion motion = hopping_ball(body, hops, every);
    const Certificate c = check(motion, body, marks_at(motion.impact_times_s));
    EXPECT_EQ(c.missed_hits, 0) << all(c);
    EXPECT_EQ(c.extra_hits, 0) << all(c);
    EXPECT_LT(c.max_abs_error_s, every);  // documented: a fraction of a step
    ASSERT_EQ(c.events.size(), hops.size());
    for (std::size_t k = 0; k < hops.size(); ++k)  // an end is known to a step
      EXPECT_NEAR(c.events[k].duration_s, hops[k].stay_s, 2.0 * every);
  }
}

TEST(ContactEvents, FlightsShorterThanTheMergeGapJoinThem) {
  const Body body = ball();
  const Motion motion = hopping_ball(body, {{0.2, 0.02}, {0.0095, 0.03}, {0.0095, 0.0}, {0.0105, 0.03}});
  const auto& t = motion.impact_times_s;
  const Certificate c = check(motion, body, marks_at({t[0], t[3]}));
  EXPECT_TRUE(c.passed) << all(c);
  ASSERT_EQ(c.events.size(), 2u);
  EXPECT_NEAR(c.events[0].duration_s, t[2] - t[0], 1e-9);  // rounding
  EXPECT_EQ(c.events[0].hits, 3);
  EXPECT_NEAR(c.events[1].duration_s, 0.03, 1e-9);

  Options wide = contact_options();
  wide.merge_gap_s = 0.03;
  EXPECT_TRUE(check(motion, body, marks_at({t[0]}), wide).passed);
  EXPECT_EQ(check(motion, body, marks_at({t[0]})).extra_hits, 1);
}

TEST(ContactEvents, WhatIsTooSoftToHearIsExtraToo) {
  // The second landing, at 0.098 m/s, is silent to these ears; a contact of its own it is all the same.
  const Body body = ball();
  const Motion motion = hopping_ball(body, {{0.2, 0.03}, {0.02, 0.0}, {0.1, 0.03}});
  const auto& t = motion.impact_times_s;
  Options options;
  options.audible_speed_m_s = 0.15;
  EXPECT_TRUE(check(motion, body, marks_at({t[0], t[2]}), options).passed);
  options.events = Events::contact;
  const Certificate c = check(motion, body, marks_at({t[0], t[2]}), options);
  ASSERT_EQ(c.failures.size(), 1u) << all(c);
  EXPECT_NE(c.failures[0].find("a contact that begins at 0.25 s answers no mark"), std::string::npos)
      << c.failures[0];
  ASSERT_EQ(c.extra_events_s.size(), 1u);
  EXPECT_NEAR(c.extra_events_s[0], t[1], 1e-12);
  EXPECT_TRUE(check(motion, body, marks_at(t), options).passed);
}

TEST(ContactEvents, AMarkWithinSustainedContactIsMissed) {
  const Body body = ball();
  const Motion motion = hopping_ball(body, {{0.2, 0.15}, {0.1, 0.03}});
  const auto& t = motion.impact_times_s;
  const Certificate c = check(motion, body, marks_at({t[0], t[0] + 0.1, t[1]}));
  ASSERT_EQ(c.failures.size(), 1u) << all(c);
  EXPECT_NE(c.failures[0].find("mark 2"), std::string::npos) << c.failures[0];
  EXPECT_NE(c.failures[0].find("no contact begins near it"), std::string::npos) << c.failures[0];
  EXPECT_EQ(c.missed_hits, 1);
  EXPECT_EQ(c.extra_hits, 0);
}

TEST(ContactEvents, AMarkMetLateIsNamed) {
  const Body body = ball();
  const Motion motion = hopping_ball(body, {{0.2, 0.05}, {0.1, 0.03}});
  MarkSet marks = marks_at(motion.impact_times_s);
  marks.times_s[1] -= 0.002;
  const Certificate c = check(motion, body, marks);
  ASSERT_EQ(c.failures.size(), 1u) << all(c);
  EXPECT_NE(c.failures[0].find("2 ms late"), std::string::npos) << c.failures[0];
  EXPECT_NEAR(c.marks[1].error_s, 0.002, 1e-12);
}

TEST(ContactEvents, ASpanExcusesNoFurtherContact) {
  const Body body = ball();
  const Motion motion = hopping_ball(body, {{0.2, 0.0}, {0.1, 0.05}, {0.05, 0.03}});
  const auto& t = motion.impact_times_s;
  MarkSet marks = marks_at({t[0], t[1]});
  marks.durations_s = {0.0, 0.2};
  EXPECT_TRUE(check(motion, body, marks, {}).passed);
  const Certificate c = check(motion, body, marks);
  ASSERT_EQ(c.extra_events_s.size(), 1u);
  EXPECT_NEAR(c.extra_events_s[0], t[2], 1e-12);
}

TEST(ContactEvents, NothingIsAskedAfterTheLastMarkOfAnOpenEnding) {
  const Body body = ball();
  const Motion motion = hopping_ball(body, {{0.2, 0.0}, {0.1, 0.05}, {0.05, 0.03}});
  const auto& t = motion.impact_times_s;
  EXPECT_TRUE(check(motion, body, marks_at({t[0], t[1]}, false)).passed);
  EXPECT_EQ(check(motion, body, marks_at({t[0], t[1]}, true)).extra_hits, 1);
}

TEST(ContactEvents, ClicksOfABodyThatNeverLeavesTheGroundAreNone) {
  // A box tips over: one audible click, within a contact that was there from the beginning.
  const Body body = box();
  const Motion motion = tipping_box(body);
  const MarkSet marks = marks_of(motion, true);
  EXPECT_TRUE(verify(motion.poses, body, marks, {}, {}).passed);
  const Certificate c = verify(motion.poses, body, marks, {}, contact_options());
  EXPECT_EQ(c.missed_hits, 1);
  ASSERT_EQ(c.extra_events_s.size(), 1u);
  EXPECT_EQ(c.extra_events_s[0], motion.poses.times_s[0]);
  ASSERT_EQ(c.events.size(), 1u);
  EXPECT_NEAR(c.events[0].duration_s, motion.impact_times_s[0], 1e-9);  // there it comes to rest at once
}

TEST(ContactEvents, MergeGapMayBeMeasuredBeforeRetiming) {
  // A flight of 9.6 ms, slowed by 1.25, is 12 ms long: as simulated it parts nothing.
  const Body body = ball();
  Motion motion = hopping_ball(body, {{0.2, 0.02}, {0.0096, 0.02}, {0.1, 0.03}});
  const std::vector<double> ratios{1.0, 1.25, 1.25};
  retime(&motion, ratios);
  const auto& t = motion.impact_times_s;
  ASSERT_NEAR(t[1] - t[0], 1.25 * 0.0296, 1e-12);
  Options options = contact_options();
  options.max_step_s = 1.3e-3;  // the samples were stretched with the motion
  const Certificate c = check(motion, body, marks_at({t[0], t[2]}), options, {1.0, 1.25});
  EXPECT_EQ(c.extra_hits, 0) << all(c);
  EXPECT_EQ(check(motion, body, marks_at({t[0], t[2]}), options).extra_hits, 1);
  // ... or after: marked, it is met
  EXPECT_EQ(check(motion, body, marks_at(t), options, ratios).missed_hits, 0);
}

TEST(ContactEvents, AFlightWithinTheTouchingHeightMayPartThemOrNot) {
  // A ball of 1 m flies for 12 ms and rises 0.18 mm, less than the 0.4 mm that count as touching. That it
  // falls freely tells; but a force too small to be seen would look the same.
  const Body body = ball(1.0);
  const Motion motion = hopping_ball(body, {{0.2, 0.03}, {0.012, 0.03}, {0.1, 0.03}});
  const auto& t = motion.impact_times_s;
  EXPECT_TRUE(check(motion, body, marks_at(t)).passed) << all(check(motion, body, marks_at(t)));
  EXPECT_TRUE(check(motion, body, marks_at({t[0], t[2]})).passed);
  // A mark within that flight is met by neither.
  EXPECT_EQ(check(motion, body, marks_at({t[0], t[1] - 0.006, t[2]})).marks[1].achieved_s, t[1]);
}

}  // namespace
}  // namespace ifa::verify::test
