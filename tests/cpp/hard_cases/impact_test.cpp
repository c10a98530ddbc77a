// Hard cases 9, 10, 11 and 15: single impacts.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "held.hpp"
#include "sample_bodies.hpp"
#include "strike.hpp"

namespace ifa {
namespace {

using sample::kinetic;
using sample::lowest;
using sample::strike;
using sample::touching;

// On the ground by its lowest point.
State grounded(const Body& body, const Quat& orientation) {
  State s;
  s.orientation = orientation;
  s.position.z() = -lowest(body, s);
  return s;
}

TEST(HardCase9, CubeFallingFlatOnAnEdgeOrACorner) {
  const double speed = 2.0, half = 0.01;
  const Quat flat = Quat::Identity(), edge(Eigen::AngleAxisd(0.25 * std::numbers::pi, Vec3::UnitX()));
  const Quat corner(Eigen::AngleAxisd(std::atan(std::sqrt(2.0)), Vec3(1, -1, 0).normalized()));
  Held velocity("velocity after, of the speed before", 1e-12),
      spin("spin after, of speed over half edge", 1e-12), impulse("impulse, relative", 1e-12);
  Held fallen("the same after a fall: velocity, of the speed before", 1e-12),
      fallen_spin("the same after a fall: spin", 1e-12);
  for (const double e : {0.0, 0.3, 0.5, 0.9, 1.0})
    for (const double friction : {0.0, 0.3, 1.0}) {
      const Body cube = sample::box(Vec3::Constant(2 * half), 0.01, sample::ideal(e, friction));
      const std::vector<std::pair<Quat, std::size_t>> cases{{flat, 4}, {edge, 2}, {corner, 1}};
      for (const auto& [orientation, count] : cases) {
        State s = grounded(cube, orientation);
        ASSERT_EQ(touching(cube, s, 1e-12).size(), count);
        s.velocity.z() = -speed;
        const ImpactResult hit = strike(cube, s, 1e-12);
        velocity.see((s.velocity - Vec3(0, 0, e * speed)).norm() / speed, e, friction, count);
        spin.see(s.angular_velocity.norm() * half / speed, e, friction, count);
        impulse.see((hit.impulse_n_s / (0.01 * speed * (1.0 + e)) - kUp).norm(), e, friction, count);

        State dropped = grounded(cube, orientation);
        dropped.position.z() += 0.2;
        EventSimulation simulation(cube, {});
        simulation.start(dropped, 0.0);
        ASSERT_EQ(simulation.advance(1.0), EventSimulation::Stop::impact);
        const double landing = std::sqrt(2 * sample::kGravity * 0.2);
        simulation.resolve();
        fallen.see((simulation.state().velocity - Vec3(0, 0, e * landing)).norm() / landing, e, friction,
                   count);
        fallen_spin.see(simulation.state().angular_velocity.norm() * half / landing, e, friction, count);
      }
    }
}

TEST(HardCase10, RodAtAnAngleWithoutFriction) {
  const double length = 0.3, mass = 0.05, speed = 1.7;
  Held impulse("impulse, relative", 1e-12), spin("spin after, relative", 1e-12);
  for (const double e : {0.0, 0.4, 1.0})
    for (const double angle : {1e-3, 0.05, 0.5, 1.0, 1.5, 1.57}) {
      const Body rod = sample::rod(length, 0.002, mass, sample::ideal(e, 0.0));
      State s = grounded(rod, Quat(Eigen::AngleAxisd(angle, Vec3::UnitY())));  // the +x end down
      s.velocity.z() = -speed;
      const ImpactResult hit = strike(rod, s, 1e-12);
      const double c = std::cos(angle), expected = mass * (1.0 + e) * speed / (1.0 + 3.0 * c * c);
      impulse.see((hit.impulse_n_s - expected * kUp).norm() / expected, e, angle);
      const double turn = 6.0 * expected * c / (mass * length);  // the end is thrown up: about -y
      spin.see((s.angular_velocity - Vec3(0, -turn, 0)).norm() / turn, e, angle);
    }
}

// Stands on the face whose outward normal is -z.
Body tetrahedron(double size_m, double mass_kg, const Material& material) {
  Body::Definition d;
  const Quat upright = Quat::FromTwoVectors(Vec3::Ones(), kUp);
  for (const Vec3& v : {Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)})
    d.vertices_m.push_back(upright * (size_m / std::sqrt(8.0) * v));
  d.inertia_kg_m2 = mass_kg * size_m * size_m / 20.0 * Mat3::Identity();
  d.mass_kg = mass_kg;
  d.material = material;
  return Body::make(d);
}

Body random_body(RandomStream& random, const Material& material) {
  const double mass = std::pow(10.0, random.uniform(-6.0, 3.0));
  const double size = std::pow(10.0, random.uniform(-4.0, 2.0));
  const double kind = random.uniform();
  if (kind < 0.15) return sample::ball(size, mass, material);
  if (kind < 0.4) return sample::rod(size, std::pow(10.0, random.uniform(-4.0, -0.5)) * size, mass, material);
  if (kind < 0.5) return tetrahedron(size, mass, material);
  const double thickness = std::pow(10.0, random.uniform(-4.0, 0.0));
  return sample::box(size * Vec3(thickness, random.uniform(0.1, 1.0), 1.0), mass, material);
}

// On one point, or on an edge or a face but for a little tilt, where several points count as touching.
State random_impact(const Body& body, RandomStream& random, double* within_m) {
  Quat orientation = random.rotation();
  const double kind = random.uniform();
  if (kind < 0.6) {
    static const double kQuarter = 0.25 * std::numbers::pi;
    const int side = static_cast<int>(random.uniform(0.0, 6.0));  // of a box; a tetrahedron's base by 0
    const Quat face(Eigen::AngleAxisd(2 * kQuarter * (side % 4), side < 4 ? Vec3::UnitX() : Vec3::UnitY()));
    const Quat edge(Eigen::AngleAxisd(kind < 0.3 ? random.uniform(0.1, 1.4) : 0.0, Vec3::UnitX()));
    orientation = Quat(Eigen::AngleAxisd(random.uniform(0.0, 6.0), kUp)) * edge * face *
                  rotation_exp(1e-6 * random.unit_vector());
  }
  *within_m = kind < 0.6 ? 4e-6 * body.bounding_radius_m() : 1e-12 * body.bounding_radius_m();
  State s = grounded(body, orientation);
  s.velocity = random.uniform(0.0, 3.0) * random.unit_vector() - Vec3(0, 0, 3.0);
  s.angular_velocity =
      std::pow(10.0, random.uniform(-2.0, 1.5)) / body.bounding_radius_m() * random.unit_vector();
  return s;
}

constexpr int kShards = 8;
class HardCase11 : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Shard, HardCase11, ::testing::Range(0, kShards));

