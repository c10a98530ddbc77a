#include "ifa/forward/steer.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ifa/rigid/flight.hpp"
#include "solutions.hpp"

namespace ifa {
namespace {

constexpr double kInterval_s = 0.1;

State launched(const Body& body, RandomStream& random) {
  State s = sample::random_state(body, random, 0.0, 0.5, 20.0);
  s.velocity.z() = 0.5 * sample::kGravity * kInterval_s;
  return s;
}

State flown(const Body& body, const State& s) {
  Flight flight(body);
  flight.start(s, sample::downwards());
  return flight.at(kInterval_s);
}

// y is a change of velocity and spin itself.
Arrival freely(const State& pose, const Vec3& spin) {
  Mat36 velocities = Mat36::Zero(), spins = Mat36::Zero();
  velocities.leftCols<3>().setIdentity();
  spins.rightCols<3>().setIdentity();
  return {pose, spin, kInterval_s, velocities, spins};
}

State changed(State s, const Vec6& y) {
  s.velocity += y.head<3>();
  s.angular_velocity += y.tail<3>();
  return s;
}

// Against flights that begin otherwise. The cube's spin does not change in flight, as Arrival has it.
TEST(Arrival, IsTheDerivativeOfAFlight) {
  const Body body = sample::cube();
  RandomStream random(1, 0);
  for (int trial = 0; trial < 20; ++trial) {
    const State s = launched(body, random), then = flown(body, s);
    const Arrival arrival = freely(then, s.angular_velocity);
    for (int i = 0; i < 6; ++i) {
      constexpr double kStep = 1e-5;  // error of the difference: its square, and 1e-16 / kStep
      const State more = flown(body, changed(s, kStep * Vec6::Unit(i)));
      const State less = flown(body, changed(s, -kStep * Vec6::Unit(i)));
      const Vec2 moved = (more.position - less.position).head<2>() / (2.0 * kStep);
      const Vec3 turned = rotation_log(more.orientation * less.orientation.conjugate()) / (2.0 * kStep);
      EXPECT_LT((arrival.position.col(i) - moved).norm(), 1e-9);
      EXPECT_LT((arrival.turn.col(i) - turned).norm(), 1e-9);
    }
  }
}

Marks three_marks(Constraints asked) {
  Marks marks = sample::marks_at({0.1, 0.2, 0.4}, Ending::open);
  marks.constraints = std::move(asked);
  return marks;
}

// With a change that may be anything at hardly any cost, a flight ends where and how it is wanted.
TEST(Aim, ReachesWhatIsAskedWhereNothingHinders) {
  const Body body = sample::cube();
  RandomStream random(2, 0);
  for (int trial = 0; trial < 20; ++trial) {
    const State s = launched(body, random), then = flown(body, s);
    const Vec3 n = random.unit_vector();
    const Vec3 aside = random.unit_vector();
    const Vec3 wanted = (seen(body, then, n) + 0.2 * aside).normalized();  // some 10 degrees off
    const Marks marks = three_marks({{{0, {0, 0}}, {1, {0.1, 0.0}}, {2, {0.1, 0.03}}},
                                     {{0, Vec3::UnitX(), seen(body, s, Vec3::UnitX())}, {2, n, wanted}}});
    // Two positions and a heading fix the placement: the step has to do the rest.
    Alignment before;
    before.add(marks.constraints, 0, body, s);
    before.add_position(s.position.head<2>() + Vec2(0.1, 0.0), {0.1, 0.0});
    Arrival arrival = freely(then, s.angular_velocity);
    constexpr double kUnits = 1e4;  // |y|^2 counts for next to nothing
    arrival.position *= kUnits;
    arrival.turn *= kUnits;
    const Aim aim(marks, body, 2);
    ASSERT_TRUE(aim.any());
    Vec6 change = Vec6::Zero();
    for (int round = 0; round < 3; ++round) {  // Newton: the error is squared each time
      const State now = flown(body, changed(s, change));
      arrival.pose = now;
      change += kUnits * aim.step(before, arrival, Vec6::Zero(), kNever, {}).y;
    }
    Alignment after = before;
    after.add(marks.constraints, 2, body, flown(body, changed(s, change)));
    EXPECT_LT(after.cost() - before.cost(), 1e-4);  // 0.1 mm or 0.05 degrees; the weight of y is 1e-8
  }
}

TEST(Aim, StaysWithinTheRegionAndOnTime) {
  const Body body = sample::cube();
  RandomStream random(3, 0);
  for (int trial = 0; trial < 20; ++trial) {
    const State s = launched(body, random), then = flown(body, s);
    const Marks marks = three_marks({{{0, {0, 0}}, {1, {0.5, 0.0}}}, {}});  // far beyond reach
    Alignment before;
    before.add(marks.constraints, 0, body, s);
    const Arrival arrival = freely(then, s.angular_velocity);
    const Aim aim(marks, body, 1);
    const auto free = aim.step(before, arrival, Vec6::Zero(), 1.0, {});
    EXPECT_LE(free.y.norm(), 1.0);
    EXPECT_GT(free.y.norm(), 0.5);  // it goes as far as it may, to a factor of two in reluctance
    // It is aimed straight away from the start, and its speed sideways costs no time.
    Vec6 gradient = Vec6::Unit(2);
    const auto timed =
        aim.step(before, arrival, Vec6::Zero(), 1.0, Aim::Lateness{0.0, kInterval_s, gradient});
    EXPECT_LT(std::abs(timed.y[2]), 1e-9);
    EXPECT_GT(timed.y.head<2>().normalized().dot((then.position - s.position).head<2>().normalized()), 0.999);
    // What costs time on the way is taken back elsewhere: the lateness stays within a permille.
    gradient << 1.0, 1.0, 1.0, 0.0, 0.0, 0.0;
    const auto kept = aim.step(before, arrival, Vec6::Zero(), 1.0, Aim::Lateness{0.0, kInterval_s, gradient});
    EXPECT_LT(std::abs(gradient.dot(kept.y)), 0.1 * gradient.norm() * kept.y.norm());
  }
}

TEST(Aim, GoesStraightBetweenPositionsThatAreFar) {
  const Body body = sample::cube();
  const Marks marks = three_marks({{{0, {0, 0}}, {2, {0.3, 0.6}}}, {}});
  EXPECT_TRUE(Aim(marks, body, 1).any());
  EXPECT_FALSE(Aim(three_marks({{{0, {0, 0}}}, {}}), body, 1).any());
  EXPECT_FALSE(Aim(three_marks({}), body, 1).any());
  // 0.1 s of 0.3 s: a third of the way costs nothing, half of it does
  State at;
  Alignment before;
  before.add_position({0, 0}, {0, 0});
  before.add_position({1, 2}, {1, 2});
  const auto cost = [&](const Vec2& position) {
    at.position.head<2>() = position;
    Arrival arrival = freely(at, Vec3::Zero());
    arrival.position.setZero();
    return Aim(marks, body, 1).step(before, arrival, Vec6::Zero(), 1.0, {}).cost;
  };
  EXPECT_NEAR(cost({0.1, 0.2}), 0.0, 1e-9);
  EXPECT_GT(cost({0.15, 0.3}), 0.1);
}

TEST(Lying, TurnsToTheSteepnessThatIsWantedOnly) {
  RandomStream random(4, 0);
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3 now = random.unit_vector(), wanted = random.unit_vector();
    const Vec3 then = rotation_exp(turn_to(now, 7.0 * wanted)) * now;
    EXPECT_NEAR(then.z(), wanted.z(), 1e-12);                    // rounding
    EXPECT_NEAR(then.x() * now.y(), then.y() * now.x(), 1e-12);  // in the same heading
    EXPECT_NEAR(turn_to(now, wanted).norm(), std::abs(std::asin(now.z()) - std::asin(wanted.z())), 1e-7);
  }
}

// A cube on its face: over an edge it has to be lifted by (sqrt(2) - 1) / 2 of its edge.
TEST(Lying, ForGoodWithoutTheEnergyToTip) {
  const std::vector<Body> bodies{sample::box({0.1, 0.1, 0.1}, 1.0)};
  const SearchPhysics physics;
  Marks marks = sample::marks_at({0.1});
  marks.constraints.orientations.push_back({kAtRest, Vec3::UnitX(), kUp});
  const Problem problem{bodies, physics, marks};
  const double tip_j = 1.0 * sample::kGravity * 0.1 * 0.5 * (std::sqrt(2.0) - 1.0);
  const auto lying = [&](double energy_j, const Quat& orientation) {
    Candidate c;
    c.onset.before.orientation = orientation;
    c.onset.before.position.z() = 0.05;
    c.onset.after = c.onset.before;
    c.onset.after.velocity.x() = std::sqrt(2.0 * energy_j / 1.0);
    return lies_for_good(problem, c);
  };
  const Quat wrong = Quat::Identity(), right(Eigen::AngleAxisd(-0.5 * M_PI, Vec3::UnitY()));
  ASSERT_GT((right * Vec3::UnitX()).z(), 0.999);
  EXPECT_TRUE(lying(0.0, wrong));
  EXPECT_TRUE(lying(0.5 * tip_j, wrong));
  EXPECT_FALSE(lying(tip_j, wrong));
  EXPECT_FALSE(lying(0.0, right));
}

}  // namespace
}  // namespace ifa
