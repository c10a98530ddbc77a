// Motion connections, against flights made by other code, symmetries and brute force.
#include "ifa/graph/connection.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "ifa/base/random.hpp"
#include "ifa/graph/paper_shooting.hpp"
#include "ifa/motion/sampling.hpp"
#include "ifa/rigid/flight.hpp"
#include "ifa/rigid/views.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::angle_between;

constexpr double kPi = std::numbers::pi;

struct Problem {
  State from, like, to;
  double duration_s;
};

// `like` is `from` with another spin and tilt, each by up to so much, and `to` is where its flight ends.
Problem problem_of(const Body& body, RandomStream& random, double spin_rad_s, double other_rad) {
  Problem p;
  p.duration_s = random.uniform(0.02, 0.3);
  p.from = sample::random_state(body, random, 0.0, 1.0, spin_rad_s);
  p.like = p.from;
  p.like.orientation = rotation_exp(other_rad * random.uniform() * random.unit_vector()) * p.from.orientation;
  p.like.angular_velocity += other_rad / p.duration_s * random.uniform() * random.unit_vector();
  Flight flight(body);
  flight.start(p.like, sample::downwards());
  p.to = flight.at(p.duration_s);
  return p;
}

Connection connect(const Body& body, const Problem& p) {
  return Connector(body).connect(p.from, p.like, p.to, p.duration_s, sample::downwards());
}

State end_of(const Body& body, const State& start, double duration_s) {
  Flight flight(body);
  flight.start(start, sample::downwards());
  return flight.at(duration_s);
}

std::vector<Body> bodies() {
  return {sample::box({0.08, 0.05, 0.001}, 0.005),
          sample::box({0.05, 0.02, 0.03}, 0.02),
          sample::coin(),
          sample::rod(0.1, 0.001, 0.01),
          sample::ball(0.02, 0.01),
          sample::box({0.02, 0.02 + 1e-9, 0.02 - 1e-9}, 0.01)};
}

TEST(Connection, ItsFlightEndsAtTheTarget) {
  int converged = 0, all = 0;  // of all problems
  for (const Body& body : bodies()) {
    RandomStream random(1, 0);
    for (int k = 0; k < 200; ++k, ++all) {
      const Problem p = problem_of(body, random, 40.0, 1.0);
      const Connection c = connect(body, p);
      EXPECT_EQ(c.start.position, p.from.position);
      EXPECT_EQ(c.start.orientation.coeffs(), p.from.orientation.coeffs());
      EXPECT_TRUE(c.converged() || c.shooting.outcome == Shot::fold) << body.name() << " " << k;
      if (!c.converged()) continue;
      ++converged;
      const State end = end_of(body, c.start, p.duration_s);
      // 1e-10 is asked of the shooting; the rounding of two flights of up to 13 rad is 1e-13.
      EXPECT_LE(angle_between(end.orientation, p.to.orientation), 1.01e-10) << body.name() << " " << k;
      EXPECT_LE((end.position - p.to.position).norm(), 1e-14);  // rounding of 1 m
    }
  }
  EXPECT_GE(converged, all * 95 / 100);  // the rest are folds, of the flat bodies
}

TEST(Connection, AFlightOfItsOwnIsFoundAgain) {
  for (const Body& body : bodies()) {
    RandomStream random(2, 0);
    for (int k = 0; k < 50; ++k) {
      Problem p = problem_of(body, random, 8.0, 0.0);  // below half a turn: a ball has no other winding
      const Connection exact = connect(body, p);
      EXPECT_EQ(exact.shooting.iterations, 0);
      // Rounding of a spin of 8 rad/s, and of a ball's turn over 0.02 s, from which it follows.
      EXPECT_LE((exact.start.angular_velocity - p.from.angular_velocity).norm(), 1e-12);
      EXPECT_LE((exact.start.velocity - p.from.velocity).norm(), 1e-12);  // 1e-16 m over 0.02 s

      p.like.angular_velocity += 0.1 / p.duration_s * random.unit_vector();
      const Connection again = connect(body, p);
      ASSERT_TRUE(again.converged());
      // 1e-10 rad of the end, which turns by a fifth of what the spin does or more for these.
      EXPECT_LE((again.start.angular_velocity - p.from.angular_velocity).norm() * p.duration_s, 5e-10);
    }
  }
}

