// The end of a contact step: bearing points are put back on the ground, and no energy is gained.
#pragma once

#include "ifa/rigid/lanes/contact_step.hpp"

namespace ifa::IFA_LANES_NAMESPACE {

inline void ContactStep::hold(Mask where, const int* point_of_lane) {
  for (unsigned b = bits(where); b; b &= b - 1) {
    const int l = __builtin_ctz(b);
    held_point_[held_count_[l]++][l] = point_of_lane[l];
  }
}

// Moves the pose so that held points are on the ground and none is below: the least change in the metric of a
// ball as large as the body, by Gauss-Seidel. Undoes the step's second-order drift. (The metric of the mass
// matrix turns a needle, whose moments may differ by 1e12, wildly about its axis.)
inline void ContactStep::project(Motion& m, Mask landing, const int* newcomer) {
  hold(landing, newcomer);
  // Holding some points may push others below the ground: those are then held too.
  Mask open = active_;
  for (int round = 0; round < 4 && any(open); ++round) {
    hold_on_ground(m, open);
    const Rotation r = rotation(m.orientation);
    roll(r);
    const Pack3 up = r.up();
    const Pack z = m.position.z - body_.rounding;
    Pack lowest = broadcast(0.0);
    Mask more = none();
    for (int k = 0; k < points_.count(); ++k) {
      const Pack h = z + dot(up, rolled_.at(k));
      lowest = least(lowest, h);
      const Mask deep = open & (h < -touch_);
      if (round == 3 || !any(deep)) continue;
      for (unsigned b = bits(deep); b; b &= b - 1) {
        const int l = __builtin_ctz(b);
        bool held = held_count_[l] == kMostHeld;
        for (int i = 0; i < held_count_[l]; ++i) held = held || held_point_[i][l] == k;
        if (held) continue;
        held_point_[held_count_[l]++][l] = k;
        set(more, l, true);
      }
    }
    const Mask done = open & negated(more);
    m.position.z = select(done, m.position.z - lowest, m.position.z);
    open = more;
  }
  if (rings(body_) == 0) return;
  // Where a flat edge was taken for a polygon, its arc is still below.
  const Pack3 up = rotation(m.orientation).up();
  const Pack z = m.position.z - body_.rounding;
  rolled_.place_rings(up);
  Pack lowest = broadcast(0.0);
  for (int k = 0; k < rings(body_); ++k)
    lowest = least(lowest, z + dot(up, rolled_.at(body_.vertices + kRingPoints * k)));
  m.position.z = select(active_, m.position.z - lowest, m.position.z);
}

inline void ContactStep::hold_on_ground(Motion& m, Mask where) {
  const Pack zero = broadcast(0.0);
  const double inverse_size2 = 1.0 / (body_.bounding_radius * body_.bounding_radius);
  int helds = 0;
  for (int l = 0; l < kWidth; ++l) helds = held_count_[l] > helds ? held_count_[l] : helds;
  const auto is_held = [&](int i) {
    Mask lanes = none();
    for (int l = 0; l < kWidth; ++l) set(lanes, l, i < held_count_[l]);
    return lanes;
  };
  Mask open = where;
  for (int round = 0; round < 3 && any(open); ++round) {
    const Rotation r = rotation(m.orientation);
    roll(r);
    const Pack z = m.position.z - body_.rounding;
    Pack3 lever[kMostHeld], response[kMostHeld];  // arm x up, and the turn for a unit push
    Pack height[kMostHeld], give[kMostHeld];
    Mask held[kMostHeld];
    Pack worst = zero, rise = zero;
    Pack3 turn = broadcast(0.0, 0.0, 0.0);
    for (int i = 0; i < helds; ++i) {
      held[i] = is_held(i);
      const Pack3 p = r.apply(rolled_.at(held_point_[i]));
      lever[i] = {p.y, -p.x, zero};
      response[i] = inverse_size2 * lever[i];
      height[i] = z + p.z;
      give[i] = 1.0 / (1.0 + dot(lever[i], response[i]));
      worst = select(held[i], greatest(worst, magnitude(height[i])), worst);
    }
    open = open & (worst > 0.1 * touch_);
    if (!any(open)) return;
    Mask sweeping = open;
    for (int sweep = 0; sweep < 30 && any(sweeping); ++sweep) {
      Pack change = zero;
      for (int i = 0; i < helds; ++i) {
        const Mask here = sweeping & held[i];
        if (!any(here)) continue;
        const Pack h = height[i] + rise + dot(turn, lever[i]);
        const Pack push = -h * give[i];
        rise = select(here, rise + push, rise);
        turn = select(here, turn + push * response[i], turn);
        change = select(here, greatest(change, magnitude(h)), change);
      }
      sweeping = sweeping & (change > 0.05 * touch_);
    }
    m.position.z = select(open, m.position.z + rise, m.position.z);
    m.orientation = select(open, normalized(rotation_exp(turn) * m.orientation), m.orientation);
  }
}

// Within a step the velocities are those between two poses, so that points that bore load through it move a
// little off the ground or into it. At a landing these are stopped, the least change in the metric of the
// mass matrix: else what they lack would count as their part in the impact.
inline void ContactStep::keep_bearing(Motion& m, Mask where) {
  const double inverse_mass = 1.0 / body_.mass;
  const Rotation r = rotation(m.orientation);
  roll(r);
  const Symmetric w = inverse_inertia(body_, r);
  Mask open = where;
  for (int sweep = 0; sweep < 30 && any(open); ++sweep) {
    Pack change = broadcast(0.0);
    for (int i = 0; i < slots_; ++i) {
      const Mask here = open & loads_[i];
      if (!any(here)) continue;
      const Pack3 arm = r.apply(rolled_.at(bearing_.point[i]));
      const Pack3 lever{arm.y, -arm.x, broadcast(0.0)};
      const Pack3 response = w.apply(lever);
      const Pack speed = normal_velocity(m, arm);
      const Pack push = -speed / (inverse_mass + dot(lever, response));
      m.velocity.z = select(here, m.velocity.z + inverse_mass * push, m.velocity.z);
      m.spin = select(here, m.spin + push * response, m.spin);
      change = select(here, greatest(change, magnitude(speed)), change);
    }
    open = open & (change > broadcast(1e-9 * settings_.step_speed));
  }
}

// Sustained contact never adds energy: what the step's error added is taken from the velocities.
inline void ContactStep::limit_energy(Motion& m) const {
  const Rotation r = rotation(m.orientation);
  const Pack kinetic = kinetic_energy(body_, m.velocity, r.inverse(m.spin));
  // A constant spin has at each pose another energy: that is the coupling left out, no gain of the contact.
  const Rotation& of_spin = couples_spin(body_) || body_.isotropic ? turned_ : r;
  const Pack allowed = energy(start_, of_spin) + body_.mass * dot(gravity_, m.position);
  const Mask gained = active_ & (kinetic > allowed);
  if (!any(gained)) return;
  const Pack scale = root(positive(allowed / kinetic));
  m.velocity = select(gained, scale * m.velocity, m.velocity);
  m.spin = select(gained, scale * m.spin, m.spin);
}

}  // namespace ifa::IFA_LANES_NAMESPACE
