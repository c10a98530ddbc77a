#include "ifa/forward/start.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ifa/motion/sampling.hpp"

namespace ifa {

StartOptions start_options(const Body& body, const Marks& marks, double gravity_m_s2) {
  StartOptions options{0.5, 4.0, 0.03};
  double longest = 0.0;
  for (std::size_t k = 1; k < marks.size(); ++k)
    longest = std::max(longest, marks.times_s[k] - marks.times_s[k - 1]);
  // A gap T of free flight leaves the ground at g T / 2, after an impact 1 / e times as fast.
  const double bounce = std::max(body.material().restitution, 0.2);
  options.most_speed_m_s = std::max(4.0, 0.75 * gravity_m_s2 * longest / bounce);
  return options;
}

double clear_before(const Body& body, const State& first, const Vec3& gravity_m_s2, double limit_s) {
  State reversed = first;
  reversed.velocity = -first.velocity;
  reversed.angular_velocity = -first.angular_velocity;
  Flight flight(body);
  flight.start(reversed, gravity_m_s2);
  return std::min(flight.next_contact(limit_s), limit_s);
}

namespace {

bool usable(const Body& body, const SearchPhysics& physics, const StartOptions& options, const State& s) {
  EventSimulation at(body, physics.simulation);
  at.start(s, 0.0);
  return at.approach_speed() >= physics.hearing.audible_speed_m_s * (1.0 + physics.margin) &&
         clear_before(body, s, physics.simulation.gravity_m_s2, options.clear_s) >= options.clear_s;
}

}  // namespace

std::optional<State> sample_start(const Body& body, const SearchPhysics& physics, const StartOptions& options,
                                  RandomStream& random) {
  State s = sample_touching(body, random);
  constexpr double kDegree = std::numbers::pi / 180.0;
  const bool thrown = random.uniform() < 0.5;
  const double cone = (thrown ? 80.0 : 30.0) * kDegree;
  const Vec3 direction = sample_downward(cone, random);
  const double speed = random.uniform(options.least_speed_m_s, options.most_speed_m_s);
  s.velocity = speed * direction;
  const double most_spin = thrown ? std::max(20.0, speed / body.bounding_radius_m()) : 20.0;
  Vec3 axis = random.unit_vector();
  if (thrown)
    axis = (kUp.cross(s.velocity).normalized() + 0.5 * axis).normalized();  // mostly rolling forwards
  s.angular_velocity = axis * random.uniform(0.0, most_spin);

  if (!usable(body, physics, options, s)) return std::nullopt;
  return s;
}

std::optional<State> sample_touchdown(const Body& body, const SearchPhysics& physics,
                                      const StartOptions& options, RandomStream& random) {
  State drop = sample_touching(body, random);
  drop.velocity.z() = -random.uniform(0.1, 1.0);
  constexpr double kLongestDrop_s = 5.0;
  SimulationOptions brief = physics.simulation;
  brief.max_impacts = 300;  // a drop that chatters on is given up
  const Run run = simulate(body, drop, brief, kLongestDrop_s);
  if (run.status != RunStatus::rest) return std::nullopt;
  const double tilt = std::pow(10.0, random.uniform(-4.0, -1.0));
  State s;
  s.orientation =
      (rotation_exp(tilt * random.unit_vector()) * run.nodes.back().state.orientation).normalized();
  s.position.z() = -lowest_gap_m(body, s);
  s.velocity = Vec3(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2),
                    -0.06 * std::pow(1.0 / 0.06, random.uniform()));
  s.angular_velocity = Vec3(0.0, 0.0, random.uniform(-3.0, 3.0));
  if (!usable(body, physics, options, s)) return std::nullopt;
  return s;
}

}  // namespace ifa
