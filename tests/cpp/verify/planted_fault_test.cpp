// Each fault, planted into a motion that passes, is found, and named where it is.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "motions.hpp"

namespace ifa::verify::test {
namespace {

class PlantedFault : public ::testing::Test {
 protected:
  PlantedFault()
      : round(ball()),
        body(box()),
        bounce(bouncing_ball(round, 0.3, 0.6, 5)),
        toss(tumbling_box(body, 0.6, 6)),
        bounce_marks(marks_of(bounce, true)),
        toss_marks(marks_of(toss, false)) {}

  void SetUp() override {
    ASSERT_TRUE(check_bounce().passed);
    ASSERT_TRUE(check_toss().passed);
  }

  Certificate check_bounce() const { return verify(bounce.poses, round, bounce_marks, claims, {}); }
  Certificate check_toss() const { return verify(toss.poses, body, toss_marks, {}, {}); }

  // The only kind of failure.
  static void expect_only(const Certificate& c, const std::string& words) {
    EXPECT_FALSE(c.passed);
    EXPECT_FALSE(c.failures.empty()) << words;
    for (const auto& f : c.failures) EXPECT_NE(f.find(words), std::string::npos) << f;
  }
  static void expect_among(const Certificate& c, const std::string& words) {
    EXPECT_FALSE(c.passed);
    bool found = false;
    std::string all;
    for (const auto& f : c.failures) {
      found |= f.find(words) != std::string::npos;
      all += f + "\n";
    }
    EXPECT_TRUE(found) << words << " not in:\n" << all;
  }

