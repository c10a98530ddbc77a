// Hard cases 8 and 25: bounces without end.
#include <cmath>
#include <numbers>

#include "held.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::kGravity;

TEST(HardCase8, BouncesAtZenosTimesAndComesToRest) {
  Held time("impact times, s", 1e-9), speed("approach speeds, m/s", 1e-9),
      rest("rest after the limit, s", 1e-3), early("rest before the last possible bounce, s", 1e-9);
  const double radius = 0.02;
  for (const double height : {0.01, 0.5, 3.0})
    for (const double e : {0.0, 0.1, 0.3, 0.6, 0.9, 0.98}) {
      const Body ball = sample::ball(radius, 0.03, {e, 0.3, 5e-5, 5e-5});
      State s;
      s.position.z() = radius + height;
      const SimulationOptions options;
      const auto run = simulate(ball, s, options, kNever);
      ASSERT_EQ(run.status, RunStatus::rest);
      const double fall = std::sqrt(2.0 * height / kGravity);
      double sum = 0.0, power = 1.0;
      for (const Hit& hit : run.hits) {
        time.see(std::abs(hit.time_s - fall * (1.0 + 2.0 * sum)), e, height);
        speed.see(std::abs(hit.approach_speed_m_s - kGravity * fall * power), e, height);
        power *= e;
        sum += power;
      }
      // It bounces for as long as it approaches faster than the micro speed; the next impact is its last.
      ASSERT_FALSE(run.hits.empty());
      for (const Hit& hit : run.hits)
        EXPECT_EQ(hit.approach_speed_m_s > options.micro_speed_m_s,
                  e > 0.0 ? &hit != &run.hits.back() : true);
      const double limit = fall * (1.0 + e) / (1.0 - e);
      const double left = 2.0 * e * options.micro_speed_m_s / (kGravity * (1.0 - e));
      rest.see(std::max(0.0, run.rest_s - limit), e, height);  // a step is the clock's resolution there
      early.see(std::max(0.0, limit - left - run.rest_s), e, height);
      EXPECT_EQ(run.nodes.back().state.velocity, Vec3(0, 0, 0));
    }
}

// Elastic without friction: as fast as ever after 100,000 bounces, and then it stops at the limit. Each
// bounce rounds the height and the speed once: 1e-16 of 3 m/s, 1e5 times, if all err to one side.
TEST(HardCase25, ElasticBallStopsAtTheImpactLimit) {
  const Body ball = sample::ball(0.02, 0.03, sample::ideal(1.0, 0.0));
  State s;
  s.position.z() = 0.52;
  const auto run = simulate(ball, s, {}, kNever);
  EXPECT_EQ(run.status, RunStatus::impact_limit);
  EXPECT_EQ(run.hits.size(), 100000u);
  Held speed("approach speed, m/s", 1e-10), time("time of the last bounce, relative", 1e-10);
  const double fall = std::sqrt(2.0 * 0.5 / kGravity);
  for (const Hit& hit : run.hits) speed.see(std::abs(hit.approach_speed_m_s - kGravity * fall));
  time.see(std::abs(run.hits.back().time_s / (fall * (2.0 * 99999.0 + 1.0)) - 1.0));
}

// Tumbling bodies too, whose points chatter. Energy is kept, each impact within its 1e-12.
TEST(HardCase25, ElasticBodiesStopAtTheImpactLimit) {
  Held gain("energy after 1e5 impacts, relative", 1e-7);
  RandomStream random(301, 0);
  SimulationOptions options;
  options.micro_speed_m_s = 0.0;
  for (const Vec3& size : {Vec3(0.016, 0.016, 0.016), Vec3(0.05, 0.02, 0.012), Vec3(0.085, 0.054, 8e-4)}) {
    const Body body = sample::box(size, 0.005, sample::ideal(1.0, 0.0));
    const State s = sample::random_state(body, random, 0.05, 1.0, 10.0);
    EventSimulation simulation(body, options);
    simulation.start(s, 0.0);
    int hits = 0;
    while (hits < options.max_impacts && simulation.advance(1e4) == EventSimulation::Stop::impact) {
      simulation.resolve();
      ++hits;
      ASSERT_FALSE(simulation.in_contact()) << hits;
    }
    EXPECT_EQ(hits, options.max_impacts);
    gain.see(std::abs(sample::mechanical(body, simulation.state()) / sample::mechanical(body, s) - 1.0),
             size.transpose());
  }
}

// A regular polygon of 24 corners that rolls in its own plane, each corner rounded by a billionth.
struct Wheel {
  static constexpr int kCorners = 24;
  double length_m, mass_kg = 0.02, moment_kg_m2;
  Body body;

  explicit Wheel(double length)
      : length_m(length),
        moment_kg_m2(0.5 * mass_kg * length * length),
        body(make(length, moment_kg_m2, mass_kg)) {}

