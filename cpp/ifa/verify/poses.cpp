// Checks of the poses themselves: penetration, jumps, rest.
#include <algorithm>
#include <cmath>

#include "ifa/verify/physics.hpp"

namespace ifa::verify {
namespace {

constexpr double kJumpRatio = 1.5;      // to the faster neighbour
constexpr double kJumpDistance = 1e-4;  // m beyond that
constexpr double kSupportTouch =
    1e-4;  // m; with the support's slack, a balance this fine is taken as support
constexpr double kSupportSlack = 0.01;  // of the bounding radius
constexpr double kPi = 3.14159265358979323846;

}  // namespace

void find_penetration(const Track& track, const Impacts& impacts, double limit_m, double gravity_m_s2,
                      double* depth_m, double* time_s) {
  *depth_m = std::max(0.0, impacts.deepest_m);
  *time_s = impacts.deepest_time_s;
  const auto deeper = [&](double depth, double time) {
    if (depth <= *depth_m) return;
    *depth_m = depth;
    *time_s = time;
  };
  for (int i = 0; i < track.size(); ++i) deeper(-track.lowest(i), track.time(i));
  const double radius = track.body().bounding_radius_m();
  for (int j = 0; j + 1 < track.size(); ++j) {
    if (impacts.kinked[j]) continue;
    const double step = track.step(j);
    const double spin = track.turn(j) / step;
    const double sag = (2.0 * spin * spin * radius + gravity_m_s2) * step * step / 8.0;
    const double floor = std::min(track.lowest(j), track.lowest(j + 1)) - sag;
    if (-floor <= std::max(*depth_m, 0.1 * limit_m)) continue;
    Velocity velocity;
    velocity.momentum = track.momentum(j);
    velocity.acceleration = -gravity_m_s2 * kUp;
    velocity.linear = (track.position(j + 1) - track.position(j)) / step - 0.5 * step * velocity.acceleration;
    for (int part = 1; part < 8; ++part) {
      const double s = step * part / 8.0;
      const Pose pose = track.extrapolate(j, velocity, s);
      for (int k = 0; k < track.points(); ++k) deeper(-track.height(k, pose), track.time(j) + s);
    }
  }
}

std::vector<int> find_jumps(const Track& track) {
  std::vector<int> jumps;
  const int intervals = track.size() - 1;
  const double radius = track.body().bounding_radius_m();
  const auto speed = [&](int j) {
    return (track.position(j + 1) - track.position(j)).norm() / track.step(j);
  };
  const auto spin = [&](int j) { return radius * track.turn(j) / track.step(j); };
  const auto jumps_at = [&](int j, const auto& rate) {
    double neighbour = 0.0;
    if (j > 0) neighbour = rate(j - 1);
    if (j + 1 < intervals) neighbour = std::max(neighbour, rate(j + 1));
    return (rate(j) - kJumpRatio * neighbour) * track.step(j) > kJumpDistance;
  };
  if (intervals < 2) return jumps;
  for (int j = 0; j < intervals; ++j)
    if (jumps_at(j, speed) || jumps_at(j, spin)) jumps.push_back(j);
  return jumps;
}

Rest find_rest(const Track& track, double speed_m_s) {
  Rest rest;
  const double radius = track.body().radius_m();
  int j = track.size() - 2;
  for (; j >= 0; --j) {
    double speed = 0.0;
    for (const Vec3& p : track.fixed_points())
      speed = std::max(speed, (track.position(j + 1) + track.orientation(j + 1) * p - track.position(j) -
                               track.orientation(j) * p)
                                  .norm());
    speed = (speed + track.turn(j) * radius) / track.step(j);
    if (speed >= speed_m_s) {
      rest.last_speed_m_s = speed;
      break;
    }
  }
  rest.since_s = track.time(j + 1);

  // The mass centre is outside the touching points' hull if some direction has them all on one side.
  const int end = track.size() - 1;
  std::vector<Vec3> support;
  for (int k = 0; k < track.points(); ++k)
    if (track.height(k, end) <= kSupportTouch) support.push_back(track.arm(k, track.orientation(end)));
  rest.supported = !support.empty();
  const double slack = std::max(kSupportTouch, kSupportSlack * track.body().bounding_radius_m());
  for (int d = 0; d < 360 && rest.supported; ++d) {
    const Vec3 direction(std::cos(kPi * d / 180.0), std::sin(kPi * d / 180.0), 0.0);
    double farthest = -1e300;
    for (const Vec3& p : support) farthest = std::max(farthest, direction.dot(p));
    rest.supported = farthest >= -slack;
  }
  return rest;
}

}  // namespace ifa::verify
