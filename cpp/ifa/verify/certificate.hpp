// The independent check of an exported motion: contacts, timing and physics again, from poses alone. Shares
// no code with simulation or search, so an error there cannot hide here.
#pragma once

#include <string>
#include <vector>

#include "ifa/base/linear_algebra.hpp"
#include "ifa/rigid/body.hpp"

namespace ifa::verify {

// What was exported. Expected sampling: steps of at most 1 ms, samples at the impact instants, and at least
// four between two of them. Impacts that fall between samples are found too, and then timed to a fraction of
// a step.
struct Poses {
  std::vector<double> times_s;
  std::vector<Vec3> positions_m;   // of the centre of mass
  std::vector<Quat> orientations;  // body axes to world axes
};

struct MarkSet {
  std::vector<double> times_s;
  std::vector<double> durations_s;  // empty: all 0
  bool rest = true;                 // the ending asked for: at rest after the last event, or open
};

// What the solver says it did to the motion. Flights must bear it out.
struct Claims {
  // Per mark: length of the transition that ends there, retimed over simulated. Slowed down by r, a flight
  // shows gravity / r^2. Empty: all 1.
  std::vector<double> retime;
  double energy_gain_j = 0.0;  // that any one contact may add
};

// What an event is: a chain of audible hits, or an interval of contact with the ground between two flights.
enum class Events { audible, contact };

struct Options {
  Events events = Events::audible;
  double audible_speed_m_s = 0.05;
  double merge_gap_s = 0.010;
  double gravity_m_s2 = 9.81;
  double rest_speed_m_s = 0.01;
  double rest_duration_s = 0.050;
  double time_tolerance_s = 1e-3;
  double penetration_limit_m = 1e-4;
  double retime_limit = 0.30;
  double max_step_s = 1e-3;
  // Hysteresis: a hit within this share of the audible speed may count as audible or as silent, whichever
  // suits the marks; two honest measurements of the same hit differ by less.
  double speed_margin = 0.05;
};

// An audible impact; where contact makes the events, any impact.
struct DetectedHit {
  double time_s = 0.0;
  double approach_speed_m_s = 0.0;  // as shown; the largest over the touching points
  Vec3 position_m = Vec3::Zero();   // of that point, on the ground
  bool certain = false;             // louder than the hysteresis band (below it, a hit is not listed)
  int event = 0;
};

// Hits chained by the merge gap, those inside the hysteresis band included; or an interval of contact.
struct DetectedEvent {
  double time_s = 0.0;      // of its first hit, or where contact begins
  double duration_s = 0.0;  // to its last hit, or to where contact ends or the body comes to rest
  int hits = 0;             // in an interval of contact possibly none: a landing too soft to be seen as one
};

struct MarkCheck {
  double target_s = 0.0;
  bool matched = false;
  double achieved_s = 0.0, error_s = 0.0;  // where matched; error = achieved - target
};

struct FlightCheck {
  double start_s = 0.0, end_s = 0.0;
  double gravity_error = 0.0;                 // relative, by the largest deviation from the parabola
  double horizontal_acceleration_m_s2 = 0.0;  // likewise
  double momentum_drift = 0.0;                // of the angular momentum, relative
  double energy_j = 0.0;                      // before retiming
};

struct Certificate {
  bool passed = false;
  std::vector<std::string> failures;
  std::vector<DetectedHit> hits;
  std::vector<DetectedEvent> events;
  std::vector<MarkCheck> marks;
  std::vector<FlightCheck> flights;
  std::vector<double> extra_events_s;
  int missed_hits = 0, extra_hits = 0;  // marks without an event; certain events without a mark
  double max_abs_error_s = 0.0;         // over the matched marks
  double max_penetration_m = 0.0, max_penetration_time_s = 0.0;
  double max_gravity_error = 0.0, max_horizontal_acceleration_m_s2 = 0.0, max_momentum_drift = 0.0;
  double max_energy_gain_j = 0.0;  // from one flight to the next
  double max_contact_energy_gain_j =
      0.0;  // where sustained contact is involved: beyond what can be measured there
  bool at_rest = false;
  double rest_s = 0.0;  // from here on at rest; the end of the motion where it never is
};

// Never throws on bad poses: what cannot be checked is a failure in the certificate. Throws ArgumentError on
// arrays of unequal length and on options, marks or claims that make no sense.
Certificate verify(const Poses& poses, const Body& body, const MarkSet& marks, const Claims& claims,
                   const Options& options);

}  // namespace ifa::verify
