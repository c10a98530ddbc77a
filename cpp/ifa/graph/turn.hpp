// Torque-free turns, and how they change with the spin that they begin with.
#pragma once

#include "ifa/base/linear_algebra.hpp"
#include "ifa/rigid/lanes/sim.hpp"

namespace ifa {

// Euler's equations know no unit of time. Here a flight takes 1, so that a spin is an angle, rad (rad/s times
// the flight's duration): what is easy or hard does not depend on the duration, and no number is far from 1.
// Principal axes, those at the start or at the end of the flight.
struct Turn {
  Quat rotation = Quat::Identity();  // R(0)^T R(1)
  Vec3 spin_rad = Vec3::Zero();      // at the end
  // By how much the end turns, in its axes, for each component of the spin at the start.
  Mat3 slope = Mat3::Zero();
};

// Exact to rounding: a closed form where all moments or two are equal, else power series
// (lanes/rotation.hpp). The slope is exact likewise, but for one or two directions of a body of the second
// kind, forward differences good to about 1e-7.
Turn turn_with_slope(const lanes::BodyView& body, const Vec3& spin_rad);

// Without the slope.
Turn turn_of(const lanes::BodyView& body, const Vec3& spin_rad);

}  // namespace ifa
