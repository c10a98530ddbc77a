#include "ifa/signature/factors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "ifa/base/random.hpp"

namespace ifa {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Vec3 across(const Vec3& v, const Vec3& any) { return v.cross(any).normalized(); }

// Paper eq. 2, at its edge: 40 % of the linear change along it, 20 degrees across; 20 % and 10 degrees for
// the spin.
TEST(PlausibleRegion, EdgeHasExcessOne) {
  RandomStream random(1, 0);
  for (int i = 0; i < 100; ++i) {
    const Vec3 dv = random.uniform(0.1, 5.0) * random.unit_vector(),
               dw = random.uniform(1.0, 90.0) * random.unit_vector();
    const PlausibleRegion region(dv, dw, 0.02);
    const Vec3 any = random.unit_vector(), none = Vec3::Zero();
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_NEAR(region.excess(sign * 0.4 * dv, none), 1.0, 1e-13);
      EXPECT_NEAR(region.excess(sign * 0.4 * dv.norm() * std::tan(20.0 * kDegree) * across(dv, any), none),
                  1.0, 1e-12);
      EXPECT_NEAR(region.excess(none, sign * 0.2 * dw), 1.0, 1e-13);
      EXPECT_NEAR(region.excess(none, sign * 0.2 * dw.norm() * std::tan(10.0 * kDegree) * across(dw, any)),
                  1.0, 1e-12);
    }
    // It grows with the square, and the two halves add.
    EXPECT_NEAR(region.excess(0.8 * dv, none), 4.0, 1e-12);
    EXPECT_NEAR(region.excess(0.4 * dv, 0.2 * dw), 2.0, 1e-12);
    EXPECT_EQ(region.excess(none, none), 0.0);
  }
}

TEST(PlausibleRegion, BallCoordinatesAreItsOwn) {
  RandomStream random(2, 0);
  for (int i = 0; i < 100; ++i) {
    const PlausibleRegion region(3.0 * random.unit_vector(), 40.0 * random.unit_vector(), 0.02);
    Vec6 y;
    for (int k = 0; k < 6; ++k) y[k] = random.uniform(-1.0, 1.0);
    EXPECT_NEAR(region.excess(region.velocity_offset(y), region.spin_offset(y)), y.squaredNorm(), 1e-12);
  }
  // The first of each half lies along the change.
  const Vec3 dv(0, 0, 2), dw(1, 2, 2);
  const PlausibleRegion region(dv, dw, 0.02);
  EXPECT_LT((region.velocity_offset(Vec6::Unit(0)) - 0.4 * dv).norm(), 1e-15);
  EXPECT_LT((region.spin_offset(Vec6::Unit(3)) - 0.2 * dw).norm(), 1e-15);
}

TEST(PlausibleRegion, TurnsWithTheChange) {
  RandomStream random(3, 0);
  const Vec3 dv(0.1, 0.2, 2.0), dw(30.0, -5.0, 1.0), v(0.05, -0.1, 0.3), w(1, 2, 3);
  const double expected = PlausibleRegion(dv, dw, 0.02).excess(v, w);
  for (int i = 0; i < 20; ++i) {
    const Quat turn = random.rotation();
    EXPECT_NEAR(PlausibleRegion(turn * dv, turn * dw, 0.02).excess(turn * v, turn * w), expected,
                1e-12 * expected);
  }
}

// Hard case 24: a vanishing change is floored at 0.01 m/s, and at that over the radius for the spin.
TEST(PlausibleRegion, VanishingChangesAreFloored) {
  const double radius = 0.02;
  for (const double tiny : {0.0, 1e-300, 1e-12, 0.0099}) {
    const PlausibleRegion region(Vec3(0, 0, tiny), Vec3(tiny, 0, 0), radius);
    EXPECT_NEAR(region.excess(Vec3(0, 0, 0.004), Vec3::Zero()), 1.0, 1e-12) << tiny;
    EXPECT_EQ(region.excess(Vec3::Zero(), Vec3::Zero()), 0.0);
    // Half a radian a second is the floor; along a change of nothing every direction is allowed.
    const double excess = region.excess(Vec3::Zero(), Vec3(0.1, 0, 0));
    EXPECT_TRUE(std::isfinite(excess) && excess >= 1.0 - 1e-12) << tiny;
  }
}

