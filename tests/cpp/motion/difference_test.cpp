#include "ifa/motion/difference.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ifa/base/error.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

const Vec3 kHalf(0.015, 0.01, 0.006);

// A box whose mesh axes are not its principal ones, so that a mix-up of axes shows.
Mat3 mesh_axes() { return rotation_exp({0.4, -0.7, 1.1}).toRotationMatrix(); }

Body turned_box(const Material& material = {}) {
  Body::Definition d = sample::box(2.0 * kHalf, 0.02, material).definition();
  for (Vec3& v : d.vertices_m) v = mesh_axes() * v;
  d.inertia_kg_m2 = mesh_axes() * d.inertia_kg_m2 * mesh_axes().transpose();
  return Body::make(d);
}

Motion thrown(const Body& body, std::uint64_t seed) {
  RandomStream random(seed, 0);
  const ifa::Run run = simulate(body, sample::random_state(body, random, 0.2, 1.5, 20.0), {}, 2.0);
  return {body, sample::downwards(), run.nodes, run.hits, {}};
}

// The same motion elsewhere on the ground.
Motion moved(const Motion& motion, double yaw, double x_m, double y_m, double up_m = 0.0) {
  const Quat turn = rotation_exp(yaw * kUp);
  std::vector<Node> nodes = motion.nodes();
  for (Node& n : nodes) {
    n.state.position = turn * n.state.position + Vec3(x_m, y_m, up_m);
    n.state.orientation = turn * n.state.orientation;
    n.state.velocity = turn * n.state.velocity;
    n.state.angular_velocity = turn * n.state.angular_velocity;
  }
  return {motion.body(), sample::downwards(), nodes, {}, motion.time()};
}

constexpr double kFrom_s = 0.1, kTo_s = 0.9;

TEST(Difference, IsNoneForTheSameMotionElsewhere) {
  const Motion a = thrown(turned_box(), 3);
  EXPECT_EQ(difference(a, a, kFrom_s, kTo_s), 0.0);
  RandomStream random(5, 0);
  for (int i = 0; i < 20; ++i) {
    const double far_m = 3.0;
    const Motion b =
        moved(a, random.uniform(-4.0, 4.0), random.uniform(-far_m, far_m), random.uniform(-far_m, far_m));
    // Rounding of metres, 4e-16, over a radius of 0.02 m is 2e-14; the exact motions between nodes of the two
    // round apart by some tens of that.
    EXPECT_LT(difference(a, b, kFrom_s, kTo_s), 1e-11) << i;
  }
}

TEST(Difference, IsSymmetricAndBlindToPlaceAndHeading) {
  const Body body = turned_box();
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Motion a = thrown(body, 2 * seed), b = thrown(body, 2 * seed + 1);
    const double d = difference(a, b, kFrom_s, kTo_s);
    EXPECT_GT(d, 0.5);
    EXPECT_NEAR(difference(b, a, kFrom_s, kTo_s), d, 1e-12 * d);  // sums of 200 terms in other axes
    EXPECT_NEAR(difference(a, moved(b, 2.0, 0.7, -0.4), kFrom_s, kTo_s), d, 1e-11 * d);
  }
}

// Two balls dropped from heights that differ by dz.
TEST(Difference, HeightsAreNotRegistered) {
  const Body ball = sample::ball(0.02, 0.01);
  State high;
  high.position.z() = 1.0;
  State higher = high;
  higher.position.z() = 1.03;
  const Motion a(ball, sample::downwards(), simulate(ball, high, {}, 0.4).nodes, {}, {});
  const Motion b(ball, sample::downwards(), simulate(ball, higher, {}, 0.4).nodes, {}, {});
  EXPECT_NEAR(difference(a, b, 0.0, 0.4), 0.03 / 0.02, 1e-13);  // rounding of 1 m over 0.02 m
}

