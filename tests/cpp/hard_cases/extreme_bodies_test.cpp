// Hard cases 18 and 19: thin plates, and bodies at the limits of what a body may be.
#include <algorithm>
#include <cmath>
#include <string>

#include "held.hpp"
#include "ifa/base/error.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::lowest;

constexpr int kShards = 16;
class HardCase18 : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Shard, HardCase18, ::testing::Range(0, kShards));

// Plates of 0.01 to 1 mm that arrive at 40 m/s, spinning. Neither at any node nor between two of a flight is
// a point further below the ground than rounding and the projection of held points (1e-8 of the size)
// explain.
TEST_P(HardCase18, ThinPlatesDoNotFallThrough) {
  RandomStream random(501, static_cast<std::uint64_t>(GetParam()));
  Held depth("deepest point, of the size", 1e-8);
  const int plates = trials(1000000 / kShards, 1.0);
  for (int i = 0; i < plates;) {
    const double thickness = std::pow(10.0, random.uniform(-5.0, -3.0));
    const Body plate = sample::box({random.uniform(0.02, 0.2), random.uniform(0.02, 0.2), thickness}, 0.01,
                                   {random.uniform(), random.uniform(), 5e-5, 5e-5});
    Flight flight(plate);
    for (int k = 0; k < 10; ++k, ++i) {
      State s = sample::random_state(plate, random, 0.05, 0.0, 200.0);
      s.velocity = 40.0 * (random.unit_vector() - Vec3(0, 0, 2)).normalized();
      SimulationOptions options;
      options.max_impacts = 200;
      const auto run = simulate(plate, s, options, 0.01);
      ASSERT_GT(run.hits.size(), 0u) << i;
      for (std::size_t n = 0; n < run.nodes.size(); ++n) {
        const Node& node = run.nodes[n];
        depth.see(-lowest(plate, node.state) / plate.bounding_radius_m(), i, n, node.time_s, thickness);
        if (node.phase != Phase::flight || n + 1 == run.nodes.size()) continue;
        flight.start(node.state, options.gravity_m_s2);
        const State between = flight.at(0.5 * (run.nodes[n + 1].time_s - node.time_s));
        depth.see(-lowest(plate, between) / plate.bounding_radius_m(), i, n, node.time_s, thickness);
      }
    }
  }
}

bool finite(const State& s) {
  return s.position.allFinite() && s.orientation.coeffs().allFinite() && s.velocity.allFinite() &&
         s.angular_velocity.allFinite();
}

bool finite(const Run& run) {
  return std::all_of(run.nodes.begin(), run.nodes.end(), [](const Node& n) { return finite(n.state); }) &&
         std::all_of(run.hits.begin(), run.hits.end(), [](const Hit& h) {
           return std::isfinite(h.time_s) && h.impulse_n_s.allFinite() &&
                  std::isfinite(h.approach_speed_m_s) && h.position_m.allFinite();
         });
}

// In the axes of the moments: of a needle, world axes would lose the least one in rounding.
double energy(const Body& body, const State& s) {
  const Vec3 spin = s.orientation.conjugate() * s.angular_velocity;
  return 0.5 * body.principal_inertia().dot(spin.cwiseAbs2()) +
         body.mass_kg() * (0.5 * s.velocity.squaredNorm() + sample::kGravity * s.position.z());
}

// A zero moment is refused by name, any other ratio simulated.
TEST(HardCase19, InertiaRatiosFromOneToZero) {
  RandomStream random(502, 0);
  Held gain("energy gained to the end, relative", 1e-6);
  for (int exponent = 0; exponent <= 12; ++exponent)
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < 5; ++i) {
        Body::Definition d = sample::box({0.02, 0.03, 0.04}, 0.01).definition();
        Vec3 moments = Vec3::Constant(1e-6);
        moments[axis] *= std::pow(10.0, -exponent);
        d.inertia_kg_m2 = moments.asDiagonal();
        const Body body = Body::make(d);
        const State s = sample::random_state(body, random, 0.05, 1.0, 50.0);
        SimulationOptions options;
        options.max_impacts = 100;
        const auto run = simulate(body, s, options, 0.3);
        ASSERT_TRUE(finite(run)) << exponent << " " << axis << " " << i;
        const double before = energy(body, s);
        gain.see(std::max(0.0, energy(body, run.nodes.back().state) / before - 1.0), exponent, axis, i);
      }
  for (const Vec3& moments :
       {Vec3(0, 1, 1), Vec3(1, 0, 1), Vec3(0, 0, 1), Vec3(0, 0, 0), Vec3(1e-24, 1, 1)}) {
    Body::Definition d = sample::box({0.02, 0.03, 0.04}, 0.01).definition();
    d.inertia_kg_m2 = 1e-6 * Mat3(moments.asDiagonal());
    try {
      Body::make(d);
      ADD_FAILURE() << moments.transpose() << " was accepted";
    } catch (const ArgumentError& e) {
      EXPECT_EQ(std::string(e.what()).rfind("inertia_kg_m2:", 0), 0u) << e.what();
    }
  }
}

