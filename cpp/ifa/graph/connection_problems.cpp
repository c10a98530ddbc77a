#include "ifa/graph/connection_problems.hpp"

#include <cmath>
#include <numbers>

#include "ifa/base/error.hpp"
#include "ifa/base/random.hpp"
#include "ifa/graph/harvest.hpp"
#include "ifa/rigid/flight.hpp"
#include "ifa/signature/factors.hpp"

namespace ifa {
namespace {

constexpr double kLogCutOff = -10.0;
constexpr double kUntil_s = 30.0;

// Eq. 4: the largest tilt between the two.
double most_tilt_rad(double duration_s) {
  constexpr double kWeight = 0.85, kScale_s = 0.2;
  return std::sqrt(-kLogCutOff / kWeight) * std::min(duration_s, kScale_s);
}

}  // namespace

std::vector<ConnectionProblem> draw_connection_problems(const Body& body, std::uint64_t seed,
                                                        std::size_t simulations, std::size_t count,
                                                        const Vec3& gravity) {
  SearchPhysics physics;
  physics.simulation.gravity_m_s2 = gravity;
  const NodeColumns columns = harvest(body, physics, {}, seed, 0, simulations, kUntil_s);
  const Nodes nodes = view_of(columns);
  std::vector<std::size_t> usable;  // onset and take-off in one: the state is known to all digits
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (nodes.flight_s[i] > 0.0f && nodes.delay_s[i] == 0.0f) usable.push_back(i);
  if (usable.empty()) throw ArgumentError("body: no impact of its simulations is followed by a flight");
  std::vector<ConnectionProblem> problems;
  Flight flight(body);
  for (std::size_t k = 0; k < count; ++k) {
    RandomStream random(seed + 1, k);
    const std::size_t i =
        usable[static_cast<std::size_t>(random.uniform() * static_cast<double>(usable.size()))];
    ConnectionProblem p;
    p.from = onset_of(nodes, i);
    p.flight_s = static_cast<double>(nodes.flight_s[i]);
    p.duration_s = random.uniform(0.02, 0.5);
    const float* change = nodes.change.data() + 6 * i;
    const Quat& q = p.from.orientation;
    const PlausibleRegion region(q * Vec3(change[0], change[1], change[2]),
                                 q * Vec3(change[3], change[4], change[5]), body.bounding_radius_m());
    // Registration leaves no yaw: the axis of the tilt is level.
    const double heading = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double tilt = random.uniform(0.0, most_tilt_rad(p.duration_s));
    p.like = p.from;
    p.like.orientation = rotation_exp(tilt * Vec3(std::cos(heading), std::sin(heading), 0.0)) * q;
    Vec6 y;  // uniform in the 6-ball of the cut-off
    for (double& v : y) v = random.normal();
    y *= std::sqrt(-kLogCutOff) * std::pow(random.uniform(), 1.0 / 6.0) / y.norm();
    p.like.velocity += region.velocity_offset(y);
    p.like.angular_velocity += region.spin_offset(y);
    flight.start(p.like, gravity);
    p.to = flight.at(p.duration_s);
    problems.push_back(p);
  }
  return problems;
}

}  // namespace ifa
