#include "ifa/signature/placement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

Vec2 planar(RandomStream& random) { return {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)}; }

Placement turn_by(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad), Vec2::Zero()}; }

struct Pairs {
  std::vector<std::pair<Vec2, Vec2>> positions;
  std::vector<std::pair<Vec3, Vec3>> directions;

  // The weighted squares that are left after a turn; for positions with the best shift after it, which is
  // that of the means.
  double left(const Placement& turn) const {
    Vec2 shift = Vec2::Zero();
    for (const auto& [own, wanted] : positions)
      shift += (wanted - turn.turned(own)) / static_cast<double>(positions.size());
    double sum = 0.0;
    for (const auto& [own, wanted] : positions)
      sum += 7000.0 * (turn.turned(own) + shift - wanted).squaredNorm();
    for (const auto& [own, wanted] : directions) sum += 140.0 * (turn.turned(own) - wanted).squaredNorm();
    return sum;
  }
};

TEST(Placement, IsTheBestOfAllAngles) {
  RandomStream random(3, 0);
  for (int trial = 0; trial < 50; ++trial) {
    Pairs pairs;
    Alignment alignment;
    const int positions = trial % 5, directions = (trial / 5) % 3 + (positions == 0 ? 1 : 0);
    for (int i = 0; i < positions; ++i) {
      pairs.positions.emplace_back(planar(random), planar(random));
      alignment.add_position(pairs.positions.back().first, pairs.positions.back().second);
    }
    for (int i = 0; i < directions; ++i) {
      pairs.directions.emplace_back(random.unit_vector(), random.unit_vector());
      alignment.add_direction(pairs.directions.back().first, pairs.directions.back().second);
    }
    double best = 1e300;
    constexpr int kAngles = 3600;
    for (int i = 0; i < kAngles; ++i)
      best = std::min(best, pairs.left(turn_by(2.0 * std::numbers::pi * i / kAngles)));
    const double cost = alignment.cost();
    EXPECT_LE(cost, best + 1e-9);  // rounding of sums of order 1000
    // Between two of the angles the sum, a + b cos(angle - c), falls by no more than b (0.9 mrad)^2 / 2, and
    // b is at most the sum of the weighted products, below 7000 * 4 * 0.18 + 140 * 3.
    EXPECT_NEAR(cost, best, 6000.0 * 0.5 * std::pow(std::numbers::pi / kAngles, 2));
    // and the placement is what has that cost
    const Placement p = alignment.best();
    double sum = 0.0;
    for (const auto& [own, wanted] : pairs.positions) sum += 7000.0 * (p.placed(own) - wanted).squaredNorm();
    for (const auto& [own, wanted] : pairs.directions) sum += 140.0 * (p.turned(own) - wanted).squaredNorm();
    EXPECT_NEAR(sum, cost, 1e-9);
  }
}

TEST(Placement, FindsTheWayBackExactly) {
  RandomStream random(4, 0);
  const Placement moved{std::cos(2.0), std::sin(2.0), Vec2(0.3, -0.7)};
  Alignment alignment;
  for (int i = 0; i < 5; ++i) {
    const Vec2 own = planar(random);
    alignment.add_position(own, moved.placed(own));
  }
  const Placement p = alignment.best();
  EXPECT_NEAR(p.cosine, moved.cosine, 1e-14);  // rounding
  EXPECT_NEAR(p.sine, moved.sine, 1e-14);
  EXPECT_LT((p.shift_m - moved.shift_m).norm(), 1e-14);
  EXPECT_NEAR(alignment.cost(), 0.0, 1e-11);  // of squares of order 1000
}

TEST(Placement, DoesNotMirror) {
  Alignment alignment;
  for (const Vec2& own : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 0.5)})
    alignment.add_position(own, Vec2(own.x(), -own.y()));
  const Placement p = alignment.best();
  EXPECT_NEAR(p.cosine * p.cosine + p.sine * p.sine, 1.0, 1e-15);
  EXPECT_GT(alignment.cost(), 100.0);  // a mirror would leave nothing
}

TEST(Placement, OnePositionOnlyShifts) {
  Alignment alignment;
  alignment.add_position({0.2, 0.1}, {1.0, -1.0});
  EXPECT_EQ(alignment.best().cosine, 1.0);
  EXPECT_EQ(alignment.best().sine, 0.0);
  EXPECT_LT((alignment.best().placed(Vec2(0.2, 0.1)) - Vec2(1.0, -1.0)).norm(), 1e-15);
  EXPECT_EQ(alignment.cost(), 0.0);
}

TEST(Placement, NothingAskedMovesNothing) {
  const Alignment alignment;
  EXPECT_EQ(alignment.best().cosine, 1.0);
  EXPECT_EQ(alignment.best().shift_m, Vec2(0, 0));
  EXPECT_EQ(alignment.cost(), 0.0);
}

TEST(Placement, ADirectionUpLeavesTheHeadingFree) {
  Alignment alignment;
  alignment.add_direction(Vec3(0.1, 0.2, 0.9).normalized(), kUp);
  EXPECT_EQ(alignment.best().cosine, 1.0);
  // |a - b|^2 = 2 - 2 a . b
  EXPECT_NEAR(alignment.cost(), 140.0 * (2.0 - 2.0 * Vec3(0.1, 0.2, 0.9).normalized().z()), 1e-12);
}

// A placed state moves as the state itself, seen from elsewhere: any point of the body goes along.
TEST(Placement, PlacesPointsAndVelocitiesOfAState) {
  const Body body = sample::box({0.1, 0.2, 0.3}, 1.0);
  RandomStream random(5, 0);
  const State s = sample::random_state(body, random, 0.1, 2.0, 10.0);
  const Placement p{std::cos(-2.9), std::sin(-2.9), Vec2(0.4, 0.1)};
  const State t = p.placed(s);
  for (int i = 0; i < 5; ++i) {
    const Vec3 r = random.unit_vector();
    EXPECT_LT((t.position + t.orientation * r - p.placed(Vec3(s.position + s.orientation * r))).norm(),
              1e-14);
    const Vec3 v = s.velocity + s.angular_velocity.cross(s.orientation * r);
    EXPECT_LT((t.velocity + t.angular_velocity.cross(t.orientation * r) - p.turned(v)).norm(), 1e-13);
  }
}

TEST(Placement, SeesABodyDirectionInBodyAxes) {
  Body::Definition d;
  d.vertices_m = {{0, 0, 0}, {0.1, 0.02, 0}, {0, 0.2, 0.01}, {0.03, 0, 0.3}};
  d.inertia_kg_m2 << 3, 0.4, 0.2, 0.4, 2.5, 0.1, 0.2, 0.1, 2;  // principal axes far from the body's
  d.mass_kg = 1.0;
  const Body body = Body::make(d);
  RandomStream random(6, 0);
  State s;
  s.orientation = random.rotation();
  const Vec3 n = random.unit_vector();
  EXPECT_LT((seen(body, to_principal(body, s), n) - s.orientation * n).norm(), 1e-14);
}

}  // namespace
}  // namespace ifa
