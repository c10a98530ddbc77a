#include <algorithm>
#include <cmath>

#include "ifa/verify/physics.hpp"

namespace ifa::verify {
namespace {

constexpr double kClearTouches = 10.0;
constexpr double kSoftEnd = 2e-3;        // s
constexpr double kPositionNoise = 1e-8;  // m; a smaller deviation from the parabola proves nothing
constexpr double kRotationNoise = 1e-8;  // rad, of one orientation against the next
constexpr double kSlowSpin = 0.1;        // rad/s; the drift of a slower spin is taken relative to this

FlightCheck check_flight(const Track& track, int first, int last, double gravity, double retime) {
  FlightCheck check;
  check.start_s = track.time(first);
  check.end_s = track.time(last);
  const double length = check.end_s - check.start_s;
  const double shown_gravity = gravity / (retime * retime);
  const double sagitta = shown_gravity * length * length / 8.0;
  const Vec3 mean = (track.position(last) - track.position(first)) / length;
  double vertical = 0.0, horizontal = 0.0;
  for (int i = first; i <= last; ++i) {
    const double s = track.time(i) - check.start_s;
    Vec3 error = track.position(i) - track.position(first) - s * mean;
    error.z() -= 0.5 * shown_gravity * s * (length - s);
    vertical = std::max(vertical, std::abs(error.z()));
    horizontal = std::max(horizontal, error.head<2>().norm());
  }
  check.gravity_error = std::max(0.0, vertical - kPositionNoise) / sagitta;
  check.horizontal_acceleration_m_s2 = std::max(0.0, horizontal - kPositionNoise) * 8.0 / (length * length);

  const double inertia = track.body().principal_inertia().maxCoeff();
  const Vec3& kept = track.momentum(first);
  const double scale = std::max(kept.norm(), inertia * kSlowSpin);
  for (int j = first; j < last; ++j) {
    const double noise = inertia * kRotationNoise * (1.0 / track.step(j) + 1.0 / track.step(first));
    const double drift = std::max(0.0, (track.momentum(j) - kept).norm() - noise);
    check.momentum_drift = std::max(check.momentum_drift, drift / scale);
  }

  const Vec3 velocity = retime * (mean + 0.5 * shown_gravity * length * kUp);
  const Vec3 spin = track.angular_velocity(track.orientation(first), kept);
  const double mass = track.body().mass_kg();
  check.energy_j = 0.5 * mass * velocity.squaredNorm() + 0.5 * retime * retime * kept.dot(spin) +
                   mass * gravity * track.position(first).z();
  return check;
}

}  // namespace

std::vector<Flight> find_flights(const Track& track, const Impacts& impacts, double gravity_m_s2,
                                 const RetimeAt& retime_at) {
  std::vector<char> impact_at(track.size(), 0);
  for (const Impact& impact : impacts.list)
    if (impact.at_sample) impact_at[impact.sample] = 1;
  std::vector<Flight> flights;
  const auto close = [&](int first, int last, bool hard_start, bool hard_end) {
    double clearance = 0.0;
    for (int i = first; i <= last; ++i) clearance = std::max(clearance, track.lowest(i));
    if (clearance <= kClearTouches * track.touch()) return;
    if (!hard_start) {
      while (first < last && track.lowest(first) <= 4.0 * track.touch()) ++first;
      const double from = track.time(first) + kSoftEnd;
      while (first < last && track.time(first) < from) ++first;
    }
    if (!hard_end) {
      const double to = track.time(last) - kSoftEnd;
      while (last > first && track.time(last) > to) --last;
    }
    if (last - first < 3) return;
    const double middle = 0.5 * (track.time(first) + track.time(last));
    flights.push_back({first, last, check_flight(track, first, last, gravity_m_s2, retime_at(middle))});
  };

  const auto touches = [&](int i) { return track.lowest(i) <= track.touch(); };
  int start = 0;
  bool hard_start = !touches(0);
  for (int i = 1; i < track.size(); ++i) {
    if (impacts.kinked[i - 1]) {
      close(start, i - 1, hard_start, true);
      start = i;
      hard_start = !touches(i);
    } else if (touches(i)) {
      close(start, i, hard_start, impact_at[i]);
      start = i;
      hard_start = impact_at[i];
    }
  }
  close(start, track.size() - 1, hard_start, !touches(track.size() - 1));
  return flights;
}

}  // namespace ifa::verify
