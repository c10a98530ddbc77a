// Motions that are as they should be pass, and what is measured on them is right.
#include <gtest/gtest.h>

#include <cmath>

#include "ifa/base/error.hpp"
#include "motions.hpp"

namespace ifa::verify::test {
namespace {

std::string all(const Certificate& c) {
  std::string text;
  for (const auto& f : c.failures) text += f + "\n";
  return text;
}

TEST(CleanMotion, BouncingBallPassesWithExactTimesAndSpeeds) {
  const Body body = ball();
  const Motion motion = bouncing_ball(body, 0.3, 0.6, 5);
  const Certificate c = verify(motion.poses, body, marks_of(motion, true), {}, {});
  EXPECT_TRUE(c.passed) << all(c);
  ASSERT_EQ(c.hits.size(), 5u);
  for (int k = 0; k < 5; ++k) {
    // impact samples are exact, and differences of a parabola are: rounding alone
    EXPECT_NEAR(c.hits[k].time_s, motion.impact_times_s[k], 1e-12);
    EXPECT_NEAR(c.hits[k].approach_speed_m_s / motion.impact_speeds_m_s[k], 1.0, 1e-8);
  }
  EXPECT_EQ(c.flights.size(), 5u);
  EXPECT_LT(c.max_gravity_error, 1e-6);
  EXPECT_EQ(c.missed_hits, 0);
  EXPECT_EQ(c.extra_hits, 0);
  EXPECT_EQ(c.max_energy_gain_j, 0.0);
  EXPECT_NEAR(c.rest_s, motion.impact_times_s.back(), 1e-12);
  // energy of each flight: m g h of its apex
  EXPECT_NEAR(c.flights[0].energy_j,
              body.mass_kg() * kG * (0.3 + body.radius_m()) + 0.5 * body.mass_kg() * 0.13 +
                  0.2 * body.mass_kg() * 1e-4 * 7.25,
              1e-9);
}

TEST(CleanMotion, TumblingBoxPasses) {
  const Body body = box();
  const Motion motion = tumbling_box(body, 0.6, 8);
  MarkSet marks = marks_of(motion, false);
  const Certificate c = verify(motion.poses, body, marks, {}, {});
  EXPECT_TRUE(c.passed) << all(c);
  std::size_t found = 0;
  for (std::size_t k = 0; k < motion.impact_times_s.size(); ++k) {
    if (motion.impact_speeds_m_s[k] < 0.05) continue;
    ASSERT_LT(found, c.hits.size());
    EXPECT_NEAR(c.hits[found].time_s, motion.impact_times_s[k], 1e-12);
    // the contract: 1e-3 of the speed; rotations are fitted by Euler's equations, so much better
    EXPECT_NEAR(c.hits[found].approach_speed_m_s / motion.impact_speeds_m_s[k], 1.0, 1e-5);
    ++found;
  }
  EXPECT_EQ(found, c.hits.size());
  EXPECT_GT(c.flights.size(), 3u);
  EXPECT_LT(c.max_momentum_drift, 1e-6);
  EXPECT_LT(c.max_gravity_error, 1e-6);
}

TEST(CleanMotion, ImpactsBetweenSamplesAreFound) {
  for (const double every : {1e-3, 0.37e-3}) {
    const Body round = ball();
    const Motion bounce = bouncing_ball(round, 0.3, 0.6, 5, every);
    const Certificate c = verify(bounce.poses, round, marks_of(bounce, true), {}, {});
    EXPECT_TRUE(c.passed) << every << "\n" << all(c);
    EXPECT_LT(c.max_abs_error_s, every);  // documented: within a sample; here extrapolation is exact
    ASSERT_EQ(c.hits.size(), 5u);
    for (int k = 0; k < 5; ++k)
      EXPECT_NEAR(c.hits[k].approach_speed_m_s / bounce.impact_speeds_m_s[k], 1.0, 1e-2);

    const Body body = box();
    const Motion toss = tumbling_box(body, 0.6, 5, every);
    const Certificate d = verify(toss.poses, body, marks_of(toss, false), {}, {});
    EXPECT_EQ(d.missed_hits, 0) << all(d);
    EXPECT_EQ(d.extra_hits, 0) << all(d);
    EXPECT_LT(d.max_abs_error_s, every);
    // At 1 ms two of the impacts share an interval: one of them stays unseen, so paths meet less well.
    EXPECT_LT(d.max_penetration_m, every < 0.5e-3 ? 1e-6 : 1e-4);
  }
}

TEST(CleanMotion, TippingOverInSustainedContactIsOneHit) {
  const Body body = box();
  const Motion motion = tipping_box(body);
  const Certificate c = verify(motion.poses, body, marks_of(motion, true), {}, {});
  EXPECT_TRUE(c.passed) << all(c);
  ASSERT_EQ(c.hits.size(), 1u);
  EXPECT_NEAR(c.hits[0].time_s, motion.impact_times_s[0], 1e-9);
  // 1 ms steps interpolated linearly: acceleration g over half a step is 0.005 m/s, of 0.4 m/s or more
  EXPECT_NEAR(c.hits[0].approach_speed_m_s, motion.impact_speeds_m_s[0], 0.02);
  EXPECT_TRUE(c.flights.empty());
}

TEST(CleanMotion, SlidingAndRollingAreSilent) {
  const Body body = box();
  const Motion slide = sliding_box(body);
  MarkSet marks;
  marks.times_s = {0.1};
  const Certificate c = verify(slide.poses, body, marks, {}, {});
  EXPECT_TRUE(c.hits.empty());
  EXPECT_EQ(c.missed_hits, 1);
  EXPECT_TRUE(c.at_rest);
  // the fastest corner falls below 0.01 m/s within the last interval before 0.2 s, or a few before it
  EXPECT_NEAR(c.rest_s, 0.2, 4e-3);
  EXPECT_EQ(c.max_contact_energy_gain_j, 0.0);

  const Body round = ball();
  Motion roll;
  for (int i = 0; i <= 1000; ++i) roll.add(1e-3 * i, {0.5e-3 * i, 0, 0.01}, rotation_exp({0, 50e-3 * i, 0}));
  const Certificate d = verify(roll.poses, round, marks, {}, {});
  EXPECT_TRUE(d.hits.empty());
  EXPECT_TRUE(d.flights.empty());
  EXPECT_FALSE(d.at_rest);
}

TEST(CleanMotion, ADiskThatRocksFromSideToSideIsSilent) {
  // Its rim rolls: no point of it strikes the ground, though they come down at up to 0.8 m/s nearby.
  const Body body = disk();
  MarkSet marks;
  marks.times_s = {0.0};
  for (const double rate : {5.0, 20.0, 60.0})
    for (const double least : {1e-3, 3e-3, 1e-2, 3e-2}) {
      const Certificate c = verify(rocking_disk(body, rate, least).poses, body, marks, {}, {});
      EXPECT_TRUE(c.hits.empty()) << rate << " " << least << ": " << c.hits[0].time_s << " "
                                  << c.hits[0].approach_speed_m_s;
      EXPECT_LT(c.max_penetration_m, 1e-6) << rate << " " << least;
    }
}

TEST(CleanMotion, ADiskThatSlapsTheGroundIsHeard) {
  const Body body = disk();
  MarkSet marks;
  marks.times_s = {0.0};
  for (const double rate : {5.0, 20.0, 60.0}) {
    const Certificate c = verify(rocking_disk(body, rate, 0.0, true).poses, body, marks, {}, {});
    EXPECT_EQ(c.missed_hits, 0) << rate;
    ASSERT_EQ(c.hits.size(), 1u) << rate;
    EXPECT_NEAR(c.hits[0].time_s, 0.0, 1e-12);
    // The far side comes down at twice the radius times the rate; of a rim that lies flat eight points are
    // looked at, one of them within 22.5 degrees: (1 + cos 22.5) / 2 = 0.96.
    const double share = c.hits[0].approach_speed_m_s / (2.0 * body.rings()[0].radius_m * rate);
    EXPECT_GT(share, 0.96);
    EXPECT_LT(share, 1.001);  // the sine of the tilt over 2 ms
  }
}

TEST(CleanMotion, OnlyThePointThatStrikesTellsTheSpeed) {
  // A plank comes down on one end: one corner strikes, which slows the other of that end, 2 um above the
  // ground and faster, to less than half; it strikes a little later.
  const double width = 0.0062, fall = 0.1, spin = 4.0, above = 1e-5;
  const Body body = box({width, 0.06, 0.010});
  const double until = above / (fall - 0.5 * width * spin);  // spin turns the corners by that much till then
  Spinning start;
  start.v = {0, 0, -fall};
  start.w = {0, spin, 0};
  start.q = rotation_exp({0.02, 0, 0}) * rotation_exp({0, -(2e-6 / width + spin * until), 0});
  double lowest = 1e300;
  for (const Vec3& p : body.vertices()) lowest = std::min(lowest, (start.q * p).z());
  start.x = {0, 0, above - lowest};
  const Motion motion = tossed_box(body, start, 0.1, 2);
  ASSERT_LT(motion.impact_times_s[1] - motion.impact_times_s[0], 1e-4);
  MarkSet marks;
  marks.times_s = {motion.impact_times_s[0]};
  marks.rest = false;
  Options options;
  options.audible_speed_m_s = 0.021;
  const Certificate c = verify(motion.poses, body, marks, {}, options);
  ASSERT_GE(c.hits.size(), 2u);
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(c.hits[k].time_s, motion.impact_times_s[k], 1e-12);
    EXPECT_NEAR(c.hits[k].approach_speed_m_s / motion.impact_speeds_m_s[k], 1.0, 1e-5);  // as when tumbling
  }
}

TEST(CleanMotion, SpinThatTurnsFastKeepsItsEnergy) {
  // A ball spins on the spot, slipping, its energy constant; for 3 ms its axis turns at 2000 rad/s.
  const Body body = ball();
  Motion motion;
  Quat q = Quat::Identity();
  double heading = 0.0, t = 0.0;
  motion.add(t, {0, 0, body.radius_m()}, q);
  for (int i = 0; i < 200; ++i) {
    const bool turns = i >= 80 && i < 110;
    const double step = turns ? 1e-4 : 1e-3;
    if (turns) heading += 2000.0 * step;
    q = rotation_exp(step * 60.0 * Vec3(std::cos(heading), std::sin(heading), 0.0)) * q;
    motion.add(t += step, {0, 0, body.radius_m()}, q);
  }
  MarkSet marks;
  marks.times_s = {0.1};
  const Certificate c = verify(motion.poses, body, marks, {}, {});
  EXPECT_EQ(c.max_contact_energy_gain_j, 0.0) << all(c);
}

TEST(CleanMotion, RetimedFlightsPassWithTheirClaim) {
  const Body body = ball();
  Motion motion = bouncing_ball(body, 0.3, 0.6, 5);
  const std::vector<double> ratio{1.0, 1.05, 0.9, 1.2, 0.75};
  retime(&motion, ratio);
  Options options;
  options.max_step_s = 1.2e-3;  // the samples were stretched with the motion
  const Certificate c = verify(motion.poses, body, marks_of(motion, true), {ratio, 0.0}, options);
  EXPECT_TRUE(c.passed) << all(c);
  // energy is compared before retiming: restitution alone sets it, e^2 each time, on what bounces
  const double kept = 0.5 * body.mass_kg() * 0.13 + 0.2 * body.mass_kg() * 1e-4 * 7.25 +
                      body.mass_kg() * kG * body.radius_m();
  // horizontal drift and spin are scaled by the ratio at the export, so undoing it restores them
  for (int k = 1; k < 5; ++k)
    EXPECT_NEAR((c.flights[k].energy_j - kept) / (c.flights[k - 1].energy_j - kept), 0.36, 1e-6);
}

TEST(CleanMotion, YawAndShiftChangeNothing) {
  const Body body = box();
  const Motion motion = tumbling_box(body, 0.6, 6);
  const MarkSet marks = marks_of(motion, false);
  const Certificate c = verify(motion.poses, body, marks, {}, {});
  Motion moved = motion;
  const Quat yaw = rotation_exp({0, 0, 2.1});
  for (std::size_t i = 0; i < moved.poses.times_s.size(); ++i) {
    moved.poses.positions_m[i] = yaw * motion.poses.positions_m[i] + Vec3(3.0, -2.0, 0.0);
    moved.poses.orientations[i] = yaw * motion.poses.orientations[i];
    if (i % 3 == 0) moved.poses.orientations[i].coeffs() *= -1.0;  // the same rotation
  }
  const Certificate d = verify(moved.poses, body, marks, {}, {});
  EXPECT_TRUE(d.passed) << all(d);
  ASSERT_EQ(c.hits.size(), d.hits.size());
  for (std::size_t k = 0; k < c.hits.size(); ++k) {
    EXPECT_DOUBLE_EQ(c.hits[k].time_s, d.hits[k].time_s);
    // positions of size 3 lose 4e-16 m, over steps of 0.1 ms or more: 1e-11 m/s
    EXPECT_NEAR(c.hits[k].approach_speed_m_s, d.hits[k].approach_speed_m_s, 1e-9);
  }
  EXPECT_NEAR(c.max_penetration_m, d.max_penetration_m, 1e-12);
}

TEST(CleanMotion, SamplesARoundingErrorApartDoNoHarm) {
  // Exporters that collect times from several sources repeat some to the last digit.
  const Body body = box();
  const Motion motion = tumbling_box(body, 0.6, 6);
  Motion doubled;
  for (std::size_t i = 0; i < motion.poses.times_s.size(); ++i) {
    const double t = motion.poses.times_s[i];
    doubled.add(t, motion.poses.positions_m[i], motion.poses.orientations[i]);
    if (i % 2) doubled.add(std::nextafter(t, 1e9), motion.poses.positions_m[i], motion.poses.orientations[i]);
  }
  const MarkSet marks = marks_of(motion, false);
  const Certificate c = verify(motion.poses, body, marks, {}, {});
  const Certificate d = verify(doubled.poses, body, marks, {}, {});
  EXPECT_TRUE(d.passed) << all(d);
  EXPECT_EQ(c.hits.size(), d.hits.size());
}

TEST(CleanMotion, HitsAtTheAudibleSpeedSuitTheMarks) {
  // A last bounce at exactly the audible speed may be marked or not.
  const Body body = ball();
  const double last = 0.05 * 1.01;
  const Motion motion = bouncing_ball(body, last * last / 0.25 / (2.0 * kG), 0.5, 2);
  ASSERT_NEAR(motion.impact_speeds_m_s[1], last, 1e-12);
  MarkSet marks;
  marks.times_s = {motion.impact_times_s[0], motion.impact_times_s[1]};
  ASSERT_GT(marks.times_s[1] - marks.times_s[0], 0.0101);
  EXPECT_TRUE(verify(motion.poses, body, marks, {}, {}).passed);
  marks.times_s.pop_back();
  EXPECT_TRUE(verify(motion.poses, body, marks, {}, {}).passed);
}

TEST(CleanMotion, HitsInAMarkedSpanAreNotExtra) {
  const Body body = ball();
  const Motion motion = bouncing_ball(body, 0.3, 0.6, 5);
  MarkSet marks;
  marks.times_s = {motion.impact_times_s[0], motion.impact_times_s[1]};
  marks.durations_s = {0.0, motion.impact_times_s[4] - motion.impact_times_s[1]};
  EXPECT_TRUE(verify(motion.poses, body, marks, {}, {}).passed);
  marks.durations_s[1] = motion.impact_times_s[3] - motion.impact_times_s[1];
  EXPECT_EQ(verify(motion.poses, body, marks, {}, {}).extra_hits, 1);
  marks.rest = false;  // nothing is asked after the last mark
  EXPECT_EQ(verify(motion.poses, body, marks, {}, {}).extra_hits, 0);
}

TEST(CleanMotion, AChainThatBeginsInAMarkedSpanMayLeaveIt) {
  // Bounces of 14.5, 9.95 and 6.8 ms; the second hit is inside the span, the others chain on from it.
  const Body body = ball();
  const double up = 0.5 * kG * 0.0145, e = 9.95 / 14.5;
  const Motion motion = bouncing_ball(body, up * up / (e * e) / (2.0 * kG), e, 4);
  Options options;
  options.audible_speed_m_s = 0.03;
  MarkSet marks;
  marks.times_s = {motion.impact_times_s[0]};
  marks.durations_s = {0.0151};
  const Certificate c = verify(motion.poses, body, marks, {}, options);
  ASSERT_EQ(c.hits.size(), 4u);
  EXPECT_TRUE(c.passed) << all(c);
  options.merge_gap_s = 0.0098;  // by more than its margin of 0.1 ms
  EXPECT_EQ(verify(motion.poses, body, marks, {}, options).extra_hits, 1);
  options.merge_gap_s = 0.010;
  marks.durations_s = {0.0120};  // and where it does not begin there, none of it is asked for
  EXPECT_GE(verify(motion.poses, body, marks, {}, options).extra_hits, 1);
}

TEST(CleanMotion, ChainedHitsAreOneEvent) {
  // bounces of 8 ms: e and height such that the second and third follow within the merge gap
  const Body body = ball();
  const double up = 0.5 * kG * 0.008;
  const Motion motion = bouncing_ball(body, up * up / 0.81 / (2.0 * kG), 0.9, 2);
  ASSERT_EQ(motion.impact_times_s.size(), 2u);
  Options options;
  options.audible_speed_m_s = 0.03;
  MarkSet marks;
  marks.times_s = {motion.impact_times_s[0]};
  const Certificate c = verify(motion.poses, body, marks, {}, options);
  EXPECT_TRUE(c.passed) << all(c);
  ASSERT_EQ(c.events.size(), 1u);
  EXPECT_EQ(c.events[0].hits, 2);
  EXPECT_NEAR(c.events[0].duration_s, 0.008, 1e-12);
}

TEST(CleanMotion, MergeGapMayBeMeasuredBeforeRetiming) {
  // Bounces of 8 and 12.8 ms, slowed by 1.3: the second hit, unmarked, is then 10.4 ms after the first. (That
  // the bounces grow does not matter here.)
  const Body body = ball();
  const double first = 0.5 * kG * 0.008 / 1.6;
  Motion motion = bouncing_ball(body, first * first / (2.0 * kG), 1.6, 3);
  retime(&motion, {1.0, 1.3, 1.3});
  ASSERT_NEAR(motion.impact_times_s[1] - motion.impact_times_s[0], 0.0104, 1e-9);
  Options options;
  options.audible_speed_m_s = 0.022;
  MarkSet marks;
  marks.times_s = {motion.impact_times_s[0], motion.impact_times_s[2]};
  EXPECT_EQ(verify(motion.poses, body, marks, {{1.0, 1.3}, 0.0}, options).extra_hits, 0);
  EXPECT_EQ(verify(motion.poses, body, marks, {}, options).extra_hits, 1);
}

TEST(Arguments, ThatMakeNoSenseAreNamed) {
  const Body body = ball();
  const Motion motion = bouncing_ball(body, 0.3, 0.6, 3);
  EXPECT_THROW(verify(motion.poses, body, {}, {}, {}), ArgumentError);
  MarkSet marks = marks_of(motion, true);
  EXPECT_THROW(verify(motion.poses, body, marks, {{1.0}, 0.0}, {}), ArgumentError);
  Options options;
  options.gravity_m_s2 = std::nan("");
  EXPECT_THROW(verify(motion.poses, body, marks, {}, options), ArgumentError);
  std::swap(marks.times_s[0], marks.times_s[1]);
  EXPECT_THROW(verify(motion.poses, body, marks, {}, {}), ArgumentError);
}

}  // namespace
}  // namespace ifa::verify::test
