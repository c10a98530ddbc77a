// One step of sustained contact: its length, its forces, landings within it, and coming to rest.
#pragma once

#include "ifa/rigid/lanes/contact_step.hpp"
#include "ifa/rigid/lanes/step_hold.hpp"
#include "ifa/rigid/lanes/step_rings.hpp"

namespace ifa::IFA_LANES_NAMESPACE {

// A step turns the body by 0.02 rad, but lasts no less than `step_s` and no more than four times that; none
// turns it by more than 0.05 rad. Flat on three points or more and without tumbling, a slide's forces are
// constant, so that a step may be sixteen times as long, and ends where the slide does.
inline Pack ContactStep::choose_length(Pack time_s, Pack until_s) {
  constexpr double kTurn = 0.02, kLargestTurn = 0.05;
  constexpr double kShortestStop = 0.25;
  // A circular edge that is nearly flat wobbles: whole steps only.
  const double most_steps = rings(body_) > 0 ? 1.0 : 4.0, most_flat_steps = rings(body_) > 0 ? 1.0 : 16.0;
  const Pack step = broadcast(settings_.step_s), zero = broadcast(0.0);
  const Pack spin = norm(start_.spin);
  Pack length =
      select(spin * (most_steps * step) > broadcast(kTurn), greatest(kTurn / spin, step), most_steps * step);
  if (body_.friction > 0.0 && settings_.gravity[2] < 0.0) {
    const Pack still = broadcast(0.1 * (settings_.rest_speed + settings_.step_speed));
    Mask flat = none();
    for (int l = 0; l < kWidth; ++l) set(flat, l, bearing_.count[l] >= 3);
    const Pack tumbling = root(start_.spin.x * start_.spin.x + start_.spin.y * start_.spin.y);
    flat = flat & (body_.bounding_radius * tumbling <= still) & (magnitude(start_.velocity.z) <= still);
    const Pack slide = root(start_.velocity.x * start_.velocity.x + start_.velocity.y * start_.velocity.y) +
                       body_.bounding_radius * magnitude(start_.spin.z);
    const Pack stop = slide * (1.0 / (-settings_.gravity[2] * body_.friction));
    length = select(flat, clamp(stop, kShortestStop * step, most_flat_steps * step), length);
  }
  length = select(settling_, step, length);
  length = least(length, until_s - time_s);
  length = select(length * spin > broadcast(kLargestTurn),
                  kLargestTurn / select(spin > zero, spin, broadcast(1.0)), length);
  if (rings(body_) == 0) return length;
  length = follow_rings(length);
  // Not a long step and then the shred that is left: it would undo the long one's error at a blow.
  const Pack left = until_s - time_s;
  return select((length < left) & (left < 2.0 * length), 0.5 * left, length);
}

// Points just above the ground may come down to it within the step, and no further: a rim settles as a whole,
// where point after point would cut it into landings without end.
inline void ContactStep::add_settling_points(Pack length) {
  const double g = __builtin_sqrt(settings_.gravity[0] * settings_.gravity[0] +
                                  settings_.gravity[1] * settings_.gravity[1] +
                                  settings_.gravity[2] * settings_.gravity[2]);
  const Pack reach = 2.0 * length * (settings_.rest_speed + g * length);
  const Pack3 up = turned_.up();
  const Pack z = start_.position.z - body_.rounding;
  Spread spread[kWidth];
  int found[kWidth] = {};
  for (int k = 0; k < points_.count(); ++k) {
    const Pack3 p = points_.at(k);
    const Pack h = z + dot(up, p);
    const unsigned low = bits(settling_ & (h > touch_) & (h <= reach));
    if (!low) continue;
    const Pack3 arm = turned_.apply(p);
    for (unsigned b = low; b; b &= b - 1) {
      const int l = __builtin_ctz(b);
      if (found[l] < kMostSettling) bearing_.point[bearing_.count[l] + found[l]][l] = k;
      ++found[l];
      spread[l].consider(k, get(arm.x, l), get(arm.y, l), 0.0);
    }
  }
  for (int l = 0; l < kWidth; ++l) {
    if (found[l] > kMostSettling) {
      int chosen[9];
      found[l] = spread[l].take(chosen, kMostSettling);
      for (int i = 0; i < found[l]; ++i) bearing_.point[bearing_.count[l] + i][l] = chosen[i];
    }
    bearing_.all[l] = bearing_.count[l] + found[l];
  }
}

// Velocities at the end of a step with the touching points held above the ground. Forces are evaluated at the
// predicted pose, so that a pivot's centripetal force turns with it.
inline void ContactStep::solve(Pack length) {
  // Of what gravity adds in a step: of the contact problem.
  constexpr double kTolerance = 1e-4, kRingTolerance = 1e-8;
  constexpr int kMostSweeps = 60, kMostRingSweeps = 1000;
  const Pack zero = broadcast(0.0);
  end_ = start_;
  Pack3 turn = length * start_.spin;
  if (rings(body_) > 0)
    turn = select(rolls_, length * (start_.spin + (0.5 * length) * last_spin_rate()), turn);
  const Rotation r = rotation(normalized(rotation_exp(turn) * start_.orientation));
  const ContactBodies problem{broadcast(1.0 / body_.mass), inverse_inertia(body_, r), body_.friction,
                              body_.rolling_friction_m,    body_.spin_friction_m,     body_.cone};
  end_.velocity = start_.velocity + length * gravity_;
  if (couples_spin(body_)) {  // the angular momentum stays, the inertia turns
    count(Effect::spin_coupling, active_);
    const Pack3 spin = turned_.inverse(start_.spin);
    end_.spin = problem.inverse_inertia.apply(
        turned_.apply({body_.inertia[0] * spin.x, body_.inertia[1] * spin.y, body_.inertia[2] * spin.z}));
  }
  if (any(settling_)) add_settling_points(length);
  roll(r);
  slots_ = make_slots(body_, rolled_, bearing_, r, slot_);
  const Pack3 up = turned_.up();
  const Pack z = start_.position.z - body_.rounding;
  torque_ = length * last_torque();
  for (int i = 0; i < slots_; ++i) {
    ContactSlot& p = slot_[i];
    p.impulse = length * last_force(i);
    const Mask above = p.valid & negated(bearing_.touches(i));
    if (any(above)) {
      const Pack h = z + dot(up, rolled_.at(bearing_.point[i]));
      p.target = select(above, -h / length, p.target);
    }
  }
  const Pack3 free_velocity = end_.velocity;
  const Pack3 free_spin = end_.spin;
  if (rings(body_) > 0) end_.spin = free_spin - problem.inverse_inertia.apply(moment_of_run(r));
  // A coin's two edges are so near to each other that the sweeps converge slowly: it would rock.
  const int most_sweeps = rings(body_) > 0 ? kMostRingSweeps : kMostSweeps;
  const Pack tolerance = broadcast((rings(body_) > 0 ? kRingTolerance : kTolerance) * settings_.step_speed);
  solve_contacts(problem, slot_, slots_, active_, tolerance, most_sweeps, end_.velocity, end_.spin, torque_);
  Mask fresh = none();  // without a last step, whose forces would have told that moment
  for (int l = 0; rings(body_) > 0 && l < count_; ++l)
    set(fresh, l, get_bit(active_ & rolls_, l) && sims_[l]->bearing == 0);
  if (any(fresh)) {
    end_.velocity = select(fresh, free_velocity, end_.velocity);
    end_.spin = select(fresh, free_spin - problem.inverse_inertia.apply(moment_of_run(r)), end_.spin);
    solve_contacts(problem, slot_, slots_, fresh, tolerance, most_sweeps, end_.velocity, end_.spin, torque_);
  }
  // Contact takes energy. Where moments differ by 1e9 and more, the points' matrices are too near to singular
  // for the sweeps: they may diverge. Then without friction, which has an exact solution. The step's own
  // error adds energy where an edge rolls (less than 1 % seen): that is for limit_energy.
  const Pack before = kinetic_energy(body_, free_velocity, r.inverse(free_spin));
  const Pack after = kinetic_energy(body_, end_.velocity, r.inverse(end_.spin));
  const double most_gain = rings(body_) > 0 ? 1e-2 : 1e-6;
  const Mask lost = active_ & negated(after <= before * (1.0 + most_gain));
  if (any(lost)) {
    end_.velocity = select(lost, free_velocity, end_.velocity);
    end_.spin = select(lost, free_spin, end_.spin);
    torque_ = select(lost, broadcast(0.0, 0.0, 0.0), torque_);
    for (int i = 0; i < slots_; ++i)
      slot_[i].impulse = select(lost, broadcast(0.0, 0.0, 0.0), slot_[i].impulse);
    solve_smooth(problem, slot_, slots_, lost, end_.velocity, end_.spin);
  }
  normal_impulse_ = slip_speed_ = loaded_ = zero;
  for (int l = 0; l < kWidth; ++l) held_count_[l] = 0;
  for (int i = 0; i < slots_; ++i) {
    const ContactSlot& p = slot_[i];
    const Pack3 v = end_.velocity + cross(end_.spin, p.arm);
    const Mask pushes = p.valid & (p.impulse.z > zero);
    normal_impulse_ = normal_impulse_ + select(pushes, p.impulse.z, zero);
    slip_speed_ = select(pushes, greatest(slip_speed_, root(v.x * v.x + v.y * v.y)), slip_speed_);
    loaded_ = loaded_ + select(pushes, broadcast(1.0), zero);
    loads_[i] = pushes;
    hold(p.valid & bearing_.touches(i) & (pushes | (v.z <= broadcast(1e-5 * settings_.step_speed))),
         bearing_.point[i]);
  }
}

// The motion a share of the step after its start. Positions advance by the mean velocity, exact for constant
// forces; what settles stops exactly on the ground only if it moves by the velocity that the constraint
// bounds.
inline Motion ContactStep::part_way(Pack share) const {
  const Pack length = share * whole_;
  const Pack3 dv = share * (end_.velocity - start_.velocity), dw = share * (end_.spin - start_.spin);
  const Pack weight = select(settling_, broadcast(1.0), broadcast(0.5));
  Motion m;
  m.velocity = start_.velocity + dv;
  m.spin = start_.spin + dw;
  m.position = start_.position + length * (start_.velocity + weight * dv);
  m.orientation = normalized(rotation_exp(length * (start_.spin + weight * dw)) * start_.orientation);
  return m;
}

// Height of the lowest point that did not touch at the start.
inline Pack ContactStep::lowest_newcomer(const Motion& m, const Rotation& r, int* point_of_lane) {
  roll(r);
  const Pack3 up0 = turned_.up(), up = r.up();
  const Pack z0 = start_.position.z - body_.rounding, z = m.position.z - body_.rounding;
  Pack lowest = broadcast(1e100), which = broadcast(0.0);
  for (int k = 0; k < points_.count(); ++k) {
    const Pack h = z + dot(up, rolled_.at(k));
    const Mask lower = (z0 + dot(up0, points_.at(k)) > touch_) & (h < lowest);
    lowest = select(lower, h, lowest);
    which = select(lower, broadcast(k), which);
  }
  for (int l = 0; l < kWidth; ++l) point_of_lane[l] = static_cast<int>(get(which, l));
  return lowest;
}

// Where a point lands within the step, ends the step as it touches (regula falsi, Illinois): the part of the
// step before has the same forces. Returns where that is so.
inline Mask ContactStep::land(Pack& length, Motion& m, int* newcomer) {
  constexpr double kLanded = 1e-9;  // of the size; the projection closes the rest
  const Pack high_height = lowest_newcomer(m, rotation(m.orientation), newcomer);
  // What settles is brought down by the contact problem itself; and a circular edge that wobbles lands softly
  // ever so often, which the projection absorbs.
  Mask hard = active_ & (high_height < broadcast(0.0)) & negated(settling_);
  if (rings(body_) > 0 && any(hard)) {
    const Pack speed = -normal_velocity(m, rotation(m.orientation).apply(rolled_.at(newcomer)));
    hard = hard & (speed >= broadcast(settings_.micro_speed));
  }
  if (!any(hard)) return none();
  const Pack one = broadcast(1.0), zero = broadcast(0.0);
  Pack low = zero, high = one, h_high = high_height, moved = zero, share = one, height = high_height;
  int ignored[kWidth];
  Pack h_low = greatest(lowest_newcomer(start_, turned_, ignored), 0.1 * touch_);
  const Pack landed = broadcast(kLanded * body_.bounding_radius);
  Mask searching = hard;
  for (int i = 0; i < 60 && any(searching); ++i) {
    const Pack next = clamp((low * h_high - high * h_low) / (h_high - h_low), low, high);
    share = select(searching, next, share);
    const Motion there = part_way(share);
    const Rotation turn = rotation(there.orientation);
    int lowest[kWidth];
    const Pack h = lowest_newcomer(there, turn, lowest);
    for (unsigned b = bits(searching); b; b &= b - 1) newcomer[__builtin_ctz(b)] = lowest[__builtin_ctz(b)];
    height = select(searching, h, height);
    const Mask under = searching & (h < zero), over = searching & negated(h < zero);
    h_low = select(under & (moved > zero), 0.5 * h_low, h_low);
    h_high = select(over & (moved < zero), 0.5 * h_high, h_high);
    high = select(under, share, high);
    h_high = select(under, h, h_high);
    low = select(over, share, low);
    h_low = select(over, h, h_low);
    moved = select(under, one, select(over, -one, moved));
    searching = searching & (magnitude(height) > landed) & (high - low > broadcast(1e-15));
  }
  m = select(hard, part_way(share), m);
  length = select(hard, share * length, length);
  return hard;
}

inline void ContactStep::keep_forces(Pack length) {
  for (int l = 0; l < count_; ++l) {
    if (!(bits(active_) >> l & 1u)) continue;
    Sim& s = *sims_[l];
    const double inverse = 1.0 / get(length, l);
    s.bearing = bearing_.all[l];
    s.torque[0] = inverse * get(torque_.x, l), s.torque[1] = inverse * get(torque_.y, l);
    s.torque[2] = inverse * get(torque_.z, l);
    for (int i = 0; i < s.bearing; ++i) {
      s.point[i] = bearing_.point[i][l];
      s.force[i][0] = inverse * get(slot_[i].impulse.x, l);
      s.force[i][1] = inverse * get(slot_[i].impulse.y, l);
      s.force[i][2] = inverse * get(slot_[i].impulse.z, l);
    }
  }
}

inline void ContactStep::run(Stop* stops, lanes::LoadData* loads) {
  Pack time{}, until{};
  for (int l = 0; l < kWidth; ++l) {
    set(time, l, sims_[l < count_ ? l : 0]->time_s);
    set(until, l, sims_[l < count_ ? l : 0]->until_s);
    if (l < count_) stops[l] = Stop::none;
  }
  active_ = lanes_ & (time < until);
  count(Effect::sustained_contact, active_);
  bearing_ = touching_points(body_, points_, start_, turned_, active_);
  for (int l = 0; l < count_; ++l) {
    if (!(get_bit(active_, l))) {
      stops[l] = Stop::time_limit;
    } else if (bearing_.count[l] == 0) {  // nothing holds it any more
      set(active_, l, false);
      sims_[l]->stage = Stage::flight;
      sims_[l]->slow = 0;
    }
  }
  if (!any(active_)) return;
  rolls_ = active_;
  settling_ = active_ & (slowness(start_) < broadcast(settings_.rest_speed));
  whole_ = choose_length(time, until);
  solve(whole_);
  const Mask solved = active_;
  Motion m = part_way(broadcast(1.0));
  Pack length = whole_;
  int newcomer[kWidth];
  const Mask landing = land(length, m, newcomer);
  keep_forces(whole_);
  project(m, landing, newcomer);
  if (any(landing)) keep_bearing(m, landing);
  limit_energy(m);

  const Rotation r = rotation(m.orientation);
  const Pack approach = approach_speed(body_, Points(body_, r.up()), m, r);
  // What is as slow as that for so long creeps: nothing that balances unstably stays slow for a second.
  constexpr double kLongestCreep = 20.0;
  const Pack speed_before = slowness(start_), speed = slowness(m);
  for (int l = 0; l < count_; ++l) {
    if (!get_bit(solved, l)) continue;
    Sim& s = *sims_[l];
    const double part = get(length, l) / get(whole_, l);
    if (loads) loads[l] = {s.time_s, get(length, l), part * get(normal_impulse_, l), get(slip_speed_, l)};
    const double begin_s = s.time_s;
    s.touching = bearing_.count[l] + (get_bit(landing, l) ? 1 : 0);
    s.time_s += get(length, l);
    if (get_bit(landing, l)) {
      s.slow = s.slow && get(approach, l) < settings_.rest_speed;
      if (get(approach, l) > 0.0) stops[l] = Stop::impact;
      continue;
    }
    // The projection may bring down a point that was just above the ground, and came fast.
    if (get(approach, l) > settings_.micro_speed && get(approach, l) > settings_.step_speed) {
      s.slow = s.still_steps = 0;
      stops[l] = Stop::impact;
      continue;
    }
    if (get(speed, l) >= settings_.rest_speed || get(loaded_, l) == 0.0) {
      s.slow = s.still_steps = 0;
      continue;
    }
    if (!s.slow) {  // since when, by the straight line between the speeds at the ends of the step
      s.slow = 1;
      const double fast = get(speed_before, l), slow = get(speed, l);
      const double share = fast > settings_.rest_speed ? (fast - settings_.rest_speed) / (fast - slow) : 0.0;
      s.slow_since_s = begin_s + share * get(length, l);
    }
    // On three points, or on one round one, standing still is for good: no need to watch it.
    const bool stable = get(loaded_, l) >= 3.0 || (body_.vertices == 1 && rings(body_) == 0);
    s.still_steps = stable && get(speed, l) < 1e-3 * settings_.rest_speed ? s.still_steps + 1 : 0;
    const double slow_s = s.time_s - s.slow_since_s;
    bool rests = slow_s >= kLongestCreep * settings_.rest_duration_s;
    if (!rests && (s.still_steps >= 3 || slow_s >= settings_.rest_duration_s)) {
      double arm[2 * kMostBearing];
      for (int i = 0; i < bearing_.count[l]; ++i) {
        arm[2 * i] = get(slot_[i].arm.x, l);
        arm[2 * i + 1] = get(slot_[i].arm.y, l);
      }
      rests = lanes::supports(arm, bearing_.count[l], 1e-3 * body_.bounding_radius, body_.rolling_friction_m);
    }
    if (!rests) continue;
    stops[l] = Stop::rest;
    s.stage = Stage::rest;
    set(m.velocity.x, l, 0.0), set(m.velocity.y, l, 0.0), set(m.velocity.z, l, 0.0);
    set(m.spin.x, l, 0.0), set(m.spin.y, l, 0.0), set(m.spin.z, l, 0.0);
  }
  store(select(solved, m, start_), sims_, count_);
}

}  // namespace ifa::IFA_LANES_NAMESPACE