// The same motion backwards: from the target, with reversed spins, to the start.
TEST(Connection, BackwardsItIsTheReversedMotion) {
  for (const Body& body : bodies()) {
    RandomStream random(3, 0);
    for (int k = 0; k < 50; ++k) {
      const Problem p = problem_of(body, random, 8.0, 0.1);
      const Connection c = connect(body, p);
      ASSERT_TRUE(c.converged());
      const State end = end_of(body, c.start, p.duration_s);
      State back = p.to, like = p.to;
      back.angular_velocity = -p.to.angular_velocity;
      like.angular_velocity = -(p.to.angular_velocity + 0.1 * random.unit_vector());
      const Connection reversed =
          Connector(body).connect(back, like, p.from, p.duration_s, sample::downwards());
      ASSERT_TRUE(reversed.converged());
      // Each within 1e-10 rad of its target, with slopes as above.
      EXPECT_LE((reversed.start.angular_velocity + end.angular_velocity).norm() * p.duration_s, 2e-9);
      EXPECT_LE((reversed.start.velocity + end.velocity).norm(), 1e-12);
    }
  }
}

State turned(const State& s, const Quat& yaw) {
  return {yaw * s.position, yaw * s.orientation, yaw * s.velocity, yaw * s.angular_velocity};
}

// In the plane x = 0; the body in the plane across its first principal axis.
State mirrored(const State& s) {
  const Mat3 flip = Vec3(-1, 1, 1).asDiagonal();
  return {flip * s.position, Quat(Mat3(flip * s.orientation.toRotationMatrix() * flip)), flip * s.velocity,
          -(flip * s.angular_velocity)};
}

TEST(Connection, TurnedAndMirroredProblemsHaveTurnedAndMirroredConnections) {
  const Quat yaw = rotation_exp(2.1 * kUp);
  for (const Body& body : bodies()) {
    RandomStream random(4, 0);
    for (int k = 0; k < 50; ++k) {
      const Problem p = problem_of(body, random, 20.0, 0.5);
      const Connection c = connect(body, p);
      for (const bool mirror : {false, true}) {
        const auto moved = [&](const State& s) { return mirror ? mirrored(s) : turned(s, yaw); };
        const Connection other = connect(body, {moved(p.from), moved(p.like), moved(p.to), p.duration_s});
        EXPECT_EQ(other.shooting.outcome, c.shooting.outcome);
        if (!c.converged()) continue;
        const State expected = moved(c.start);
        // Two ends within 1e-10 rad, slopes down to 1e-2 near folds.
        EXPECT_LE((other.start.angular_velocity - expected.angular_velocity).norm() * p.duration_s, 2e-8);
        EXPECT_LE((other.start.velocity - expected.velocity).norm(), 1e-12);
      }
    }
  }
}

// The slope against central differences of the engine's flights: an error of 1e-8 from steps of 1e-4 rad
// (their square), 1e-11 from rounding, 1e-7 from the slope's own difference; times up to 30 rad of turning.
TEST(Turn, SlopeIsTheDerivativeOfTheTurn) {
  for (const Body& body : bodies()) {
    const lanes::BodyView view = view_of(body);
    RandomStream random(5, 0);
    for (int k = 0; k < 40; ++k) {
      Vec3 spin = 10.0 * random.uniform() * random.unit_vector();
      if (k < 3) spin = 4.0 * Vec3::Unit(k);  // about a principal axis
      if (k == 3) spin.setZero();
      const auto end = [&](const Vec3& w) {
        State s;
        s.angular_velocity = w;
        return end_of(body, s, 1.0).orientation;
      };
      const Turn turn = turn_with_slope(view, spin);
      EXPECT_LE(angle_between(turn.rotation, end(spin)), 1e-13);
      EXPECT_LE(angle_between(turn.rotation, turn_of(view, spin).rotation), 1e-13);
      constexpr double kStep = 1e-4;
      for (int i = 0; i < 3; ++i) {
        const Quat low = end(spin - kStep * Vec3::Unit(i)), high = end(spin + kStep * Vec3::Unit(i));
        const Vec3 slope =
            (rotation_log(turn.rotation.conjugate() * high) - rotation_log(turn.rotation.conjugate() * low)) /
            (2.0 * kStep);
        EXPECT_LE((turn.slope.col(i) - slope).norm(), 3e-5) << body.name() << " " << spin.transpose();
      }
    }
  }
}

