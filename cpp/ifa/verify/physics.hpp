// What the motion does between and across its impacts: flights, energy, penetration, jumps, rest.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "ifa/verify/contacts.hpp"
#include "ifa/verify/track.hpp"

namespace ifa::verify {

// The claimed retiming ratio in force at a time.
using RetimeAt = std::function<double(double time_s)>;

struct Flight {
  int first, last;  // samples
  FlightCheck check;
};

// Stretches in which nothing touches and whose clearance somewhere exceeds ten touching heights. Where one
// begins or ends by lifting off or landing softly rather than at an impact, 2 ms are left out: the poses
// there are interpolated between steps of sustained contact.
std::vector<Flight> find_flights(const Track& track, const Impacts& impacts, double gravity_m_s2,
                                 const RetimeAt& retime_at);

struct EnergyGain {
  double flights_j = 0.0, flights_time_s = 0.0,
         flights_tolerance_j = 0.0;              // the worst excess over its tolerance
  double largest_j = 0.0;                        // from one flight to the next
  double contact_j = 0.0, contact_time_s = 0.0;  // beyond the measuring error of sustained contact
};

// Mechanical energy, in unretimed time, must not grow by more than `allowed_j` from flight to flight, nor
// through sustained contact. In sustained contact it is the mean over up to 4 ms of the intervals' energies,
// good to a tenth of the kinetic energy and a speed of 0.05 m/s.
EnergyGain energy_gain(const Track& track, const Impacts& impacts, const std::vector<Flight>& flights,
                       double gravity_m_s2, double allowed_j, const RetimeAt& retime_at);

// The deepest hull point: at samples, between them along the smooth motion, and where an impact lies between
// samples at the meeting point of the paths before and after.
void find_penetration(const Track& track, const Impacts& impacts, double limit_m, double gravity_m_s2,
                      double* depth_m, double* time_s);

// Intervals crossed much faster than both their neighbours are.
std::vector<int> find_jumps(const Track& track);

struct Rest {
  double since_s = 0.0;         // no hull point faster than the limit from here to the end
  double last_speed_m_s = 0.0;  // of the fastest hull point just before
  bool supported = false;       // at the end the mass centre is over the touching points
};
Rest find_rest(const Track& track, double speed_m_s);

}  // namespace ifa::verify