TEST_P(HardCase11, EnergyNeverGrows) {
  RandomStream random(401, static_cast<std::uint64_t>(GetParam()));
  Held gain("energy gained, relative", 1e-12), cone("tangential impulse beyond the cone, relative", 1e-9);
  const int impacts = trials(1000000 / kShards, 1.0);
  std::vector<int> by_count(5);
  for (int i = 0; i < impacts;) {
    const Body body = random_body(random, sample::ideal(random.uniform(), random.uniform(0.0, 2.0)));
    for (int k = 0; k < 10; ++k, ++i) {
      double within_m;
      State s = random_impact(body, random, &within_m);
      const double before = kinetic(body, s);
      const std::size_t count = touching(body, s, within_m).size();
      ++by_count[std::min<std::size_t>(count, 4)];
      const ImpactResult hit = strike(body, s, within_m);
      ASSERT_TRUE(s.velocity.allFinite() && s.angular_velocity.allFinite() && hit.impulse_n_s.allFinite())
          << i;
      gain.see(std::max(0.0, kinetic(body, s) / before - 1.0), i, count);
      EXPECT_GE(hit.impulse_n_s.z(), 0.0);
      const double across = hit.impulse_n_s.head<2>().norm(),
                   limit = body.material().friction * hit.impulse_n_s.z();
      cone.see(hit.impulse_n_s.z() > 0.0 ? std::max(0.0, across / limit - 1.0) : across, i, count);
    }
  }
  for (std::size_t count = 1; count <= 4 && impacts > 10000; ++count)
    EXPECT_GT(by_count[count], impacts / 200) << count << " points";
}