// At a fold two spins merge: just before it there are two that reach the target, and beyond it none near by.
TEST(Shooting, OnlyBeforeACertifiedFoldTwoSpinsReachTheTarget) {
  const Body card = sample::box({0.0856, 0.054, 0.00076}, 0.005);
  const lanes::BodyView view = view_of(card);
  RandomStream random(6, 0);
  int folds = 0;
  for (int k = 0; k < 400 && folds < 12; ++k) {
    const Vec3 guess = random.uniform(3.0, 12.0) * random.unit_vector();
    const Quat begin = turn_of(view, guess).rotation;
    const Vec3 way = random.uniform(0.3, 2.0) * random.unit_vector();
    const Shooting fold = follow(view, begin * rotation_exp(way), guess);
    if (fold.outcome != Shot::fold) continue;
    ++folds;
    ASSERT_GT(fold.fold_at, 0.0);
    ASSERT_LT(fold.fold_at, 1.0);
    const Turn at = turn_with_slope(view, fold.spin_rad);
    EXPECT_LE(angle_between(at.rotation, begin * rotation_exp(fold.fold_at * way)), 1e-9);
    const auto svd = at.slope.jacobiSvd(Eigen::ComputeFullV);
    EXPECT_LE(svd.singularValues()[2], 1e-3);  // it is taken where the tangent rises by 1e-4 at most
    const Vec3 null = svd.matrixV().col(2);
    // Where the way is short by d, the two are apart by 2 sqrt(2 d / curvature): look for them from points
    // well on either side.
    const auto spins = [&](double share) {
      const Quat target = begin * rotation_exp(share * way);
      std::vector<Vec3> found;
      for (double side = -0.3; side <= 0.3; side += 0.025) {
        Vec3 spin = fold.spin_rad + side * null;
        for (int i = 0; i < 60; ++i) {  // plain Newton, bounded steps
          const Turn turn = turn_with_slope(view, spin);
          const Vec3 error = rotation_log(target.conjugate() * turn.rotation);
          if (error.norm() < 1e-9) {
            bool known = (spin - fold.spin_rad).norm() > 0.3;  // of another branch
            for (const Vec3& w : found) known = known || (w - spin).norm() < 1e-5;
            if (!known) found.push_back(spin);
            break;
          }
          Vec3 step = turn.slope.fullPivLu().solve(-error);
          if (step.norm() > 0.1) step *= 0.1 / step.norm();
          spin += step;
        }
      }
      return found.size();
    };
    const double aside = 1e-4 / way.norm();
    EXPECT_EQ(spins(fold.fold_at - aside), 2u) << k;
    EXPECT_EQ(spins(fold.fold_at + aside), 0u) << k;
  }
  EXPECT_EQ(folds, 12);
}

TEST(Shooting, KeepsTheWindingsOfTheGuess) {
  const Body ball = sample::ball(0.02, 0.01), rod = sample::rod(0.1, 0.001, 0.01);
  for (const double turns : {0.0, 0.3, 1.2, 3.4, 7.9}) {
    const double angle = 2.0 * kPi * turns;
    for (const Body* body : {&ball, &rod}) {
      const Vec3 axis = Vec3::UnitX();  // the rod's own
      const Vec3 guess = (angle + 0.4) * axis;
      const Shooting s = shoot(view_of(*body), rotation_exp(angle * axis), guess, guess);
      ASSERT_EQ(s.outcome, Shot::converged);
      EXPECT_LE((s.spin_rad - angle * axis).norm(), 2e-10);  // 1e-10 of the end, and rounding
    }
  }
  // A whole number of turns: about any axis, so about the guess's.
  const Vec3 guess(3.0, -11.0, 5.0);
  const Shooting s = shoot(view_of(ball), Quat::Identity(), guess, guess);
  EXPECT_LE((s.spin_rad - 4.0 * kPi * guess.normalized()).norm(), 1e-13);  // |guess| is 12.4 rad: two turns
}

// The paper's scheme has a double root: about a fixed axis the error halves in each step, exactly.
TEST(PaperShooting, TheErrorHalvesInEachStep) {
  const lanes::BodyView ball = view_of(sample::ball(0.02, 0.01));
  const Vec3 spin(0.0, 0.0, 2.0);
  for (const int steps : {0, 100}) {
    const PaperShooting s =
        shoot_as_paper(ball, rotation_exp(spin), spin + Vec3(0.0, 0.0, 0.1), 1e-3, 100, {steps});
    EXPECT_TRUE(s.converged);
    EXPECT_EQ(s.iterations, 7);  // 0.1 / 2^7 < 1e-3
    // 1e-7 rad of the forward difference; and steps of 0.02 rad are good to their fourth power
    EXPECT_NEAR(s.error_rad, 0.1 / 128.0, 3e-7);
  }
  const Body card = sample::box({0.08, 0.05, 0.001}, 0.005);
  RandomStream random(8, 0);
  for (int k = 0; k < 20; ++k) {
    const Problem p = problem_of(card, random, 5.0, 0.2);
    const Quat &q0 = p.from.orientation, &q1 = p.like.orientation;
    const Vec3 guess = p.duration_s * paper_guess(view_of(card), q0, q0.conjugate() * p.from.angular_velocity,
                                                  q1, q1.conjugate() * p.like.angular_velocity);
    const Vec3 momentum =
        0.5 * (sample::angular_momentum(card, p.from) + sample::angular_momentum(card, p.like));
    State start = p.from;
    start.angular_velocity = q0 * guess / p.duration_s;
    EXPECT_LE((sample::angular_momentum(card, start) - momentum).norm(), 1e-12 * momentum.norm());
    const PaperShooting s =
        shoot_as_paper(view_of(card), q0.conjugate() * p.to.orientation, guess, 1e-3, 1000);
    if (!s.converged) continue;
    start.angular_velocity = q0 * s.spin_rad / p.duration_s;
    EXPECT_NEAR(angle_between(end_of(card, start, p.duration_s).orientation, p.to.orientation), s.error_rad,
                1e-9);  // half the sine of so small an angle for the angle
  }
}

