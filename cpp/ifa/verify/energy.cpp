#include <algorithm>
#include <cmath>
#include <optional>

#include "ifa/verify/physics.hpp"

namespace ifa::verify {
namespace {

constexpr double kWindow = 2e-3;          // s to either side
constexpr double kShortestWindow = 1e-3;  // s in all
constexpr double kContactShare = 0.1;     // of the kinetic energy: error of differences in sustained contact
constexpr double kContactSpeed = 0.05;    // m/s, likewise
constexpr double kContactHeight = 1e-4;   // m, likewise: what sinking in may give back
constexpr double kFlightShare = 1e-3;     // of the kinetic energy: a growth of 0.05 % in speed shows nowhere

struct ContactEnergy {
  double total_j, tolerance_j;
};

class ContactMeter {
 public:
  ContactMeter(const Track& track, const Impacts& impacts, double gravity_m_s2, const RetimeAt& retime_at)
      : track_(track),
        gravity_(gravity_m_s2),
        retime_at_(retime_at),
        impact_at_(track.size(), 0),
        low_(track.size()),
        high_(track.size()) {
    // The samples around each that no impact separates from it.
    const int n = track.size();
    for (const Impact& impact : impacts.list)
      if (impact.at_sample) impact_at_[impact.sample] = 1;
    for (int i = 0; i < n; ++i)
      low_[i] = i == 0 || impacts.kinked[i - 1] ? i : (impact_at_[i - 1] ? i - 1 : low_[i - 1]);
    for (int i = n - 1; i >= 0; --i)
      high_[i] = i == n - 1 || impacts.kinked[i] ? i : (impact_at_[i + 1] ? i + 1 : high_[i + 1]);
  }

  // Nothing at impacts, nor where they leave less than a millisecond.
  std::optional<ContactEnergy> at(int i) const {
    if (impact_at_[i]) return std::nullopt;
    int from = i, to = i;
    while (from > low_[i] && track_.time(i) - track_.time(from - 1) <= kWindow) --from;
    while (to < high_[i] && track_.time(to + 1) - track_.time(i) <= kWindow) ++to;
    const double length = track_.time(to) - track_.time(from);
    if (length < kShortestWindow || from == i || to == i) return std::nullopt;
    // The mean of the intervals' energies, not the energy of their mean velocity: a wobbling coin turns its
    // velocity round within a millisecond.
    const Body& body = track_.body();
    const double mass = body.mass_kg();
    double height = 0.0, kinetic = 0.0;
    for (int j = from; j < to; ++j) {
      const double share = track_.step(j) / length;
      const Vec3 velocity = (track_.position(j + 1) - track_.position(j)) / track_.step(j);
      const Vec3& momentum = track_.momentum(j);
      const Vec3 spin = track_.angular_velocity(track_.orientation(j), momentum);
      kinetic += 0.5 * share * (mass * velocity.squaredNorm() + momentum.dot(spin));
      height += 0.5 * share * (track_.position(j).z() + track_.position(j + 1).z());
    }
    const double retime = retime_at_(track_.time(i));
    kinetic *= retime * retime;
    return ContactEnergy{kinetic + mass * gravity_ * height, kContactShare * kinetic +
                                                                 0.5 * mass * kContactSpeed * kContactSpeed +
                                                                 mass * gravity_ * kContactHeight};
  }

 private:
  const Track& track_;
  double gravity_;
  const RetimeAt& retime_at_;
  std::vector<char> impact_at_;
  std::vector<int> low_, high_;
};

}  // namespace

EnergyGain energy_gain(const Track& track, const Impacts& impacts, const std::vector<Flight>& flights,
                       double gravity_m_s2, double allowed_j, const RetimeAt& retime_at) {
  EnergyGain gain;
  const double weight = track.body().mass_kg() * gravity_m_s2;
  double worst = 0.0;
  for (std::size_t f = 0; f + 1 < flights.size(); ++f) {
    const double grown = flights[f + 1].check.energy_j - flights[f].check.energy_j;
    gain.largest_j = std::max(gain.largest_j, grown);
    const double kinetic =
        std::max(0.0, flights[f].check.energy_j - weight * track.position(flights[f].last).z());
    const double excess = grown - allowed_j - kFlightShare * kinetic;
    if (excess > worst) {
      worst = excess;
      gain.flights_j = grown;
      gain.flights_time_s = track.time(flights[f + 1].first);
      gain.flights_tolerance_j = grown - excess;
    }
  }

  // Through sustained contact: against the least energy seen since the last impact, which may add allowed_j.
  const ContactMeter meter(track, impacts, gravity_m_s2, retime_at);
  std::optional<double> level, contact_level;
  std::size_t next_flight = 0, next_impact = 0;
  const auto compare = [&](double energy, double tolerance, double time_s) {
    const double excess = energy - *level - tolerance;
    if (excess > gain.contact_j) {
      gain.contact_j = excess;
      gain.contact_time_s = time_s;
    }
  };
  for (int i = 0; i < track.size(); ++i) {
    double gains = 0.0;
    while (next_impact < impacts.list.size() && impacts.list[next_impact].sample < i) {
      gains = allowed_j;
      ++next_impact;
    }
    if (level) *level += gains;
    if (next_flight < flights.size() && flights[next_flight].first <= i) {
      const Flight& flight = flights[next_flight++];
      const double energy = flight.check.energy_j;
      const double kinetic = std::max(0.0, energy - weight * track.position(flight.first).z());
      const double mass = track.body().mass_kg();
      // from flight to flight the exact comparison above decides
      if (level && contact_level)
        compare(
            energy,
            kContactShare * kinetic + 0.5 * mass * kContactSpeed * kContactSpeed + weight * kContactHeight,
            track.time(flight.first));
      level = energy;
      contact_level.reset();
      i = std::max(i, flight.last - 1);
      continue;
    }
    const auto energy = meter.at(i);
    if (!energy) continue;
    if (level) compare(energy->total_j, energy->tolerance_j, track.time(i));
    level = level ? std::min(*level, energy->total_j) : energy->total_j;
    contact_level = level;
  }
  return gain;
}

}  // namespace ifa::verify