  Body round, body;
  Motion bounce, toss;
  MarkSet bounce_marks, toss_marks;
  Claims claims;
};

TEST_F(PlantedFault, MarkShiftedBy2Ms) {
  bounce_marks.times_s[2] += 0.002;
  const Certificate c = check_bounce();
  expect_only(c, "mark 3");
  expect_only(c, "2 ms early");
  EXPECT_NEAR(c.marks[2].error_s, -0.002, 1e-12);
  EXPECT_NEAR(c.max_abs_error_s, 0.002, 1e-12);
  EXPECT_EQ(c.missed_hits, 0);
}

TEST_F(PlantedFault, ExtraHit) {
  const double t = bounce_marks.times_s[1];
  bounce_marks.times_s.erase(bounce_marks.times_s.begin() + 1);
  const Certificate c = check_bounce();
  expect_only(c, "answers no mark");
  EXPECT_EQ(c.extra_hits, 1);
  ASSERT_EQ(c.extra_events_s.size(), 1u);
  EXPECT_NEAR(c.extra_events_s[0], t, 1e-12);
}

TEST_F(PlantedFault, HitBeforeTheFirstMarkIsExtra) {
  bounce_marks.times_s.erase(bounce_marks.times_s.begin());
  EXPECT_EQ(check_bounce().extra_hits, 1);
}

TEST_F(PlantedFault, MissingHit) {
  bounce_marks.times_s.insert(bounce_marks.times_s.begin() + 1,
                              0.5 * (bounce_marks.times_s[0] + bounce_marks.times_s[1]));
  const Certificate c = check_bounce();
  expect_only(c, "mark 2");
  EXPECT_EQ(c.missed_hits, 1);
  EXPECT_EQ(c.extra_hits, 0);
}

TEST_F(PlantedFault, PenetrationAtSamples) {
  for (Vec3& p : bounce.poses.positions_m) p.z() -= 2e-4;
  const Certificate c = check_bounce();
  expect_only(c, "in the ground");
  EXPECT_NEAR(c.max_penetration_m, 2e-4, 1e-9);
}

TEST_F(PlantedFault, PenetrationBetweenSamplesOfASmoothMotion) {
  // A thin rod spinning fast about y: at the samples its ends are above the ground, between two they are not.
  const Body rod = box({0.2, 0.002, 0.002});
  const double spin = 300.0, step = 1e-3;
  // Its lower corners turn on a circle of radius r; at the samples around the lowest point they are `skew`
  // off.
  const double r = std::hypot(0.1, 0.001), skew = 0.5 * spin * step - std::atan2(0.001, 0.1);
  const double above = 1e-5, z = r * std::cos(skew) + above;
  Motion motion;
  for (int i = 0; i < 10; ++i) {
    const double t = step * (i - 4.5);
    motion.add(t, {0, 0, z + 0.5 * kG * (0.25 * step * step - t * t)},
               rotation_exp({0, 1.5707963267948966 + spin * t, 0}));
  }
  for (int i = 0; i < 10; ++i)
    for (const Vec3& v : rod.vertices())
      ASSERT_GT((motion.poses.positions_m[i] + motion.poses.orientations[i] * v).z(), 0.5 * above);
  MarkSet marks;
  marks.times_s = {0.0};
  marks.rest = false;
  const Certificate c = verify(motion.poses, rod, marks, {}, {});
  EXPECT_NEAR(c.max_penetration_m, r - z, 0.1 * (r - z));  // looked for at eighths of the interval
  expect_among(c, "in the ground");
}

TEST_F(PlantedFault, PenetrationBetweenSamplesOfALateBounce) {
  // Sampled at 1 ms off the impact, bouncing 0.2 mm below the ground halfway between two samples.
  const double speed = 1.0, step = 1e-3, deep = 2e-4;
  Motion motion;
  for (int i = -30; i <= 30; ++i) {
    const double t = step * (i + 0.5);
    motion.add(t + 0.03, {0, 0, 0.01 - deep + speed * std::abs(t) - 0.5 * kG * t * t}, Quat::Identity());
  }
  MarkSet marks;
  marks.times_s = {0.03 - deep / speed};
  marks.rest = false;
  const Certificate c = verify(motion.poses, round, marks, {}, {});
  expect_only(c, "in the ground");
  EXPECT_NEAR(c.max_penetration_m, deep, 1e-2 * deep);
}

TEST_F(PlantedFault, Gravity5PercentOffInOneFlight) {
  const int a = bounce.first_at(bounce.impact_times_s[1]), b = bounce.first_at(bounce.impact_times_s[2]);
  for (int i = a; i <= b; ++i) {
    double& z = bounce.poses.positions_m[i].z();
    z = 0.01 + 1.05 * (z - 0.01);
  }
  const Certificate c = check_bounce();
  expect_only(c, "departs from its parabola under gravity by ");
  EXPECT_NEAR(c.max_gravity_error, 0.05, 1e-4);  // 1e-8 m, which prove nothing, are taken off
}

TEST_F(PlantedFault, HorizontalAcceleration) {
  const double t0 = bounce.impact_times_s[0], t1 = bounce.impact_times_s[1];
  for (int i = bounce.first_at(t0); i <= bounce.first_at(t1); ++i) {
    const double t = bounce.poses.times_s[i];
    bounce.poses.positions_m[i].x() += 0.5 * 0.2 * (t - t0) * (t - t1);
  }
  const Certificate c = check_bounce();
  expect_only(c, "accelerates horizontally");
  EXPECT_NEAR(c.max_horizontal_acceleration_m_s2, 0.2, 2e-3);
}

TEST_F(PlantedFault, AngularMomentumChangedInFlightBy2Percent) {
  // From the middle of the first flight on, the rotation runs 2 % faster about the same momentum.
  const int hit = bounce.first_at(bounce.impact_times_s[0]);
  const Vec3 spin(1.0, 2.0, -1.5);
  const double middle = bounce.poses.times_s[hit / 2];
  for (int i = hit / 2; i < static_cast<int>(bounce.poses.times_s.size()); ++i)
    bounce.poses.orientations[i] =
        rotation_exp(0.02 * (std::min(bounce.poses.times_s[i], bounce.impact_times_s[0]) - middle) * spin) *
        bounce.poses.orientations[i];
  const Certificate c = check_bounce();
  expect_only(c, "changes its angular momentum");
  EXPECT_NEAR(c.max_momentum_drift, 0.02, 1e-4);
}

TEST_F(PlantedFault, EulerTermLeftOut) {
  // A box that turns at a constant rate about a skew axis looks like a rotation but breaks Euler's equations.
  const int hit = toss.first_at(toss.impact_times_s[0]);
  const Quat q0 = toss.poses.orientations[0];
  const Eigen::AngleAxisd turn(q0.conjugate() * toss.poses.orientations[hit]);
  for (int i = 0; i <= hit; ++i)
    toss.poses.orientations[i] =
        q0 * rotation_exp(turn.angle() * turn.axis() * toss.poses.times_s[i] / toss.poses.times_s[hit]);
  expect_among(check_toss(), "changes its angular momentum");
}

TEST_F(PlantedFault, EnergyGainAtABounce) {
  const double height = 0.05, speed = std::sqrt(2 * kG * height);
  Motion motion;
  const double t1 = speed / kG, up = 1.02 * speed, t2 = t1 + 2 * up / kG;
  for (int i = 0; i < 120; ++i) {
    const double t = t1 * i / 120;
    motion.add(t, {0, 0, 0.01 + height - 0.5 * kG * t * t}, Quat::Identity());
  }
  for (int i = 0; i <= 300; ++i) {
    const double s = (t2 - t1) * i / 300;
    motion.add(t1 + s, {0, 0, 0.01 + up * s - 0.5 * kG * s * s}, Quat::Identity());
  }
  MarkSet marks;
  marks.times_s = {t1, t2};
  marks.rest = false;
  const Certificate c = verify(motion.poses, round, marks, {}, {});
  expect_only(c, "the energy grows");
  const double gain = 0.5 * 0.005 * (up * up - speed * speed);
  EXPECT_NEAR(c.max_energy_gain_j, gain, 1e-6 * gain);
  EXPECT_TRUE(verify(motion.poses, round, marks, {{}, 1.01 * gain}, {}).passed);
}

TEST_F(PlantedFault, JumpingUpFromRest) {
  // Less energy than the drop had, but after standing still.
  Motion motion = bouncing_ball(round, 0.3, 0.6, 1);
  const double t0 = motion.poses.times_s.back(), up = 0.5;
  const Vec3 from = motion.poses.positions_m.back();
  const Quat q = motion.poses.orientations.back();
  for (int i = 1; i <= 102; ++i) {
    const double s = 2 * up / kG * i / 102;
    motion.add(t0 + s, from + Vec3(0, 0, up * s - 0.5 * kG * s * s), q);
  }
  MarkSet marks;
  marks.times_s = {motion.impact_times_s[0], t0 + 2 * up / kG};
  marks.rest = false;
  const Certificate c = verify(motion.poses, round, marks, {}, {});
  expect_only(c, "the energy grows");
  EXPECT_GT(c.max_contact_energy_gain_j, 0.5 * 0.5 * 0.005 * up * up);
}

TEST_F(PlantedFault, SpeedingUpInContact) {
  // A box slides at 0.2 m/s and for 5 ms is pushed on, to 0.5 m/s: 1 mJ of 1.3 mJ more than it had.
  Motion slide;
  double x = 0.0;
  for (int i = 0; i <= 300; ++i) {
    slide.add(1e-3 * i, {x, 0, 0.015}, Quat::Identity());
    x += 1e-3 * std::clamp(0.2 + 0.06 * (i - 100), 0.2, 0.5);
  }
  MarkSet marks;
  marks.times_s = {0.1};
  marks.rest = false;
  const Certificate c = verify(slide.poses, body, marks, {}, {});
  expect_among(c, "in contact before");
  const double grown = 0.5 * body.mass_kg() * (0.5 * 0.5 - 0.2 * 0.2);
  EXPECT_LT(c.max_contact_energy_gain_j, grown);
  EXPECT_GT(c.max_contact_energy_gain_j,
            0.7 * grown);  // less a tenth, and what 0.05 m/s and 0.1 mm are worth
}

TEST_F(PlantedFault, HitThatSinksOnAfterwards) {
  // The ball lands 3 um above the ground without a bounce and sinks the rest: a hit all the same.
  const double t = bounce.impact_times_s.back();
  for (std::size_t i = bounce.first_at(t); i < bounce.poses.times_s.size(); ++i)
    bounce.poses.positions_m[i].z() += 3e-6 * std::exp(-(bounce.poses.times_s[i] - t) / 5e-3);
  const Certificate c = check_bounce();
  EXPECT_EQ(c.missed_hits, 0);
  bounce_marks.times_s.pop_back();
  EXPECT_EQ(check_bounce().extra_hits, 1);
}

TEST_F(PlantedFault, NotAtRest) {
  for (int i = bounce.first_at(bounce.impact_times_s.back() + 0.07);
       i < static_cast<int>(bounce.poses.times_s.size()); ++i)
    bounce.poses.positions_m[i].x() += 0.02 * (bounce.poses.times_s[i] - bounce.impact_times_s.back() - 0.07);
  expect_only(check_bounce(), "not at rest");
}

TEST_F(PlantedFault, EndsTooEarlyToBeAtRest) {
  const int end = bounce.first_at(bounce.impact_times_s.back() + 0.03);
  bounce.poses.times_s.resize(end);
  bounce.poses.positions_m.resize(end);
  bounce.poses.orientations.resize(end);
  expect_only(check_bounce(), "not at rest");
}

TEST_F(PlantedFault, FrozenInABalanceThatIsNone) {
  Motion motion = tipping_box(body);
  Motion frozen;
  for (int i = 0; i < 100; ++i)
    frozen.add(1e-3 * i, motion.poses.positions_m[0], motion.poses.orientations[0]);
  MarkSet marks;
  marks.times_s = {0.01};
  expect_among(verify(frozen.poses, body, marks, {}, {}), "nothing supports its mass centre");
}

TEST_F(PlantedFault, FrozenInTheAir) {
  for (Vec3& p : bounce.poses.positions_m) p.z() += 0.1;
  const Certificate c = check_bounce();
  expect_among(c, "departs from its parabola");
  EXPECT_EQ(c.missed_hits, 5);
}

TEST_F(PlantedFault, Teleport) {
  for (std::size_t i = bounce.first_at(bounce.impact_times_s[4] + 0.05); i < bounce.poses.times_s.size(); ++i)
    bounce.poses.positions_m[i].x() += 0.001;
  expect_among(check_bounce(), "jumps");
  for (std::size_t i = toss.first_at(toss.impact_times_s[2]); i < toss.poses.times_s.size(); ++i)
    toss.poses.orientations[i] = rotation_exp({0, 0, 0.1}) * toss.poses.orientations[i];
  expect_among(check_toss(), "jumps");
}

TEST_F(PlantedFault, NonUnitQuaternion) {
  bounce.poses.orientations[17].coeffs() *= 1.001;
  expect_only(check_bounce(), "sample 17");
}

TEST_F(PlantedFault, NotANumber) {
  bounce.poses.positions_m[9].y() = std::numeric_limits<double>::quiet_NaN();
  const Certificate c = check_bounce();
  expect_only(c, "sample 9 holds a number that is not finite");
  EXPECT_EQ(c.missed_hits, 5);
}

TEST_F(PlantedFault, TimesNotIncreasing) {
  std::swap(bounce.poses.times_s[30], bounce.poses.times_s[31]);
  expect_only(check_bounce(), "not later than the one before");
}

TEST_F(PlantedFault, TooFewSamples) {
  Motion motion;
  motion.add(0.0, Vec3::Zero(), Quat::Identity());
  expect_only(verify(motion.poses, round, bounce_marks, {}, {}), "too few");
  expect_only(verify({}, round, bounce_marks, {}, {}), "too few");
}

TEST_F(PlantedFault, CoarseSampling) {
  const int i = bounce.first_at(bounce.impact_times_s[0]) / 2;
  bounce.poses.times_s.erase(bounce.poses.times_s.begin() + i);
  bounce.poses.positions_m.erase(bounce.poses.positions_m.begin() + i);
  bounce.poses.orientations.erase(bounce.poses.orientations.begin() + i);
  expect_only(check_bounce(), "sampled too coarsely at 0.1");
}

TEST_F(PlantedFault, FalseRetimeClaim) {
  claims.retime = {1.0, 1.0, 1.03, 1.0, 1.0};
  const Certificate c = check_bounce();
  expect_among(c, "departs from its parabola");
  EXPECT_NEAR(c.max_gravity_error, 1.03 * 1.03 - 1.0, 1e-4);
}

TEST_F(PlantedFault, RetimingWithoutAClaim) {
  retime(&bounce, {1.0, 1.0, 0.97, 1.0, 1.0});
  bounce_marks = marks_of(bounce, true);
  expect_among(check_bounce(), "departs from its parabola");
}

TEST_F(PlantedFault, RetimedByMoreThan30Percent) {
  claims.retime = {1.0, 0.6, 1.0, 1.0, 1.0};
  retime(&bounce, claims.retime);
  bounce_marks = marks_of(bounce, true);
  expect_only(check_bounce(), "retimed by the ratio 0.6");
}

}  // namespace
}  // namespace ifa::verify::test
