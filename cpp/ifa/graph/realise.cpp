#include "ifa/graph/realise.hpp"

#include <cmath>

#include "ifa/graph/replay.hpp"
#include "ifa/graph/transplant.hpp"
#include "ifa/rigid/contact.hpp"
#include "ifa/signature/factors.hpp"

namespace ifa {
namespace {

constexpr double kOnTime_s = 1e-7;  // of a connection's end, as simulated: far below what marks resolve
constexpr double kDepth_m =
    1e-6;  // of a connection below the ground; the motion is measured again in the end
constexpr double kLateShare = 1.5,
                 kLate_s = 0.1;  // how long an edge is followed: so much of its target, and more

PlausibleRegion region_between(const Body& body, const State& before, const State& after) {
  return {after.velocity - before.velocity, after.angular_velocity - before.angular_velocity,
          body.bounding_radius_m()};
}

double excess_of(const PlausibleRegion& region, const State& changed, const State& from) {
  return region.excess(changed.velocity - from.velocity, changed.angular_velocity - from.angular_velocity);
}

}  // namespace

// Goes along one path.
class Realiser::Walk {
 public:
  Walk(const Realiser& with, const GraphPath& path, const Targets& targets)
      : with_(with),
        body_(with.database_.body()),
        physics_(with.physics_),
        nodes_(with.database_.nodes()),
        path_(path),
        targets_(targets),
        onset_(replay_onset(with.database_, path.steps[0].node)) {}

  Realised go() {
    const std::size_t steps = path_.steps.size();
    for (k_ = 0; k_ < steps; ++k_) {
      begin();
      const bool going = k_ + 1 == steps ? end() : path_.steps[k_ + 1].spliced ? splice() : follow();
      if (!going) {
        out_.failed_step = std::min(k_ + 1, steps - 1);
        break;
      }
      out_.found.links.push_back(link_);
    }
    out_.found.complete = !out_.failed_step && steps == targets_.size();
    return std::move(out_);
  }

 private:
  bool fail(const char* reason) {
    out_.reason = reason;
    return false;
  }

  // The event as physics has it for the body as it arrives, and as the node's own simulation has it.
  void begin() {
    link_ = {onset_, {onset_.after, 0.0, 0.0}};
    own_ = placed_.of(onset_of(nodes_, path_.steps[k_].node));
    own_.position = onset_.after.position;
    own_.orientation = onset_.after.orientation;
    untouched_ = state_difference(body_, own_, onset_.after) < kReplayTolerance;
  }

  bool gains(const State& after, const State& before) const {
    return kinetic_energy(body_, after) > kinetic_energy(body_, before) + physics_.energy_gain_j;
  }

  bool leave(const State& after) {
    link_.leave.after = after;
    link_.leave.excess = excess_of(region_between(body_, onset_.before, onset_.after), after, onset_.after);
    return !gains(after, onset_.before) || fail("it would gain energy");
  }

  bool leave_as_own() { return untouched_ || leave(own_); }

  Passage pass(Record& record) const {
    const double limit_s = kLateShare * targets_.intervals_s[k_] + kLate_s;
    return record_passage(body_, physics_, {onset_.hit, link_.leave.after, targets_.durations_s[k_], limit_s},
                          record);
  }

  bool end() { return !targets_.rest || k_ + 1 < targets_.size() || leave_as_own(); }

  bool follow() {
    if (!leave_as_own()) return false;
    Record record;
    const Passage passage = pass(record);
    if (passage.next != Next::hit) return fail("it does not lead to the next event");
    link_.leave.interval_s = passage.interval_s;
    onset_ = strike(body_, physics_, passage.end);
    return true;
  }

  bool splice() {
    const Vec3& gravity = physics_.simulation.gravity_m_s2;
    const Step& next = path_.steps[k_ + 1];
    // Where this event takes off, and what comes before its last contact.
    const bool discrete = nodes_.delay_s[path_.steps[k_].node] == 0.0f;
    State off = onset_.after, before = onset_.before;
    double delay_s = 0.0;
    if (!discrete) {
      Record record;
      if (!leave_as_own()) return false;
      pass(record);
      if (record.nodes.back().phase != Phase::flight) return fail("it does not take off");
      off = record.nodes.back().state;
      before = state_before_last_flight(record);
      delay_s = record.nodes.back().time_s;
    }
    // The flight that is flown instead, beside it.
    Record record;
    const Passage like = replay_edge(with_.database_, next.node - 1, record);
    const State &like_off = record.nodes.back().state, &like_end = like.end;
    const double flight_s = like.interval_s - record.nodes.back().time_s;
    const SymmetryElement element = with_.images_.element(
        next.element, take_off_of(nodes_, path_.steps[k_].node).up, take_off_of(nodes_, next.node - 1).up);
    const Transplant seen = placed_.after({element});
    const Transplant beside = registration(seen.of(like_off), off).after(seen);

    const Connection flight =
        with_.connector_.connect(off, beside.of(like_off), beside.of(like_end), flight_s, gravity);
    if (!flight.converged()) return fail(why(flight.shooting.outcome));
    if (with_.connector_.penetrates(flight.start, flight_s, gravity, kDepth_m))
      return fail("it would sink into the ground");
    if (gains(flight.start, before)) return fail("it would gain energy");
    if (discrete) {
      leave(flight.start);
    } else {
      const PlausibleRegion region = region_between(body_, onset_.before, off);
      link_.take_off = TakeOff{flight.start, flight_s, excess_of(region, flight.start, off)};
    }
    const Quat apart = off.orientation * beside.of(like_off).orientation.conjugate();
    link_.orientation_factor = std::exp(log_orientation_factor(rotation_log(apart).norm(), flight_s));
    link_.leave.interval_s = delay_s + flight_s;

    Record flown;
    const Passage passage = record_passage(
        body_, physics_, {onset_.hit, flight.start, 0.0, kLateShare * flight_s + kLate_s}, flown);
    if (passage.next != Next::hit || std::abs(passage.interval_s - flight_s) > kOnTime_s)
      return fail("the body touches the ground on the way");
    onset_ = strike(body_, physics_, passage.end);
    placed_ = beside;
    return true;
  }

  const Realiser& with_;
  const Body& body_;
  const SearchPhysics& physics_;
  const Nodes& nodes_;
  const GraphPath& path_;
  const Targets& targets_;
  std::size_t k_ = 0;
  Onset onset_;            // of the event, as it happens here
  Transplant placed_;      // of the node's own simulation
  State own_;              // the outcome in that
  bool untouched_ = true;  // these two are the same
  Link link_;
  Realised out_;
};

Realiser::Realiser(const Database& database, const SearchPhysics& physics, const Images& images)
    : database_(database), physics_(physics), images_(images), connector_(database.body()) {}

Realised Realiser::realise(const GraphPath& path, const Targets& targets) const {
  return Walk(*this, path, targets).go();
}

}  // namespace ifa
