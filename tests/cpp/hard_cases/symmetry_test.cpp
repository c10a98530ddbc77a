// Hard cases 20 and 21: what no change of scale and no yaw may change.
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "held.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

// Froude's scaling, exact in binary: lengths x 4^k, times and speeds x 2^k, masses x 2^j, the same gravity.
struct Scale {
  int k, j;

  double length() const { return std::ldexp(1.0, 2 * k); }
  double time() const { return std::ldexp(1.0, k); }
  double mass() const { return std::ldexp(1.0, j); }
  double impulse() const { return mass() * time(); }

  Body of(const Body& body) const {
    Body::Definition d = body.definition();
    for (Vec3& v : d.vertices_m) v *= length();
    d.centre_of_mass_m *= length();
    d.radius_m *= length();
    d.mass_kg *= mass();
    d.inertia_kg_m2 *= mass() * length() * length();
    d.material.rolling_friction_m *= length();
    d.material.spin_friction_m *= length();
    return Body::make(d);
  }

  State of(State s) const {
    s.position *= length();
    s.velocity *= time();
    s.angular_velocity /= time();
    return s;
  }

  SimulationOptions of(SimulationOptions o) const {
    o.step_s *= time();
    o.rest_duration_s *= time();
    o.micro_speed_m_s *= time();
    o.rest_speed_m_s *= time();
    return o;
  }
};

// Bit for bit, but where doubles underflow: a ball that spins on the spot loses its last sideways speed by
// halves until it is less than any number with all its digits.
bool same(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0 || std::max(std::abs(a), std::abs(b)) < 1e-290;
}
bool same(const Vec3& a, const Vec3& b) {
  return same(a.x(), b.x()) && same(a.y(), b.y()) && same(a.z(), b.z());
}
bool same(const Quat& a, const Quat& b) { return same(a.w(), b.w()) && same(Vec3(a.vec()), Vec3(b.vec())); }

// What differs first between a run and the rescaled run of the scaled body; empty if nothing does.
std::string difference(const Run& run, const Run& scaled, const Scale& scale) {
  for (std::size_t i = 0; i < std::min(run.nodes.size(), scaled.nodes.size()); ++i) {
    const Node &a = run.nodes[i], &b = scaled.nodes[i];
    const State expected = scale.of(a.state);
    if (a.phase != b.phase || !same(a.time_s * scale.time(), b.time_s) ||
        !same(expected.position, b.state.position) || !same(expected.orientation, b.state.orientation) ||
        !same(expected.velocity, b.state.velocity) ||
        !same(expected.angular_velocity, b.state.angular_velocity))
      return "node " + std::to_string(i) + " of " + std::to_string(run.nodes.size()) + " at " +
             std::to_string(a.time_s) + " s, " + (a.phase == Phase::flight ? "flight" : "contact");
  }
  if (run.nodes.size() != scaled.nodes.size() || run.hits.size() != scaled.hits.size())
    return "the number of nodes";
  for (std::size_t i = 0; i < run.hits.size(); ++i) {
    const Hit &a = run.hits[i], &b = scaled.hits[i];
    if (!same(a.time_s * scale.time(), b.time_s) || !same(a.impulse_n_s * scale.impulse(), b.impulse_n_s) ||
        !same(a.approach_speed_m_s * scale.time(), b.approach_speed_m_s) ||
        !same(a.position_m * scale.length(), b.position_m))
      return "hit " + std::to_string(i);
  }
  if (run.status != scaled.status || !same(run.rest_s * scale.time(), scaled.rest_s)) return "the rest";
  return "";
}

struct Named {
  const char* name;
  Body body;
};

