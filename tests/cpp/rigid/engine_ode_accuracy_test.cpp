// The engine on ODE against closed forms and against the event engine: exact contact instants where flight is
// skipped, errors of the first order in the step elsewhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "ifa/base/error.hpp"
#include "ifa/rigid/engine_ode.hpp"
#include "paper_start.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::kGravity;

OdeOptions options_of(double step_s, bool skip_flight) {
  OdeOptions options;
  options.step_s = step_s;
  options.skip_flight = skip_flight;
  return options;
}

// Hard case 8, with the flight skipped: softness alone, 1e-6 of each bounce and the sum of these in time,
// keeps it from the exact values.
TEST(EngineOdeAccuracy, BouncingBallHasZenosTimes) {
  const double height = 0.5, radius = 0.02, restitution = 0.6;
  const Body ball = sample::ball(radius, 0.03, {restitution, 0.3, 5e-5, 5e-5});
  State s;
  s.position.z() = radius + height;
  const auto run = simulate_ode(ball, s, {}, kNever);
  ASSERT_EQ(run.status, RunStatus::rest);
  const double fall = std::sqrt(2.0 * height / kGravity);
  double sum = 0.0, power = 1.0;
  for (const Hit& hit : run.hits) {
    const double speed = kGravity * fall * power;
    EXPECT_NEAR(hit.time_s, fall * (1.0 + 2.0 * sum), 1e-5);
    EXPECT_NEAR(hit.approach_speed_m_s, speed, 1e-4 * speed);
    EXPECT_NEAR(hit.impulse_n_s.z(), 0.03 * (1.0 + restitution) * speed, 1e-4 * speed);
    EXPECT_LT(hit.position_m.norm(), 1e-12);
    power *= restitution;
    sum += power;
  }
  // down to the micro speed
  EXPECT_GE(run.hits.size(),
            static_cast<std::size_t>(std::log(0.01 / (kGravity * fall)) / std::log(restitution)));
  EXPECT_EQ(run.nodes.back().phase, Phase::rest);
  EXPECT_EQ(run.nodes.back().state.velocity, Vec3(0, 0, 0));
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// Against the event engine, without friction: a true cone and ODE's box differ by more than the step does.
struct ContactErrors {
  std::vector<double> first_s, second_s, third_s;
};
ContactErrors contact_errors(double step_s, bool skip_flight) {
  const Body body = sample::box({0.016, 0.016, 0.016}, 0.0049, sample::ideal(0.5, 0.0));
  OdeOptions options = options_of(step_s, skip_flight);
  SimulationOptions exact_options;
  options.max_impacts = exact_options.max_impacts = 3;
  ContactErrors errors;
  for (int i = 0; i < 200; ++i) {
    State s = sample::paper_start(body, i);
    s.position.z() += 0.05;
    const auto ode = simulate_ode(body, s, options, 5.0), exact = simulate(body, s, exact_options, 5.0);
    if (ode.hits.size() < 3 || exact.hits.size() < 3) continue;
    errors.first_s.push_back(ode.hits[0].time_s - exact.hits[0].time_s);
    errors.second_s.push_back(std::abs(ode.hits[1].time_s - exact.hits[1].time_s));
    errors.third_s.push_back(std::abs(ode.hits[2].time_s - exact.hits[2].time_s));
  }
  EXPECT_GT(errors.first_s.size(), 190u);
  return errors;
}

TEST(EngineOdeAccuracy, ContactTimesAreExactWhereFlightIsSkipped) {
  const ContactErrors errors = contact_errors(1e-3, true);
  for (const double error_s : errors.first_s) EXPECT_NEAR(error_s, 0.0, 1e-12);  // a root of the same flight
  // Softness, 1e-6 of each impact, grows from impact to impact; medians of 5e-10 and 3e-7 were measured.
  EXPECT_LT(median(errors.second_s), 1e-8);
  EXPECT_LT(median(errors.third_s), 3e-6);
}

TEST(EngineOdeAccuracy, SteppedContactTimesAreOfTheFirstOrder) {
  std::vector<double> second_s;
  for (const double step_s : {5e-4, 2.5e-4, 1.25e-4, 6.25e-5}) {
    const ContactErrors errors = contact_errors(step_s, false);
    // Found at the end of the step in which it happens. Euler's fall is g t h / 2 lower, which comes down
    // earlier by half a step times g t / v, at most 1; the margin and rotation make up the rest.
    for (const double error_s : errors.first_s) {
      EXPECT_GT(error_s, -0.6 * step_s);
      EXPECT_LT(error_s, 1.1 * step_s);
    }
    second_s.push_back(median(errors.second_s));
  }
  EXPECT_LT(second_s[0], 1e-3);
  // Eight times smaller steps: eightfold, within what medians of 200 scatter (10 was measured).
  EXPECT_GT(second_s[0] / second_s[3], 5.0);
  EXPECT_LT(second_s[0] / second_s[3], 16.0);
}

// Hard case 13: slip ends at 5/7 of the speed, whatever friction and step.
TEST(EngineOdeAccuracy, SlidingBallBeginsToRollAtFiveSevenths) {
  const double radius = 0.05, friction = 0.2, speed = 3.0;
  const Body ball = sample::ball(radius, 0.3, sample::ideal(0.0, friction));
  State s;
  s.position.z() = radius;
  s.velocity = {0.6 * speed, 0.8 * speed, 0.0};
  const double rolling_s = 2.0 * speed / (7.0 * friction * kGravity);
  const auto run = simulate_ode(ball, s, {}, 2.0 * rolling_s);
  // The angular momentum about the ground is kept but for the softness.
  EXPECT_NEAR(run.nodes.back().state.velocity.norm(), 5.0 / 7.0 * speed, 1e-5 * speed);
  double began_s = 0.0;
  for (const Node& n : run.nodes)
    if ((n.state.velocity + n.state.angular_velocity.cross(Vec3(0, 0, -radius))).norm() > 1e-5 * speed)
      began_s = n.time_s;
  EXPECT_NEAR(began_s, rolling_s, 1e-3 + 1e-9);  // one step
}

// Rolling resistance with lever b: b m g stops the momentum 7/5 m r v about the ground, at 5/7 g b / r.
TEST(EngineOdeAccuracy, RollingFrictionStopsABall) {
  const double radius = 0.02, lever = 1e-4, speed = 0.5;
  const Body ball = sample::ball(radius, 0.03, {0.5, 0.5, lever, lever});
  State s;
  s.position.z() = radius;
  s.velocity.x() = speed;
  s.angular_velocity.y() = speed / radius;
  const auto run = simulate_ode(ball, s, {}, 100.0);
  ASSERT_EQ(run.status, RunStatus::rest);
  const double deceleration = 5.0 / 7.0 * kGravity * lever / radius;
  // rest begins at 0.01 m/s, of v and omega r together
  const double expected_s = (speed - 0.005) / deceleration;
  EXPECT_NEAR(run.rest_s, expected_s, 0.01 * expected_s);
  EXPECT_NEAR(run.nodes.back().state.position.x(), 0.5 * speed * speed / deceleration,
              0.01 * 0.5 * speed * speed / deceleration);
}

TEST(EngineOdeAccuracy, NodesHoldBothSidesOfEachHit) {
  const Body body = sample::box({0.01, 0.02, 0.03}, 0.015);
  int whole = 0;
  for (const bool skip : {true, false})
    for (int i = 0; i < 20; ++i) {
      State s = sample::paper_start(body, i);
      s.position.z() += 0.01;
      const auto run = simulate_ode(body, s, options_of(1e-3, skip), 0.3);
      EXPECT_EQ(run.nodes.front().time_s, 0.0);
      EXPECT_EQ(run.nodes.front().state.position, s.position);
      if (run.status == RunStatus::time_limit) {
        EXPECT_EQ(run.nodes.back().time_s, 0.3);
        ++whole;
      }
      std::size_t k = 0;
      for (std::size_t n = 1; n < run.nodes.size(); ++n) {
        EXPECT_GE(run.nodes[n].time_s, run.nodes[n - 1].time_s);
        if (run.nodes[n].time_s != run.nodes[n - 1].time_s) continue;
        ASSERT_LT(k, run.hits.size());
        const Hit& hit = run.hits[k++];
        const State &before = run.nodes[n - 1].state, &after = run.nodes[n].state;
        EXPECT_EQ(hit.time_s, run.nodes[n].time_s);
        EXPECT_EQ(after.position, before.position);
        EXPECT_LT((body.mass_kg() * (after.velocity - before.velocity) - hit.impulse_n_s).norm(), 1e-15);
        EXPECT_GT(hit.approach_speed_m_s, 0.01);
      }
      EXPECT_EQ(k, run.hits.size());
    }
  EXPECT_GT(whole, 20);
}

TEST(EngineOdeAccuracy, StopsAtItsLimits) {
  const Body ball = sample::ball(0.02, 0.03, sample::ideal(1.0, 0.0));
  State s;
  s.position.z() = 0.1;
  OdeOptions options;
  options.max_impacts = 7;
  const auto bounced = simulate_ode(ball, s, options, kNever);
  EXPECT_EQ(bounced.status, RunStatus::impact_limit);
  EXPECT_EQ(bounced.hits.size(), 7u);
  const auto none = simulate_ode(ball, s, {}, 0.0);
  EXPECT_EQ(none.status, RunStatus::time_limit);
  EXPECT_EQ(none.nodes.size(), 1u);
  Progress progress;
  progress.cancel();
  EXPECT_THROW(simulate_ode(ball, s, {}, 1.0, &progress), Cancelled);
}

}  // namespace
}  // namespace ifa