// Bound of a point's acceleration. No spin exceeds sqrt(2 E / least moment); |(Ij - Ik) / Ii| <= 1, so that
// |w'| <= w^2; and a point's is at most g + R (w^2 + |w'|).
double most_acceleration(const Body& body, const State& s) {
  const Vec3& moments = body.principal_inertia();
  const Vec3 w = s.orientation.conjugate() * s.angular_velocity;
  const double w2 = w.dot(moments.cwiseProduct(w)) / moments.minCoeff();
  return sample::kGravity + 2.0 * body.bounding_radius_m() * w2;
}

// Between samples, d apart, no point comes lower than the lower of both by more than acceleration d^2 / 8.
TEST(Penetration, AgreesWithDenseSampling) {
  constexpr double kTolerance_m = 1e-4;
  constexpr int kSamples = 4000;
  int below = 0, clear = 0, unsure = 0;
  for (const Body& body : bodies()) {
    const Connector connector(body);
    RandomStream random(7, 0);
    for (int k = 0; k < 60; ++k) {
      const State from = sample_touching(body, random);
      State to = sample_touching(body, random);
      const double duration_s = random.uniform(0.02, 0.2);
      State start = from;
      start.angular_velocity = 150.0 * random.uniform() * random.unit_vector();
      const State end = end_of(body, start, duration_s);
      to.orientation = end.orientation;
      to.position.z() = -sample::lowest(body, {Vec3::Zero(), to.orientation, {}, {}});  // touches
      const Connection c = connector.connect(start, start, to, duration_s, sample::downwards());
      ASSERT_TRUE(c.converged());
      const bool said = connector.penetrates(c.start, duration_s, sample::downwards(), kTolerance_m);
      Flight flight(body);
      flight.start(c.start, sample::downwards());
      double lowest = 1e300;
      for (int i = 0; i <= kSamples; ++i)
        lowest = std::min(lowest, sample::lowest(body, flight.at(duration_s * i / kSamples)));
      const double step = duration_s / kSamples;
      const double hidden = most_acceleration(body, c.start) * step * step / 8.0;
      if (lowest < -kTolerance_m - 1e-12) {  // rounding of heights
        ++below;
        EXPECT_TRUE(said) << body.name() << " " << k << " lowest " << lowest;
      } else if (lowest > -kTolerance_m + hidden + 1e-12) {
        ++clear;
        EXPECT_FALSE(said) << body.name() << " " << k << " lowest " << lowest;
      } else {
        ++unsure;
      }
    }
  }
  EXPECT_GE(below, 50);
  EXPECT_GE(clear, 50);
  EXPECT_LE(unsure, 10);  // the bound is wide for a rod that spins fast across its axis
}

TEST(Penetration, IsSeenAtOnceAndAtTheEnd) {
  const Body die = sample::box(Vec3::Constant(0.016), 0.005);
  const Connector connector(die);
  State s;
  s.position.z() = 0.008;
  const auto penetrates = [&](const State& start, double duration_s) {
    return connector.penetrates(start, duration_s, sample::downwards(), 1e-4);
  };
  s.velocity.z() = 1.0;  // up and down again takes 2 v / g = 0.2039 s
  EXPECT_FALSE(penetrates(s, 0.2038));
  EXPECT_TRUE(penetrates(s, 0.2045));  // 0.6 mm below by then
  s.velocity.z() = -1.0;
  EXPECT_TRUE(penetrates(s, 0.001));
  EXPECT_FALSE(penetrates(s, 5e-5));  // 0.05 mm
  State deep = s;                     // begins below, and ends touching from below
  deep.velocity.z() = 0.2;
  deep.position.z() -= 1.8e-3;
  EXPECT_TRUE(penetrates(deep, 0.01));
  // Level, no point moves down as a whole, but one corner does.
  State rocks = s;
  rocks.velocity.z() = 0.1;
  rocks.angular_velocity = Vec3(40.0, 0.0, 0.0);  // 0.32 m/s at the corners
  EXPECT_TRUE(penetrates(rocks, 0.01));
}

}  // namespace
}  // namespace ifa