std::vector<Named> bodies() {
  std::vector<Named> all{{"cube", sample::box({0.016, 0.016, 0.016}, 0.005)},
                         {"eraser", sample::box({0.05, 0.02, 0.012}, 0.02, {0.7, 0.7, 5e-5, 5e-5})},
                         {"card", sample::box({0.085, 0.054, 0.0008}, 0.005, {0.35, 0.3, 5e-5, 5e-5})},
                         {"ball", sample::ball(0.02, 0.03, {0.6, 0.3, 5e-4, 5e-5})},
                         {"rod", sample::rod(0.15, 0.004, 0.02)}};
  Body::Definition coin;
  const double radius = 0.0125;
  for (int i = 0; i < 40; ++i)
    for (const double side : {-4e-4, 4e-4}) {
      const double angle = std::numbers::pi * i / 20;
      coin.vertices_m.push_back({radius * std::cos(angle), radius * std::sin(angle), side});
    }
  coin.mass_kg = 0.003;
  coin.inertia_kg_m2 = 0.25 * coin.mass_kg * radius * radius * Vec3(1.0, 1.0, 2.0).asDiagonal();
  all.push_back({"coin", Body::make(coin)});
  Body::Definition skew = sample::box({0.02, 0.03, 0.04}, 0.02).definition();  // axes and mass centre oblique
  const Mat3 turn = rotation_exp({0.3, -0.5, 0.7}).toRotationMatrix();
  skew.inertia_kg_m2 = turn * skew.inertia_kg_m2 * turn.transpose();
  skew.centre_of_mass_m = {0.002, -0.003, 0.004};
  all.push_back({"skew box", Body::make(skew)});
  return all;
}

class HardCase20 : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Body, HardCase20, ::testing::Range(0, 7));

// Whole runs, thrown down to rest: flight, impacts, sustained contact and the rule for rest.
TEST_P(HardCase20, ScaledRunsHaveTheSameBits) {
  const auto [name, body] = bodies()[static_cast<std::size_t>(GetParam())];
  RandomStream random(601, static_cast<std::uint64_t>(GetParam()));
  const double until = 20.0;
  int contact = 0;
  for (int i = 0; i < 20; ++i) {
    const State s = sample::random_state(body, random, 0.1, 2.0, 20.0);
    SimulationOptions options;
    options.max_impacts = 5000;
    const auto run = simulate(body, s, options, until);
    for (const Node& n : run.nodes) contact += n.phase == Phase::contact;
    for (const Scale& scale :
         {Scale{0, 10}, Scale{0, 1}, Scale{1, 0}, Scale{-3, 0}, Scale{6, 6}, Scale{-2, -5}}) {
      const auto scaled = simulate(scale.of(body), scale.of(s), scale.of(options), until * scale.time());
      EXPECT_EQ(difference(run, scaled, scale), "")
          << name << " " << i << ", lengths x 4^" << scale.k << ", mass x 2^" << scale.j;
    }
  }
  EXPECT_GT(contact, 100) << name << ": too little sustained contact to test it";
}

// The first two impacts of any yaw, where the second is not beyond a rest. Rounding of the yaw, 1e-16, grows
// in the first impact and on the way to the second.
TEST(HardCase21, YawTurnsTheMotionAndNothingElse) {
  Held time("impact times, s", 1e-10), place("positions, m", 1e-10), velocity("velocities, m/s", 1e-10),
      spin("speeds of the furthest point by spin, m/s", 1e-10), turn("orientations, rad", 1e-10);
  for (const auto& [name, body] : bodies()) {
    RandomStream random(602, 0);
    int compared = 0;
    for (int i = 0; i < 100; ++i) {
      const State s = sample::random_state(body, random, 0.1, 2.0, 20.0);
      const Quat yaw(Eigen::AngleAxisd(random.uniform(0.0, 2.0 * std::numbers::pi), kUp));
      State turned = s;
      turned.position = yaw * s.position;
      turned.orientation = yaw * s.orientation;
      turned.velocity = yaw * s.velocity;
      turned.angular_velocity = yaw * s.angular_velocity;
      EventSimulation a(body, {}), b(body, {});
      a.start(s, 0.0);
      b.start(turned, 0.0);
      for (int impact = 0; impact < 2; ++impact) {
        ASSERT_EQ(a.advance(5.0), EventSimulation::Stop::impact);
        ASSERT_EQ(b.advance(5.0), EventSimulation::Stop::impact);
        a.resolve();
        b.resolve();
        if (a.in_contact()) break;
        const State &x = a.state(), &y = b.state();
        time.see(std::abs(a.time_s() - b.time_s()), name, i, impact);
        place.see((y.position - yaw * x.position).norm(), name, i, impact);
        velocity.see((y.velocity - yaw * x.velocity).norm(), name, i, impact);
        spin.see((y.angular_velocity - yaw * x.angular_velocity).norm() * body.bounding_radius_m(), name, i,
                 impact);
        turn.see(sample::angle_between(y.orientation, yaw * x.orientation), name, i, impact);
        ++compared;
      }
    }
    EXPECT_GT(compared, 100) << name;
  }
}

}  // namespace
}  // namespace ifa