// Where the paper says that each factor is one half, to the digits it gives them with (section 5.4).
TEST(Factors, AreOneHalfAtThePapersHalfWidths) {
  const double half = std::log(2.0);
  EXPECT_NEAR(velocity_factor(half), 0.5, 1e-15);  // "approximately 0.69"
  EXPECT_NEAR(std::sqrt(half / 100.0), 0.07, 0.015);
  EXPECT_NEAR(time_factor(1.0 + std::sqrt(half / 100.0), 1.0), 0.5, 1e-12);
  EXPECT_NEAR(amplitude_factor(1.5, 1.0), 0.5, 0.002);   // ln 2 / 0.25 = 2.773, and c_a = 2.78
  EXPECT_NEAR(length_factor(0.110, 0.100), 0.5, 0.004);  // ln 2 / 1e-4 = 6931, and c = 7000
  EXPECT_NEAR(centroid_factor(0.040, 0.050), 0.5, 0.004);
}

TEST(Factors, AreOneForWhatIsAskedAndSymmetric) {
  EXPECT_EQ(velocity_factor(0.0), 1.0);
  for (const double x : {1e-6, 0.05, 0.3, 7.0}) {
    EXPECT_EQ(time_factor(x, x), 1.0);
    EXPECT_EQ(amplitude_factor(x, x), 1.0);
    EXPECT_EQ(length_factor(x, x), 1.0);
    EXPECT_EQ(time_factor(x, 1.1 * x), time_factor(1.1 * x, x));
    EXPECT_EQ(amplitude_factor(x, x + 0.25), amplitude_factor(x + 0.25, x));
    EXPECT_LT(time_factor(x, 1.2 * x), time_factor(x, 1.1 * x));
  }
}

Marks three_marks() {
  Marks m;
  m.times_s = {0.1, 0.5, 0.9};
  m.durations_s = {0.0, 0.0, 0.1};
  m.amplitudes = {2.0, 1.0, 0.5};
  m.centroids_s = {std::nan(""), std::nan(""), 0.05};
  return m;
}

TEST(SoundFactors, AmplitudesAreRelativeToTheFirst) {
  const Marks marks = three_marks();
  Event e;
  e.amplitude = 0.03;
  EXPECT_EQ(sound_factors(e, marks, 0, 0.03).amplitude, 1.0);
  EXPECT_EQ(sound_factors(e, marks, 0, 99.0).amplitude, 1.0);           // its own reference
  EXPECT_NEAR(sound_factors(e, marks, 1, 0.06).amplitude, 1.0, 1e-15);  // half of the first, as marked
  EXPECT_NEAR(sound_factors(e, marks, 1, 0.03).amplitude, std::exp(-2.78 * 0.25), 1e-15);
  Marks silent = marks;
  silent.amplitudes.clear();
  EXPECT_EQ(sound_factors(e, silent, 1, 0.03).amplitude, 1.0);
}

TEST(SoundFactors, LengthsOfDiscreteEventsAreNotCompared) {
  const Marks marks = three_marks();
  Event e;
  e.amplitude = 1.0;
  EXPECT_EQ(sound_factors(e, marks, 1, 1.0).length, 1.0);
  e.length_s = 0.02;  // continuous where a click was asked for
  EXPECT_NEAR(sound_factors(e, marks, 1, 1.0).length, std::exp(-7000.0 * 4e-4), 1e-15);
  EXPECT_EQ(sound_factors(e, marks, 1, 1.0).centroid, 1.0);
  e.length_s = 0.09;
  e.centroid_s = 0.06;
  const Factors f = sound_factors(e, marks, 2, 1.0);
  EXPECT_NEAR(f.length, std::exp(-7000.0 * 1e-4), 1e-13);
  EXPECT_NEAR(f.centroid, std::exp(-7000.0 * 1e-4), 1e-13);
}

// Eqs. 12 and 13: the product of 6 n (3 n) factors to the power 1 / (6 n) (1 / (3 n)).
TEST(Score, IsTheGeometricMean) {
  std::vector<Factors> factors{{1.0, 1.0, 1.0, 0.9, 1.0, 1.0}, {0.5, 0.8, 0.7, 0.4, 0.3, 0.2}};
  const double product = 0.9 * 0.5 * 0.8 * 0.7 * 0.4 * 0.3 * 0.2;
  EXPECT_NEAR(score(factors), std::pow(product, 1.0 / 12.0), 1e-15);
  EXPECT_NEAR(score_without_sound(factors), std::pow(0.5 * 0.8 * 0.7, 1.0 / 6.0), 1e-15);
  EXPECT_NEAR(log_product(factors[1]), std::log(product / 0.9), 1e-14);
  EXPECT_EQ(score({Factors{}}), 1.0);
}

TEST(Score, OfAFactorOfZeroIsFinite) {
  Factors none;
  none.velocity = 0.0;
  EXPECT_TRUE(std::isfinite(log_product(none)));
  EXPECT_GE(score({none}), 0.0);
  EXPECT_LT(score({none, none}), 1e-40);
}

}  // namespace
}  // namespace ifa