// 0.1 mm to 100 m, 1 mg to 1 t, 4 to 3,000 points, thin, long or round, with any moments that a body can have
// to a ratio of 1e12, about any axes.
Body::Definition random_definition(RandomStream& random) {
  Body::Definition d;
  const double size = std::pow(10.0, random.uniform(-4.0, 2.0));
  const Vec3 shape(1.0, std::pow(10.0, random.uniform(-3.0, 0.0)), std::pow(10.0, random.uniform(-5.0, 0.0)));
  const int points = static_cast<int>(4.0 * std::pow(751.0, random.uniform()));
  const bool on_surface = random.uniform() < 0.5;
  for (int i = 0; i < points; ++i) {
    const Vec3 p = random.unit_vector();
    d.vertices_m.push_back(size * shape.cwiseProduct(on_surface ? p : p * random.uniform()));
  }
  if (random.uniform() < 0.3) d.radius_m = size * std::pow(10.0, random.uniform(-6.0, 0.0));
  d.centre_of_mass_m = 0.3 * size * random.uniform() * shape.cwiseProduct(random.unit_vector());
  d.mass_kg = std::pow(10.0, random.uniform(-6.0, 3.0));
  const double small = std::pow(10.0, random.uniform(-12.0, 0.0));
  const Vec3 moments(small, 1.0 - small * random.uniform(), 1.0);
  const Quat axes = random.uniform() < 0.5 ? Quat::Identity() : random.rotation();
  const Mat3 turn = axes.toRotationMatrix();
  d.inertia_kg_m2 = 0.1 * d.mass_kg * size * size * turn * moments.asDiagonal() * turn.transpose();
  d.material = {random.uniform(), random.uniform(0.0, 2.0), size * 1e-3 * random.uniform(),
                size * 1e-3 * random.uniform()};
  return d;
}

class HardCase19Random : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Shard, HardCase19Random, ::testing::Range(0, kShards));

// Thrown from half its size, for as long as it takes to fall three times as far. Refused bodies must name a
// field.
TEST_P(HardCase19Random, RandomBodiesNeitherAbortNorLoseTheirNumbers) {
  RandomStream random(503, static_cast<std::uint64_t>(GetParam()));
  const int bodies = trials(1000000 / kShards, 0.0005);
  int refused = 0;
  for (int i = 0; i < bodies; ++i) {
    try {
      const Body body = Body::make(random_definition(random));
      const double size = body.bounding_radius_m(), fall = std::sqrt(size / sample::kGravity);
      State s = sample::random_state(body, random, 0.5 * size, size / fall, 0.0);
      s.angular_velocity = std::pow(10.0, random.uniform(-1.0, 1.5)) / fall * random.unit_vector();
      SimulationOptions options;
      options.max_impacts = 50;
      options.step_s = std::max(1e-3, 0.02 * fall);
      const auto run = simulate(body, s, options, 3.0 * fall);
      ASSERT_TRUE(finite(run)) << i;
      ASSERT_GT(lowest(body, run.nodes.back().state), -1e-6 * size) << i;
    } catch (const ArgumentError& e) {
      ++refused;
      const std::string what = e.what();
      EXPECT_TRUE(what.rfind("inertia_kg_m2:", 0) == 0 || what.rfind("vertices_m:", 0) == 0)
          << i << ": " << what;
    }
  }
  EXPECT_LT(refused, bodies / 20 + 2);
}

}  // namespace
}  // namespace ifa
