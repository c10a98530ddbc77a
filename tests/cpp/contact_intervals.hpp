// Contact events by brute force: from a motion's nodes and impacts, without the code of events.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "sample_bodies.hpp"

namespace ifa::sample {

struct ContactInterval {
  double begin_s, end_s;  // its first and its last instant of contact
  double squares = 0.0;   // of its impacts' impulses
  double pressed = 0.0;   // N s in sustained contact: what the ground gives to the momentum, m (dv + g dt)
  int hits = 0;

  double amplitude() const { return std::sqrt(squares) + pressed; }
};

struct ContactIntervals {
  std::vector<ContactInterval> all;
  double nearest_gap;  // of the gaps without contact the one nearest to the merge gap, over it: about 1 could
                       // be judged either way
};

// Impacts and steps of sustained contact that begin less than `merge_gap_s` after what came before are one
// interval. What comes after `until_s`, when the body rests, does not count.
inline ContactIntervals contact_intervals(const Body& body, const std::vector<Node>& nodes,
                                          const std::vector<Hit>& hits, double merge_gap_s, double until_s) {
  ContactIntervals intervals{{}, kNever};
  const auto at = [&](double time_s) -> ContactInterval& {
    if (!intervals.all.empty()) {
      const double gap = (time_s - intervals.all.back().end_s) / merge_gap_s;
      if (std::abs(gap - 1.0) < std::abs(intervals.nearest_gap - 1.0)) intervals.nearest_gap = gap;
      if (gap < 1.0) return intervals.all.back();
    }
    return intervals.all.emplace_back(ContactInterval{time_s, time_s});
  };
  std::size_t i = 0;
  const auto press_until = [&](double time_s) {
    for (; i + 1 < nodes.size() && nodes[i + 1].time_s <= time_s; ++i) {
      const Node &a = nodes[i], &b = nodes[i + 1];
      const double whole = b.time_s - a.time_s, length = std::min(b.time_s, until_s) - a.time_s;
      if (a.phase != Phase::contact || length <= 0.0) continue;
      const double weight = body.mass_kg() * kGravity * whole;
      const double pressed = weight + body.mass_kg() * (b.state.velocity.z() - a.state.velocity.z());
      constexpr double kWeightless = 1e-9;  // rounding: it does not touch any more
      if (pressed <= kWeightless * weight) continue;
      ContactInterval& interval = at(a.time_s);
      interval.pressed += pressed * length / whole;
      interval.end_s = a.time_s + length;
    }
  };
  for (const Hit& hit : hits) {
    press_until(hit.time_s);
    ContactInterval& interval = at(hit.time_s);
    interval.squares += hit.impulse_n_s.squaredNorm();
    interval.end_s = std::max(interval.end_s, hit.time_s);
    ++interval.hits;
  }
  press_until(kNever);
  return intervals;
}

}  // namespace ifa::sample
