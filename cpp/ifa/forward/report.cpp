#include "ifa/forward/report.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/forward/start.hpp"

namespace ifa {
namespace {

constexpr double kLeastLeadIn_s = 0.1;  // before the first mark, even where the sound begins with it
constexpr double kMostLeadIn_s = 0.5;
constexpr double kStillAtEnd_s = 0.1;   // shown after coming to rest
constexpr double kTailBeforeHit_s = 2e-3;  // an open motion ends this long before a hit that no mark asks for

// What `succeeded` and `plausible` mean (CONVENTIONS.md).
constexpr double kOnTime_s = 1e-3, kMostRetime = 0.30, kMostPenetration_m = 1e-4, kLeastScore = 0.3;
constexpr double kPlausibleRetime = 0.07;

void append(std::vector<Node>& nodes, std::vector<Hit>& hits, const Record& record, double offset_s) {
  for (Node node : record.nodes) {
    node.time_s += offset_s;
    nodes.push_back(node);
  }
  for (Hit hit : record.hits) {
    hit.time_s += offset_s;
    hits.push_back(hit);
  }
}

}  // namespace

Solution make_solution(const Body& body, const SearchPhysics& physics, const Marks& marks, const Found& found) {
  const std::size_t n = marks.size();
  const Vec3& gravity = physics.simulation.gravity_m_s2;
  Runner runner(body, physics);
  std::vector<Node> nodes;
  std::vector<Hit> hits;
  TimeMap time;
  Solution solution;
  solution.events.resize(n);

  // Simulated time agrees with the motion's at the first mark.
  double now = marks.times_s[0];
  {
    const State& first = found.links[0].onset.before;
    const double wanted = std::clamp(now, kLeastLeadIn_s, kMostLeadIn_s);
    const double clear = clear_before(body, first, gravity, wanted);
    const double lead = clear < wanted ? 0.999 * clear : wanted;  // just after the earlier contact
    Flight flight(body);
    flight.start(first, gravity);
    nodes.push_back({now - lead, flight.at(-lead), Phase::flight});
  }

  double first_amplitude = 0.0, end = now;
  for (std::size_t k = 0; k < n; ++k) {
    const Link& link = found.links[k];
    const bool last = k + 1 == n;
    nodes.push_back({now, link.onset.before, Phase::flight});
    Hit first = link.onset.hit;
    first.time_s = now;
    hits.push_back(first);

    Record record;
    const double limit = last ? (marks.ending == Ending::rest ? kLongestRest_s : kOpenTail_s) : kNever;
    const Passage passage = runner.pass(link.onset, link.after, marks.durations_s[k], limit, &record);
    append(nodes, hits, record, now);

    if (k == 0) first_amplitude = passage.event.amplitude;
    EventReport& event = solution.events[k];
    const Factors sound = sound_factors(passage.event, marks, k, first_amplitude);
    event.factors.amplitude = sound.amplitude;
    event.factors.length = sound.length;
    event.factors.centroid = sound.centroid;
    event.target_s = marks.times_s[k];
    if (k == 0) {
      event.error_s = 0.0;
      event.retime = 1.0;
      event.excess = 0.0;
    }
    solution.max_energy_gain_j = std::max(
        solution.max_energy_gain_j, kinetic_energy(body, link.after) - kinetic_energy(body, link.onset.before));

    time.simulated_s.push_back(now);
    time.motion_s.push_back(marks.times_s[k]);
    if (last) {
      event.excess = std::max(event.excess, link.excess);
      event.factors.velocity *= velocity_factor(link.excess);
      end = now + passage.interval_s;
      if (passage.next == Next::rest) {
        end = std::max(end, now + passage.rest_s + physics.simulation.rest_duration_s) + kStillAtEnd_s;
        nodes.push_back({end, nodes.back().state, Phase::rest});
      } else {
        end = now + passage.interval_s - (passage.next == Next::late ? 0.0 : kTailBeforeHit_s);
      }
    } else {
      EventReport& next = solution.events[k + 1];
      const double target = marks.times_s[k + 1] - marks.times_s[k];
      next.error_s = passage.interval_s - target;
      next.retime = target / passage.interval_s;
      next.excess = link.excess;
      next.factors.velocity = velocity_factor(link.excess);
      next.factors.time = time_factor(passage.interval_s, target);
      now += passage.interval_s;
    }
  }
  // An open motion ends before the hit that stopped it, exactly on its flight or between two steps of contact.
  const bool open = marks.ending == Ending::open;
  if (open) {
    const Motion whole(body, gravity, nodes, hits, {});
    const State at_end = to_principal(body, whole.sample({end}, Side::before).front());
    while (nodes.size() > 1 && nodes.back().time_s >= end) nodes.pop_back();
    nodes.push_back({end, at_end, nodes.back().phase});
    std::erase_if(hits, [&](const Hit& h) { return h.time_s >= end; });
  }
  solution.motion = std::make_shared<Motion>(body, gravity, nodes, hits, time);

  // Measured on the motion itself: every audible hit must belong to a mark's event.
  std::size_t k = 0;
  std::vector<char> met(n, 0);
  EventBuilder builder(physics.hearing, 0.0);
  bool begun = false;
  for (const Hit& hit : hits) {
    if (!builder.audible(hit)) continue;
    if (begun && builder.chains(hit.time_s)) {
      builder.add(hit);
      continue;
    }
    while (k < n && met[k]) ++k;
    if (k < n && hit.time_s == time.simulated_s[k]) {
      met[k] = 1;
      builder = EventBuilder(physics.hearing, marks.durations_s[k]);
      solution.events[k].achieved_s = solution.motion->time().to_motion(hit.time_s);
    } else {
      ++solution.extra_hits;
    }
    builder.begin(hit);
    begun = true;
  }
  solution.missed_hits = static_cast<int>(std::count(met.begin(), met.end(), 0));

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
  const bool rested = open || nodes.back().phase == Phase::rest;
  constexpr double kRounding = 1e-9;
  solution.succeeded = rested && solution.missed_hits == 0 && solution.extra_hits == 0 &&
                       solution.max_abs_error_s <= kOnTime_s && most_retime <= 1.0 + kMostRetime &&
                       solution.max_penetration_m <= kMostPenetration_m && solution.score >= kLeastScore &&
                       solution.max_energy_gain_j <= physics.energy_gain_j + kRounding;
  solution.plausible =
      solution.succeeded && most_excess <= 1.0 + kRounding && most_retime <= 1.0 + kPlausibleRetime + kRounding;
  return solution;
}

bool better(const Solution& a, const Solution& b) {
  if (a.plausible != b.plausible) return a.plausible;
  if (a.succeeded != b.succeeded) return a.succeeded;
  return a.score > b.score;
}

}  // namespace ifa