  static Body make(double length, double moment, double mass) {
    Body::Definition d;
    for (int i = 0; i < kCorners; ++i) {
      const double angle = 2.0 * std::numbers::pi * (i + 0.5) / kCorners;
      d.vertices_m.push_back(length * Vec3(std::cos(angle), 0.0, std::sin(angle)));
    }
    d.radius_m = 1e-9 * length;
    d.mass_kg = mass;
    d.inertia_kg_m2 = moment * Vec3(0.5, 1.0, 0.5).asDiagonal();
    d.material = sample::ideal(0.0, 0.8);
    return Body::make(d);
  }
};

// Without restitution a polygon that rolls down a slope clatters from corner to corner without end, at a
// speed that is known (the rimless wheel, McGeer 1990, "Passive dynamic walking"): each landing keeps the
// angular momentum about the new corner, w+ = c w-, c = (I + m l^2 cos(2 a)) / (I + m l^2) with a = pi / 24,
// and each step falls by 2 l sin(a) sin(slope).
TEST(HardCase25, PlasticWheelClattersToTheImpactLimitAtMcGeersSpeed) {
  Held speed("spin after an impact, relative", 1e-3), gain("energy gained by an impact, relative", 1e-12);
  const Wheel wheel(0.002);
  const double slope = 0.1, a = std::numbers::pi / Wheel::kCorners, l = wheel.length_m, m = wheel.mass_kg;
  const double about_corner = wheel.moment_kg_m2 + m * l * l;
  const double kept = (wheel.moment_kg_m2 + m * l * l * std::cos(2.0 * a)) / about_corner;
  const double fall = 2.0 * m * kGravity * 2.0 * l * std::sin(a) * std::sin(slope) / about_corner;
  const double steady = std::sqrt(kept * kept * fall / (1.0 - kept * kept));
  SimulationOptions options;
  options.step_s = 2e-4;
  options.gravity_m_s2 = kGravity * Vec3(std::sin(slope), 0.0, -std::cos(slope));
  State s;
  s.position.z() = -sample::lowest(wheel.body, s);
  s.angular_velocity.y() = steady;
  s.velocity.x() = steady * s.position.z();
  EventSimulation simulation(wheel.body, options);
  simulation.start(s, 0.0);
  const int limit = options.max_impacts;
  int hits = 0;
  while (hits < limit && simulation.advance(kNever) == EventSimulation::Stop::impact) {
    const double before = sample::kinetic(wheel.body, simulation.state());
    simulation.resolve();
    gain.see(std::max(0.0, sample::kinetic(wheel.body, simulation.state()) / before - 1.0), hits);
    ++hits;
    if (hits > 200) speed.see(std::abs(simulation.state().angular_velocity.y() / steady - 1.0), hits);
  }
  EXPECT_EQ(hits, limit);
}

// On level ground it rocks itself to rest, however small the speeds that count as impacts.
TEST(HardCase25, PlasticWheelComesToRestOnLevelGround) {
  const Wheel wheel(0.02);
  for (const double micro_speed : {0.0, 1e-4, 0.01}) {
    SimulationOptions options;
    options.micro_speed_m_s = micro_speed;
    State s;
    s.position.z() = -sample::lowest(wheel.body, s);
    s.velocity.x() = 0.3;
    s.angular_velocity.y() = 15.0;
    const auto run = simulate(wheel.body, s, options, 100.0);
    EXPECT_EQ(run.status, RunStatus::rest) << micro_speed;
    EXPECT_LT(run.hits.size(), 1000u) << micro_speed;
  }
}

// Thrown bodies end too: at rest, at the limit of impacts, or exactly at that of time.
TEST(HardCase25, ThrownBodiesEnd) {
  RandomStream random(303, 0);
  SimulationOptions options;
  options.max_impacts = 2000;
  for (const double e : {0.0, 0.99, 1.0}) {
    const Material material = sample::ideal(e, 0.1);
    for (const Body& body : {sample::box({0.016, 0.016, 0.016}, 0.005, material),
                             sample::box({0.085, 0.054, 8e-4}, 0.005, material),
                             sample::ball(0.02, 0.03, material), sample::rod(0.15, 0.004, 0.02, material)}) {
      const auto run = simulate(body, sample::random_state(body, random, 0.05, 1.0, 10.0), options, 20.0);
      EXPECT_TRUE(run.nodes.back().state.position.allFinite());
      EXPECT_LE(run.hits.size(), 2000u);
      EXPECT_EQ(run.hits.size() == 2000u, run.status == RunStatus::impact_limit);
      EXPECT_TRUE(run.status != RunStatus::time_limit || run.nodes.back().time_s == 20.0);
    }
  }
}

}  // namespace
}  // namespace ifa
