// Motions with known impacts, made here from closed forms and from an integrator of the tests' own.
#pragma once

#include <vector>

#include "ifa/rigid/body.hpp"
#include "ifa/verify/certificate.hpp"

namespace ifa::verify::test {

inline constexpr double kG = 9.81;

struct Motion {
  Poses poses;
  std::vector<double> impact_times_s, impact_speeds_m_s;

  void add(double time_s, const Vec3& position, const Quat& orientation) {
    poses.times_s.push_back(time_s);
    poses.positions_m.push_back(position);
    poses.orientations.push_back(orientation);
  }
  int first_at(double time_s) const;  // the first sample not before it
};

Body ball(double radius_m = 0.01);
Body box(const Vec3& size_m = {0.016, 0.02, 0.03});

// Dropped at t = 0 with its lowest point at `height_m`; drifts and spins at constant rates; `bounces`
// impacts, then stands still from the last one on for 0.1 s (the last impact has no restitution). Samples as
// an exporter's; or, with `every_s` > 0, on a grid that misses the impacts.
Motion bouncing_ball(const Body& body, double height_m, double restitution, int bounces,
                     double every_s = 0.0);

struct Spinning {
  Vec3 x, v;
  Quat q;
  Vec3 w;  // body axes
};

// A tossed box: torque-free flights by Runge-Kutta at 10 us, frictionless impulses with Newton's restitution
// at the corner that touches, `impacts` of them, ending in flight.
Motion tumbling_box(const Body& body, double restitution, int impacts, double every_s = 0.0);
Motion tossed_box(const Body& body, const Spinning& start, double restitution, int impacts,
                  double every_s = 0.0);

// A thin disk of the radius.
Body disk(double radius_m = 0.0127);

// A disk that rolls from one side over to the other at `rate_rad_s`, its rim on the ground all the time: its
// axis leans along a straight line that passes the vertical by `least_tilt_rad` at t = 0. Its lowest point
// then runs half round it. Samples where that has run by at most 0.2 rad, or every 1 ms. With `slaps` it goes
// no further than where it leans least, and stays there from t = 0 on.
Motion rocking_disk(const Body& body, double rate_rad_s, double least_tilt_rad, bool slaps = false);

// A box that tips over one of its edges from a tilt, pivoting without slip, lands flat at once (one impact)
// and stays: poses known at 1 ms steps and interpolated between them as exporters do, linearly and by slerp.
Motion tipping_box(const Body& body);

// A box that slides and yaws to a stop and stays.
Motion sliding_box(const Body& body);

// The times of the impacts above the audible speed as marks, chained by 10 ms.
MarkSet marks_of(const Motion& motion, bool rest);

// Scales the time of everything between two impacts, `ratio`s being those of the transitions to each impact.
void retime(Motion* motion, const std::vector<double>& ratio);

}  // namespace ifa::verify::test
