// What the engine simulates and the exporter samples passes, checked against the run's own events.
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "ifa/motion/motion.hpp"
#include "ifa/motion/sampling.hpp"
#include "ifa/signature/signature_of.hpp"
#include "ifa/verify/certificate.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

constexpr double kStill_s = 0.1;  // shown after coming to rest

// From the flight that leads to the start on to a while after coming to rest.
Motion whole(const Body& body, const State& start, const ifa::Run& run) {
  State reversed = start;
  reversed.velocity *= -1.0;
  reversed.angular_velocity *= -1.0;
  Flight flight(body);
  flight.start(reversed, sample::downwards());
  const double lead_s = 0.9 * std::min(flight.next_contact(0.1), 0.1);
  flight.start(start, sample::downwards());
  std::vector<Node> nodes{{-lead_s, flight.at(-lead_s), Phase::flight}};
  nodes.insert(nodes.end(), run.nodes.begin(), run.nodes.end());
  Node end = nodes.back();
  end.time_s = std::max(end.time_s, run.rest_s + 0.05) + kStill_s;
  end.phase = Phase::rest;
  nodes.push_back(end);
  return {body, sample::downwards(), nodes, run.hits, {}};
}

void expect_certificates(const Body& body, std::uint64_t seed, int throws) {
  std::vector<State> starts(static_cast<std::size_t>(throws));
  sample_states(body, {}, seed, 0, starts, 1);
  int checked = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const ifa::Run run = simulate(body, starts[i], {}, kNever);
    ASSERT_EQ(run.status, RunStatus::rest);
    if (run.hits.front().approach_speed_m_s < 0.06) continue;  // its first hit must be a mark
    const Marks heard = signature_of(run);
    const Motion motion = whole(body, starts[i], run);
    verify::Poses poses;
    poses.times_s = motion.dense_times();
    for (const State& s : motion.sample(poses.times_s)) {
      poses.positions_m.push_back(s.position);
      poses.orientations.push_back(s.orientation);
    }
    const auto c = verify::verify(poses, body, {heard.times_s, heard.durations_s, true}, {}, {});
    std::string failures;
    for (const std::string& f : c.failures) failures += "\n" + f;
    EXPECT_TRUE(c.passed) << "throw " << i << failures;
    // Within a contact step of 4 ms; and a wobble that dies slowly passes 0.01 m/s later by the engine's
    // bound on the speed of all points than by that of the fastest.
    EXPECT_NEAR(c.rest_s, run.rest_s, 5e-3 + 0.01 * run.rest_s) << i;
    ++checked;
  }
  EXPECT_GT(checked, throws / 2);
}

TEST(SimulatedMotion, CoinsThatWobblePass) {
  expect_certificates(sample::coin({0.45, 0.2, 5e-5, 5e-5}), 7, 40);
}

// The corners of a regular dodecahedron 18 mm across: of five that are nearly level, one strikes first.
TEST(SimulatedMotion, TwelveSidedDicePass) {
  const double golden = std::numbers::phi,
               unit = 0.009 / std::sqrt((5.0 + 2.0 * std::sqrt(5.0)) / 5.0) / golden;
  Body::Definition d;
  for (const double a : {-1.0, 1.0})
    for (const double b : {-1.0, 1.0}) {
      for (const double c : {-1.0, 1.0}) d.vertices_m.push_back(unit * Vec3(a, b, c));
      const Vec3 p(0.0, a / golden, b * golden);
      for (int turn = 0; turn < 3; ++turn)
        d.vertices_m.push_back(unit * Vec3(p[turn], p[(turn + 1) % 3], p[(turn + 2) % 3]));
    }
  d.mass_kg = 0.0045;
  d.inertia_kg_m2 = 0.4 * d.mass_kg * 0.0095 * 0.0095 * Mat3::Identity();  // about a ball's
  d.material = {0.5, 0.25, 5e-5, 5e-5};
  expect_certificates(Body::make(d), 7, 100);
}

}  // namespace
}  // namespace ifa
