// Sustained contact of a pack of bodies: one step with the touching points held on the ground, landings
// within it, and coming to rest.
#pragma once

#include "ifa/rigid/lanes/impact.hpp"
#include "ifa/rigid/lanes/rare.hpp"

namespace ifa::IFA_LANES_NAMESPACE {

using lanes::Settings;
using lanes::Stage;
using lanes::Stop;

class ContactStep {
 public:
  ContactStep(const BodyView& body, const Settings& settings, Sim* const* sims, int count)
      : body_(body),
        settings_(settings),
        sims_(sims),
        count_(count),
        lanes_(first_lanes(count)),
        start_(load(sims, count)),
        turned_(rotation(start_.orientation)),
        points_(body, turned_.up()),
        rolled_(body, turned_.up()) {
    gravity_ = broadcast(settings.gravity);
    touch_ = broadcast(kTouchShare * body.bounding_radius);
  }

  void run(Stop* stops, lanes::LoadData* loads);

 private:
  Pack slowness(const Motion& m) const { return norm(m.velocity) + body_.bounding_radius * norm(m.spin); }
  Pack energy(const Motion& m, const Rotation& r) const {
    return kinetic_energy(body_, m.velocity, r.inverse(m.spin)) - body_.mass * dot(gravity_, m.position);
  }
  Pack choose_length(Pack time_s, Pack until_s);
  Pack follow_rings(Pack length);
  void roll(const Rotation& r) {
    if (rings(body_) > 0) rolled_.place_rings(select(rolls_, r.up(), turned_.up()));
  }
  void add_settling_points(Pack length);
  Pack3 last_force(int slot) const;
  Pack3 last_torque() const;
  Pack3 last_spin_rate() const;
  Pack3 moment_of_run(const Rotation& r) const;
  void solve(Pack length);
  void hold(Mask where, const int* point_of_lane);
  Motion part_way(Pack share) const;
  Pack lowest_newcomer(const Motion& m, const Rotation& r, int* point_of_lane);
  Mask land(Pack& length, Motion& m, int* newcomer);
  void project(Motion& m, Mask landing, const int* newcomer);
  void hold_on_ground(Motion& m, Mask where);
  void keep_bearing(Motion& m, Mask where);
  void limit_energy(Motion& m) const;
  void keep_forces(Pack length);

  const BodyView& body_;
  const Settings& settings_;
  Sim* const* sims_;
  int count_;
  Mask lanes_, active_;
  Motion start_, end_;  // of the whole step
  Rotation turned_;     // at the start
  Points points_;       // of the start
  // A circular edge rolls: its points are those of the pose looked at. Except where it lies so flat that its
  // lowest point may be anywhere: there it is the polygon of the start.
  Points rolled_;
  Mask rolls_;
  Pack3 gravity_;
  Pack touch_, whole_;  // whole_: length of the step
  Mask settling_;
  Bearing bearing_;
  ContactSlot slot_[kSlots];
  int slots_ = 0;
  // Points held on the ground by the projection; further ones join there.
  static constexpr int kMostHeld = kSlots + 16;
  Mask loads_[kSlots];  // of the first ones: bore load in the step
  int held_point_[kMostHeld][kWidth] = {};
  int held_count_[kWidth];
  Pack3 torque_;  // angular impulse of rolling and spin friction
  Pack normal_impulse_, slip_speed_, loaded_;
};

}  // namespace ifa::IFA_LANES_NAMESPACE