// Still bodies: a ball turned by an angle about x differs at each point by 2 sin(angle / 2) times its
// distance from x, whose mean square is 2/5 R^2. About z there is no difference.
TEST(Difference, OfTurnedBalls) {
  const Body ball = sample::ball(0.02, 0.01);
  const auto still = [&](const Vec3& rotation) {
    State s;
    s.position.z() = 0.02;
    s.orientation = rotation_exp(rotation);
    return Motion(ball, sample::downwards(), {{0.0, s, Phase::rest}}, {}, {});
  };
  const Motion upright = still(Vec3::Zero());
  EXPECT_LT(difference(upright, still({0, 0, 1.3}), 0.0, 1.0), 1e-15);
  for (const double angle : {0.01, 0.5, 1.5}) {
    // No turn about z can help: M is diagonal, diag(1, cos(angle)).
    EXPECT_NEAR(difference(upright, still({angle, 0, 0}), 0.0, 1.0),
                2.0 * std::sin(0.5 * angle) * std::sqrt(0.4), 1e-14);
  }
}

// The definition itself: a quadrature over the box (two Gauss points along each axis integrate squares
// exactly), the shift and the turn found by looking for the least.
TEST(Difference, AgreesWithBruteForce) {
  const Body body = turned_box();
  std::vector<Vec3> material;
  for (int i = 0; i < 8; ++i)
    material.push_back(
        mesh_axes() *
        (kHalf / std::sqrt(3.0)).cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  for (std::uint64_t seed = 20; seed < 26; seed += 2) {
    const Motion a = thrown(body, seed), b = thrown(body, seed + 1);
    std::vector<double> times;
    const int n = 192;  // 240 Hz for 0.8 s
    for (int i = 0; i < n; ++i) times.push_back(kFrom_s + (kTo_s - kFrom_s) * (i + 0.5) / n);
    std::vector<Vec3> pa, pb;
    const auto cloud = [&](const Motion& motion, std::vector<Vec3>& points) {
      for (const State& s : motion.sample(times))
        for (const Vec3& r : material) points.push_back(s.position + s.orientation * r);
    };
    cloud(a, pa);
    cloud(b, pb);
    const auto apart = [&](double yaw) {
      const Mat3 turn = rotation_exp(yaw * kUp).toRotationMatrix();
      Vec3 mean = Vec3::Zero();
      for (std::size_t i = 0; i < pa.size(); ++i) mean += pa[i] - turn * pb[i];
      mean /= static_cast<double>(pa.size());
      mean.z() = 0.0;
      double sum = 0.0;
      for (std::size_t i = 0; i < pa.size(); ++i) sum += (pa[i] - turn * pb[i] - mean).squaredNorm();
      return std::sqrt(sum / static_cast<double>(pa.size())) / body.bounding_radius_m();
    };
    double best = 0.0, least = std::numeric_limits<double>::infinity();
    for (double step = 0.1; step > 1e-8; step *= 0.1) {
      const double middle = best;
      for (int i = -32; i <= 32; ++i) {  // +-3.2 rad at first, all of the circle
        const double d = apart(middle + i * step);
        if (d >= least) continue;
        least = d;
        best = middle + i * step;
      }
    }
    EXPECT_NEAR(difference(a, b, kFrom_s, kTo_s), least, 1e-12 * least)
        << seed;  // flat in the turn: its square counts
  }
}

TEST(Difference, TakesOneBodyOfAnyMaterial) {
  const Motion a = thrown(turned_box(), 1), b = thrown(turned_box({0.2, 0.6, 0.0, 0.0}), 1);
  EXPECT_GT(difference(a, b, kFrom_s, kTo_s), 0.0);
  EXPECT_THROW(difference(a, thrown(sample::ball(0.02, 0.02), 1), kFrom_s, kTo_s), ArgumentError);
  EXPECT_THROW(difference(a, thrown(sample::box(2.0 * kHalf, 0.02), 1), kFrom_s, kTo_s),
               ArgumentError);  // other axes
}

TEST(Difference, RefusesTimesThatAreNone) {
  const Motion a = thrown(turned_box(), 1);
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  EXPECT_THROW(difference(a, a, 0.5, 0.5), ArgumentError);
  EXPECT_THROW(difference(a, a, 0.5, 0.4), ArgumentError);
  EXPECT_THROW(difference(a, a, nan, 0.4), ArgumentError);
  EXPECT_THROW(difference(a, a, 0.0, nan), ArgumentError);
  EXPECT_THROW(difference(a, a, 0.0, inf), ArgumentError);
  EXPECT_THROW(difference(a, a, -inf, 0.0), ArgumentError);
  EXPECT_THROW(difference(a, a, -1e308, 1e308), ArgumentError);
  EXPECT_EQ(difference(a, a, 0.0, 1e300), 0.0);  // however long
}

}  // namespace
}  // namespace ifa
