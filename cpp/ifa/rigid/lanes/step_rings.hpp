// Circular edges in a contact step: the lowest point runs around them while the body turns.
#pragma once

#include "ifa/rigid/lanes/contact_step.hpp"

namespace ifa::IFA_LANES_NAMESPACE {

// A nearly flat disk turns slowly while its lowest point runs around it.
inline Pack ContactStep::follow_rings(Pack length) {
  constexpr double kLongestRun = 0.2, kStillFollowed = 0.5;  // rad in one step
  constexpr double kMostClosing = 0.25;  // of the steepness in one step: the flatter, the faster the run
  constexpr double kSag = 3.125e-4;  // of the radius: of the chord that drawing between two steps would cut
  constexpr double kFlat = 1e-5;     // rad
  constexpr double kShortest = 1.0 / 128.0;  // of step_s
  const Pack3 up = turned_.up();
  const Pack3 rate = cross(up, turned_.inverse(start_.spin));
  Pack fastest = broadcast(0.0), followed = broadcast(1e300);
  for (int k = 0; k < rings(body_); ++k) {
    const Pack3 axis = broadcast(body_.ring[k].axis);
    const Pack z = start_.position.z - body_.rounding;
    const Pack3 lowest = points_.at(body_.vertices + kRingPoints * k);
    const Pack3 across = up - dot(up, axis) * axis;
    const Pack square = dot(across, across);
    const Mask touches = z + dot(up, lowest) <= touch_, flat = square <= broadcast(kFlat * kFlat);
    rolls_ = rolls_ & negated(touches & flat);
    const Pack whole = select(flat, broadcast(1.0), square);
    const Pack run = magnitude(dot(axis, cross(across, rate))) / whole;
    const Pack closing = -dot(across, rate) / whole;  // relative rate of the steepness
    const Pack longest = root(8.0 * kSag / root(select(flat, broadcast(1.0), square)));
    const Pack follow = least(least(broadcast(kLongestRun), longest) / greatest(run, broadcast(1e-300)),
                              kMostClosing / greatest(closing, broadcast(1e-300)));
    const Mask runs = touches & negated(flat);
    followed = select(runs, least(followed, follow), followed);
    fastest = select(runs, greatest(fastest, run), fastest);
  }
  const Pack shortest = least(length, broadcast(kShortest * settings_.step_s));
  length = select(settling_, length, least(length, greatest(followed, shortest)));
  rolls_ = rolls_ & (length * fastest <= broadcast(kStillFollowed));
  return length;
}

// The force of the last step on a touching point.
inline Pack3 ContactStep::last_force(int slot) const {
  Pack3 force = broadcast(0.0, 0.0, 0.0);
  for (int l = 0; l < count_; ++l) {
    if (slot >= bearing_.count[l]) continue;
    const Sim& s = *sims_[l];
    for (int k = 0; k < s.bearing; ++k) {
      if (s.point[k] != bearing_.point[slot][l]) continue;
      set(force.x, l, s.force[k][0]), set(force.y, l, s.force[k][1]), set(force.z, l, s.force[k][2]);
    }
  }
  return force;
}

inline Pack3 ContactStep::last_torque() const {
  Pack3 torque = broadcast(0.0, 0.0, 0.0);
  for (int l = 0; l < count_; ++l) {
    const Sim& s = *sims_[l];
    if (s.bearing > 0)
      set(torque.x, l, s.torque[0]), set(torque.y, l, s.torque[1]), set(torque.z, l, s.torque[2]);
  }
  return torque;
}

// By Euler's equations with the forces of the last step.
inline Pack3 ContactStep::last_spin_rate() const {
  Pack3 moment = last_torque();
  if (couples_spin(body_)) {
    const Pack3 spin = turned_.inverse(start_.spin);
    const Pack3 momentum =
        turned_.apply({body_.inertia[0] * spin.x, body_.inertia[1] * spin.y, body_.inertia[2] * spin.z});
    moment = moment - cross(start_.spin, momentum);
  }
  for (int i = 0; i < bearing_.most(); ++i) {
    Pack3 arm = turned_.apply(points_.at(bearing_.point[i]));
    arm.z = arm.z - body_.rounding;
    moment = moment + cross(arm, last_force(i));
  }
  return inverse_inertia(body_, turned_).apply(moment);
}

// The force of a point that runs along a circular edge acts, on average, in the middle of its run: what its
// moment about the end of it is too much.
inline Pack3 ContactStep::moment_of_run(const Rotation& r) const {
  Pack3 moment = broadcast(0.0, 0.0, 0.0);
  for (int i = 0; i < slots_; ++i) {
    Mask runs = rolls_ & slot_[i].valid;
    for (int l = 0; l < kWidth; ++l) {
      const int edge = bearing_.point[i][l] - body_.vertices;
      set(runs, l, get_bit(runs, l) && edge >= 0 && edge % kRingPoints == 0);
    }
    if (!any(runs)) continue;
    const Pack3 run = r.apply(rolled_.at(bearing_.point[i])) - turned_.apply(points_.at(bearing_.point[i]));
    moment = select(runs, moment + cross(0.5 * run, slot_[i].impulse), moment);
  }
  return moment;
}

}  // namespace ifa::IFA_LANES_NAMESPACE
