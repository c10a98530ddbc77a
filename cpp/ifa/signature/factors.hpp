// Plausibility and affinity factors: how good one transition of a motion is (paper section 5.4).
#pragma once

#include <vector>

#include "ifa/base/linear_algebra.hpp"
#include "ifa/signature/events.hpp"
#include "ifa/signature/marks.hpp"

namespace ifa {

// The region of changes to a post-contact velocity that a viewer takes for physics: an ellipsoid along and
// across the impact's own change (paper eq. 2, after O'Sullivan et al. 2003). `excess` is |C v_eval|^2, 1 at
// its edge. Points y of the unit 6-ball (linear, then angular) are the region's own coordinates: excess =
// |y|^2.
class PlausibleRegion {
 public:
  // Changes of velocity and spin by the impact. A vanishing change would make the region a point and C
  // infinite: both are floored, at 0.01 m/s and at 0.01 m/s over the body's radius.
  PlausibleRegion(const Vec3& velocity_change, const Vec3& spin_change, double radius_m);

  Vec3 velocity_offset(const Vec6& y) const { return linear_ * y.head<3>(); }
  Vec3 spin_offset(const Vec6& y) const { return angular_ * y.tail<3>(); }
  Vec6 coordinates(const Vec3& velocity_offset, const Vec3& spin_offset) const;
  double excess(const Vec3& velocity_offset, const Vec3& spin_offset) const;

 private:
  Mat3 linear_, angular_;  // columns: the ellipsoid's half axes in world axes
};

// The six factors of one transition, each in [0, 1] (paper eqs. 3-8).
struct Factors {
  double velocity = 1.0, orientation = 1.0, time = 1.0, amplitude = 1.0, length = 1.0, centroid = 1.0;
};

double velocity_factor(double excess);                       // eq. 3
double time_factor(double interval_s, double target_s);      // eq. 5; the interval before retiming
double amplitude_factor(double amplitude, double target);    // eq. 6; both relative to the first event
double length_factor(double length_s, double target_s);      // eq. 7
double centroid_factor(double centroid_s, double target_s);  // eq. 8

// Their logarithms, where products of many are compared.
double log_orientation_factor(double angle_rad, double flight_s);  // eq. 4
inline constexpr double kShortFlight_s = 0.2;                      // T_0: in longer flights it is the same
double log_time_factor(double interval_s, double target_s);
double log_amplitude_factor(double amplitude, double target);
double log_length_factor(double length_s, double target_s);  // and of a centroid

// Which of f_a, f_l and f_c of marks with a duration are judged; the others are 1. That a discrete mark's
// event is longer than discrete is judged by f_l in any case.
struct SoundTerms {
  bool amplitude = true, length = true, centroid = true;
};

// f_a f_l f_c of an event that shall meet mark k. `first_amplitude` is the motion's first event's.
Factors sound_factors(const Event& event, const Marks& marks, std::size_t k, double first_amplitude,
                      const SoundTerms& judged = {});

double log_product(const Factors& f);                             // of all six
double score(const std::vector<Factors>& factors);                // eq. 12, one set of factors for each mark
double score_without_sound(const std::vector<Factors>& factors);  // eq. 13

}  // namespace ifa
