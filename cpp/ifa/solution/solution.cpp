#include "ifa/solution/solution.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/base/counted.hpp"

#include "ifa/rigid/contact.hpp"
#include "ifa/rigid/symmetry.hpp"
#include "ifa/signature/placement.hpp"
#include "ifa/solution/standard.hpp"

namespace ifa {
namespace {

constexpr double kLeastLeadIn_s = 0.1;  // before the first mark, even where the sound begins with it
constexpr double kStillAtEnd_s = 0.1;   // shown after coming to rest
constexpr double kMostUnasked_s = 3.0;  // shown after the last mark that was reached, where it does not rest
constexpr double kTailBeforeHit_s = 2e-3;  // an open motion ends this long before a hit that no mark asks for

// Whether an impact that is no part of the last event could be taken for audible.
bool nearly_audible(const SearchPhysics& physics, const Hit& hit) {
  const HearingOptions& hearing = physics.hearing;
  return hearing.events == Events::audible && hit.time_s > hearing.merge_gap_s &&
         hit.approach_speed_m_s < hearing.audible_speed_m_s &&
         hit.approach_speed_m_s >= hearing.audible_speed_m_s * (1.0 - physics.margin);
}

void append(Record& whole, const Record& part, double offset_s) {
  const auto add = [offset_s](auto& to, const auto& from) {
    for (auto item : from) {
      item.time_s += offset_s;
      to.push_back(item);
    }
  };
  add(whole.nodes, part.nodes);
  add(whole.hits, part.hits);
  add(whole.loads, part.loads);
}

// A mark without a hit of its own: the nearest audible hit stands in, and no factor is left.
void report_missed(const Motion& motion, const HearingOptions& hearing, double target_s, EventReport& event) {
  double nearest = motion.end_s();
  for (const Hit& hit : motion.hits())
    if (EventBuilder(hearing, 0.0).audible(hit) &&
        std::abs(hit.time_s - target_s) < std::abs(nearest - target_s))
      nearest = hit.time_s;
  event = {target_s, nearest, nearest - target_s, 0.0, 1.0, 0.0, {}};
  event.factors.time = 0.0;
}

// Measured on the motion itself: every audible hit must belong to a mark's event.
void count_hits(const Record& whole, const SearchPhysics& physics, const Marks& marks, const TimeMap& time,
                Solution& solution) {
  const bool open = marks.ending == Ending::open;
  const std::size_t n = marks.size();
  std::size_t k = 0;
  std::vector<char> met(n, 0);
  EventBuilder builder(physics.hearing, 0.0);
  bool begun = false;
  auto load = whole.loads.begin();
  for (const Hit& hit : whole.hits) {
    for (; load != whole.loads.end() && load->time_s < hit.time_s; ++load)
      if (begun) builder.add(*load);
    if (!builder.audible(hit)) continue;
    if (begun && builder.chains(hit.time_s)) {
      builder.add(hit);
      continue;
    }
    while (k < n && met[k]) ++k;
    if (k < time.simulated_s.size() && hit.time_s == time.simulated_s[k]) {  // of those that were reached
      met[k] = 1;
      builder = EventBuilder(physics.hearing, marks.durations_s[k]);
      solution.events[k].achieved_s = time.to_motion(hit.time_s);
    } else if (k < n || !open) {  // after the last mark an open ending asks for nothing
      ++solution.extra_hits;
    }
    builder.begin(hit);
    begun = true;
  }
  for (std::size_t missed = 0; missed < n; ++missed) {
    if (met[missed]) continue;
    ++solution.missed_hits;
    report_missed(*solution.motion, physics.hearing, marks.times_s[missed], solution.events[missed]);
  }
}

// What the constraints ask of the image of a motion under an element of the body's symmetry.
Alignment aligned(const SymmetryElement& element, const Body& body, const Constraints& asked,
                  const Found& found, const State& at_end) {
  Alignment alignment;
  for (std::size_t k = 0; k < found.links.size(); ++k)
    alignment.add(asked, k, body, image(element, found.links[k].onset.before));
  alignment.add(asked, kAtRest, body, image(element, at_end));
  return alignment;
}

// Puts a motion where its constraints want it, as that of its images that meets them best: under the body's
// symmetry each is as good a motion and sounds the same, but another of the body's faces comes down, or it
// goes the other way round.
void place(const Body& body, const Constraints& asked, const Found& found, std::vector<Node>& nodes,
           std::vector<Hit>& hits) {
  constexpr double kBetter = 1e-9;  // images that rounding alone tells apart are equals: the first is taken
  const State at_end = nodes.back().state;
  SymmetryElement element;  // the identity
  Alignment alignment = aligned(element, body, asked, found, at_end);
  for (const SymmetryElement& other : Symmetry::of(body).elements())
    if (const Alignment a = aligned(other, body, asked, found, at_end);
        a.cost() < alignment.cost() - kBetter) {
      element = other;
      alignment = a;
    }
  const Placement placement = alignment.best();
  for (Node& node : nodes) node.state = placement.placed(image(element, node.state));
  for (Hit& hit : hits) {
    if (!element.proper) {
      hit.impulse_n_s = kWorldMirror * hit.impulse_n_s;
      hit.position_m = kWorldMirror * hit.position_m;
    }
    hit.impulse_n_s = placement.turned(hit.impulse_n_s);
    hit.position_m = placement.placed(hit.position_m);
  }
}

void measure_constraints(const Marks& marks, Solution& solution) {
  const Motion& motion = *solution.motion;
  const auto pose = [&](std::size_t mark) {
    return motion.sample({mark == kAtRest ? motion.end_s() : marks.times_s[mark]}, Side::before).front();
  };
  for (const PositionConstraint& c : marks.constraints.positions) {
    const double error_m = (pose(c.mark).position.head<2>() - c.position_m).norm();
    solution.constraints.push_back({error_m, position_constraint_factor(error_m)});
  }
  for (const OrientationConstraint& c : marks.constraints.orientations) {
    const double error_rad = angle_between_rad(pose(c.mark).orientation * c.body_direction, c.direction);
    solution.constraints.push_back({error_rad, orientation_constraint_factor(error_rad)});
  }
}

}  // namespace

Solution make_solution(const Body& body, const SearchPhysics& physics, const Marks& marks, const Plan& plan,
                       const Found& found, double lead_in_s, const Progress* progress) {
  const std::size_t n = marks.size(), links = found.links.size();
  const Vec3& gravity = physics.simulation.gravity_m_s2;
  const bool rest = marks.ending == Ending::rest, settles = plan.on(Effect::settling_to_rest);
  const bool retimes = plan.on(Effect::retiming);
  Record whole;
  std::vector<Node>& nodes = whole.nodes;
  std::vector<Hit>& hits = whole.hits;
  TimeMap time;
  Solution solution;
  solution.events.resize(n);

  // Simulated time agrees with the motion's at the first mark.
  double now = marks.times_s[0];
  if (plan.on(Effect::pre_roll_flight)) {
    count_run(Effect::pre_roll_flight);
    const State& first = found.links[0].onset.before;
    const double wanted = std::min(std::max(now, kLeastLeadIn_s), lead_in_s);
    const double clear = clear_before(body, first, gravity, wanted);
    const double lead = clear < wanted ? 0.999 * clear : wanted;  // just after the earlier contact
    Flight flight(body);
    flight.start(first, gravity);
    nodes.push_back({now - lead, flight.at(-lead), Phase::flight});
  }

  double first_amplitude = 0.0, end = now;
  for (std::size_t k = 0; k < links; ++k) {
    const Link& link = found.links[k];
    const bool last = k + 1 == links;
    nodes.push_back({now, link.onset.before, Phase::flight});
    Hit first = link.onset.hit;
    first.time_s = now;
    hits.push_back(first);

    Record record;
    const double limit = !last            ? kNever
                         : !settles       ? kOpenTail_s
                         : found.complete ? kLongestRest_s
                                          : kMostUnasked_s;
    if (last && settles) count_run(Effect::settling_to_rest);
    Passage passage = record_passage(
        body, physics, {link.onset.hit, link.leave.after, marks.durations_s[k], limit}, record, progress);
    append(whole, record, now);
    double excess = link.leave.excess;
    if (link.take_off) {
      const Node& leaves = record.nodes.back();
      passage.interval_s = leaves.time_s + link.take_off->flight_s;
      excess = std::max(excess, link.take_off->excess);
      const double before_j = kinetic_energy(body, state_before_last_flight(record));
      solution.max_energy_gain_j =
          std::max(solution.max_energy_gain_j, kinetic_energy(body, link.take_off->after) - before_j);
      nodes.push_back({now + leaves.time_s, link.take_off->after, Phase::flight});
    }

    if (k == 0) first_amplitude = passage.event.amplitude;
    EventReport& event = solution.events[k];
    const Factors sound = sound_factors(passage.event, marks, k, first_amplitude, plan.sound_terms());
    event.factors.amplitude = sound.amplitude;
    event.factors.length = sound.length;
    event.factors.centroid = sound.centroid;
    event.target_s = marks.times_s[k];
    if (k == 0) {
      event.error_s = 0.0;
      event.retime = 1.0;
      event.excess = 0.0;
    }
    solution.max_energy_gain_j =
        std::max(solution.max_energy_gain_j,
                 kinetic_energy(body, link.leave.after) - kinetic_energy(body, link.onset.before));

    time.simulated_s.push_back(now);
    if (retimes) {
      count_run(Effect::retiming);
      time.motion_s.push_back(marks.times_s[k]);
    } else {
      time.motion_s.push_back(now);
    }
    if (last) {
      event.excess = std::max(event.excess, link.leave.excess);
      event.factors.velocity *= velocity_factor(link.leave.excess);
      // What no mark asked for, or could have, goes as physics has it, to rest.
      const double give_up_s = now + (rest ? kMostUnasked_s : kLongestRest_s);
      while (settles && passage.next != Next::rest && passage.next != Next::late) {
        now += passage.interval_s;
        nodes.push_back({now, passage.end, nodes.back().phase});
        const Onset onset = strike(body, physics, passage.end);
        Hit hit = onset.hit;
        hit.time_s = now;
        hits.push_back(hit);
        Record unasked;
        count_run(Effect::settling_to_rest);
        passage = record_passage(body, physics, {onset.hit, onset.after, 0.0, std::max(0.0, give_up_s - now)},
                                 unasked, progress);
        append(whole, unasked, now);
      }
      end = now + passage.interval_s;
      nodes.push_back({end, passage.end, nodes.back().phase});
      if (passage.next == Next::rest) {
        end = std::max(end, now + passage.rest_s + physics.simulation.rest_duration_s) + kStillAtEnd_s;
        nodes.push_back({end, passage.end, Phase::rest});
      } else if (passage.next != Next::late) {
        end -= kTailBeforeHit_s;
      }
      // Likewise before one that could be taken for audible.
      if (!settles)
        for (const Hit& hit : record.hits)
          if (nearly_audible(physics, hit)) end = std::min(end, now + hit.time_s - kTailBeforeHit_s);
    } else {
      EventReport& next = solution.events[k + 1];
      const double target = marks.times_s[k + 1] - marks.times_s[k];
      next.error_s = passage.interval_s - target;
      next.retime = retimes ? target / passage.interval_s : 1.0;
      next.excess = excess;
      next.factors.velocity = velocity_factor(excess);
      next.factors.orientation = link.orientation_factor;
      next.factors.time = time_factor(passage.interval_s, target);
      now += passage.interval_s;
    }
  }
  // An open motion ends before the hit that stopped it, exactly on its flight or between two steps of
  // contact.
  if (!settles) {
    const Motion longer(body, gravity, nodes, hits, {});
    const State at_end = to_principal(body, longer.sample({end}, Side::before).front());
    while (nodes.size() > 1 && nodes.back().time_s >= end) nodes.pop_back();
    nodes.push_back({end, at_end, nodes.back().phase});
    std::erase_if(hits, [&](const Hit& h) { return h.time_s >= end; });
  }
  if (!marks.constraints.empty()) place(body, marks.constraints, found, nodes, hits);
  solution.motion = std::make_shared<Motion>(body, gravity, nodes, hits, time);
  measure_constraints(marks, solution);

  count_hits(whole, physics, marks, time, solution);

  double most_retime = 1.0, most_excess = 0.0;
  std::vector<Factors> factors;
  for (EventReport& event : solution.events) {
    event.error_retimed_s = event.achieved_s - event.target_s;
    solution.max_abs_error_s = std::max(solution.max_abs_error_s, std::abs(event.error_retimed_s));
    most_retime = std::max({most_retime, event.retime, 1.0 / event.retime});
    most_excess = std::max(most_excess, event.excess);
    factors.push_back(event.factors);
  }
  solution.score = score(factors);
  solution.score_without_sound = score_without_sound(factors);
  solution.max_penetration_m = solution.motion->max_penetration_m(solution.motion->dense_times());
  solution.restitution = body.material().restitution;
  solution.friction = body.material().friction;
  const bool rested = !rest || nodes.back().phase == Phase::rest;
  solution.succeeded = rested && solution.missed_hits == 0 && solution.extra_hits == 0 &&
                       solution.max_abs_error_s <= kMostError_s && most_retime <= 1.0 + kMostRetime &&
                       solution.max_penetration_m <= kMostPenetration_m && solution.score >= kLeastScore &&
                       solution.max_energy_gain_j <= physics.energy_gain_j + kStandardRounding;
  solution.plausible = solution.succeeded && most_excess <= kPlausible.excess + kStandardRounding &&
                       most_retime <= 1.0 + kPlausible.retime + kStandardRounding;
  return solution;
}

Stage stage_of(const Solution& best, int rung, double time_s) {
  return {time_s, rung, best.score, best.succeeded, best.plausible};
}

bool Solution::constraints_met() const {
  return std::ranges::all_of(constraints, [](const ConstraintReport& c) { return c.factor >= kMetFactor; });
}

double Solution::log_constraints() const {
  double sum = 0.0;
  for (const ConstraintReport& c : constraints) sum += std::log(std::max(c.factor, 1e-300));
  return sum;
}

bool better(const Solution& a, const Solution& b) {
  if (a.plausible != b.plausible) return a.plausible;
  if (a.succeeded != b.succeeded) return a.succeeded;
  const int wrong_a = a.missed_hits + a.extra_hits, wrong_b = b.missed_hits + b.extra_hits;
  if (wrong_a != wrong_b) return wrong_a < wrong_b;
  if (a.constraints.empty()) return a.score > b.score;
  const auto log_weight = [](const Solution& s) {
    return 6.0 * static_cast<double>(s.events.size()) * std::log(std::max(s.score, 1e-300)) +
           s.log_constraints();
  };
  return log_weight(a) > log_weight(b);
}

}  // namespace ifa
