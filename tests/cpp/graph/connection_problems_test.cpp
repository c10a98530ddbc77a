// Drawn connections, and what a looser tolerance buys of them.
#include "ifa/graph/connection_problems.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ifa/graph/connection.hpp"
#include "ifa/graph/weights.hpp"
#include "ifa/rigid/flight.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::angle_between;

std::vector<ConnectionProblem> drawn(const Body& body, std::uint64_t seed = 3) {
  return draw_connection_problems(body, seed, 60, 50, sample::downwards());
}

State end_of(const Body& body, const State& start, double duration_s) {
  Flight flight(body);
  flight.start(start, sample::downwards());
  return flight.at(duration_s);
}

TEST(ConnectionProblems, TheOtherFlightLeadsToTheTarget) {
  const Body box = sample::box({0.05, 0.02, 0.03}, 0.02);
  const auto problems = drawn(box);
  ASSERT_EQ(problems.size(), 50u);
  for (const ConnectionProblem& p : problems) {
    EXPECT_GT(p.flight_s, 0.0);
    const State end = end_of(box, p.like, p.duration_s);
    EXPECT_EQ(end.position, p.to.position);
    EXPECT_EQ(end.orientation.coeffs(), p.to.orientation.coeffs());
    EXPECT_GE(log_orientation_factor(angle_between(p.from.orientation, p.like.orientation), p.duration_s),
              -10.0 - 1e-9);  // the paper's cut-off; rounding
  }
}

TEST(ConnectionProblems, AreThoseOfTheirSeed) {
  const Body box = sample::box({0.05, 0.02, 0.03}, 0.02);
  const auto one = drawn(box), again = drawn(box), other = drawn(box, 4);
  EXPECT_EQ(one[7].to.orientation.coeffs(), again[7].to.orientation.coeffs());
  EXPECT_NE(one[7].to.orientation.coeffs(), other[7].to.orientation.coeffs());
}

TEST(ConnectionProblems, ABodyThatNeverFliesHasNone) {
  // Without restitution nothing leaves the ground but what a tilted body's other corners throw up.
  const Body ball = sample::ball(0.02, 0.03, {0.0, 0.3, 1e-3, 1e-3});
  EXPECT_THROW(drawn(ball), ArgumentError);
}

TEST(ConnectionProblems, ALooserToleranceIsKeptToAndTakesFewerIterations) {
  for (const Body& body : {sample::box({0.08, 0.05, 0.001}, 0.005), sample::box({0.05, 0.02, 0.03}, 0.02)}) {
    const Connector connector(body);
    const auto problems = drawn(body);
    int last = 0;
    std::size_t converged_last = 0;
    for (const double tolerance_rad : {1e-1, 1e-3, 1e-6, kShootingTolerance_rad}) {
      int iterations = 0;
      std::size_t converged = 0;
      double missed = 0.0;
      for (const ConnectionProblem& p : problems) {
        const Connection c =
            connector.connect(p.from, p.like, p.to, p.duration_s, sample::downwards(), tolerance_rad);
        iterations += c.shooting.iterations;
        if (!c.converged()) continue;
        ++converged;
        missed = std::max(missed,
                          angle_between(end_of(body, c.start, p.duration_s).orientation, p.to.orientation));
      }
      EXPECT_LE(missed, tolerance_rad + 1e-10);  // the rounding of two flights, as in connection_test
      EXPECT_GT(iterations, last);
      EXPECT_GE(converged, 40u);
      if (converged_last > 0) {
        EXPECT_LE(converged, converged_last);  // what misses a loose one misses a tight one
      }
      last = iterations;
      converged_last = converged;
    }
  }
}

}  // namespace
}  // namespace ifa