// With e = 1 and mu = 0 every approaching point leaves as fast as it came, so the impulses do no work,
// however many points there are; where a point that was leaving would be pushed, the energy guard ends
// exactly at the energy before.
TEST_P(HardCase11, ElasticWithoutFrictionKeepsTheEnergy) {
  RandomStream random(402, static_cast<std::uint64_t>(GetParam()));
  Held one("one point: energy, relative", 1e-12), several("several points: energy, relative", 1e-12);
  const int impacts = trials(1000000 / kShards, 1.0);
  for (int i = 0; i < impacts;) {
    const Body body = random_body(random, sample::ideal(1.0, 0.0));
    for (int k = 0; k < 10; ++k, ++i) {
      double within_m;
      State s = random_impact(body, random, &within_m);
      const double before = kinetic(body, s);
      const std::size_t count = touching(body, s, within_m).size();
      strike(body, s, within_m);
      (count == 1 ? one : several).see(std::abs(kinetic(body, s) / before - 1.0), i, count);
    }
  }
}

// A sliding rod may jam where mu > 4/3. Any answer must be finite, leave the ground and not gain energy.
TEST(HardCase15, PainleveRodJams) {
  Held gain("energy gained, relative", 1e-12), sinks("normal speed into the ground after, m/s", 1e-9),
      cone("tangential impulse beyond the cone, relative", 1e-9);
  const double length = 1.0, mass = 1.0;
  int jammed = 0;
  for (const double friction : {1.34, 1.4, 2.0, 5.0, 100.0})
    for (const double e : {0.0, 0.5, 1.0})
      for (int i = 1; i < 120; ++i)
        for (const double slip : {-3.0, 3.0})
          for (const double sink : {-1e-9, -0.01, -1.0}) {
            const Body rod = sample::rod(length, 0.001, mass, sample::ideal(e, friction));
            const double angle = i * std::numbers::pi / 240.0;
            State s = grounded(rod, Quat(Eigen::AngleAxisd(angle, Vec3::UnitY())));
            s.velocity = {slip, 0.0, sink};
            // Slipping to its low end, more impulse presses it further down: 1 + 3 cos^2 < 3 mu sin cos.
            const double c = std::cos(angle), sine = std::sin(angle);
            jammed += slip > 0.0 && 1.0 + 3.0 * c * c < 3.0 * friction * sine * c;
            const double before = kinetic(rod, s);
            const ImpactResult hit = strike(rod, s, 1e-12);
            ASSERT_TRUE(s.velocity.allFinite() && s.angular_velocity.allFinite() &&
                        hit.impulse_n_s.allFinite());
            gain.see(std::max(0.0, kinetic(rod, s) / before - 1.0), friction, e, angle, slip, sink);
            const Vec3 arm = touching(rod, s, 1e-12)[0].arm;
            sinks.see(std::max(0.0, -(s.velocity + s.angular_velocity.cross(arm)).z()), friction, e, angle,
                      slip, sink);
            cone.see(std::max(0.0, hit.impulse_n_s.head<2>().norm() / (friction * hit.impulse_n_s.z()) - 1.0),
                     friction, e, angle, slip, sink);
          }
  EXPECT_GT(jammed, 100);
}

}  // namespace
}  // namespace ifa
