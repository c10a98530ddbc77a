// The contact-time signature of a motion: which of its hits sound, and how they chain into events.
#pragma once

#include <vector>

#include "ifa/rigid/run.hpp"

namespace ifa {

struct HearingOptions {
  double audible_speed_m_s = 0.05;  // a softer impact is silent; so is slower slip
  double merge_gap_s = 0.010;       // hits nearer than this chain into one event
};

// An event: a chain of audible hits, timed at its first. A chain shorter than the merge gap is discrete
// (length 0). Inside the span of a mark with a duration, slip under load sounds too and hits chain over any
// gap.
struct Event {
  double time_s = 0.0;
  double length_s = 0.0;
  double amplitude = 0.0;   // sqrt(sum J^2) over its hits, N s; plus the force's time integral while slipping
  double centroid_s = 0.0;  // of the amplitude, from the event's start
  double loose_s = 0.0;     // from the start to the last hit that only the mark's span holds in the event
  double gap_s = 0.0;       // the longest between hits that the merge gap holds together
  int hits = 0;
};

// Builds one event from its parts, given in the order of time.
class EventBuilder {
 public:
  EventBuilder(const HearingOptions& hearing, double span_s) : hearing_(hearing), span_s_(span_s) {}

  void begin(const Hit& first);
  bool audible(const Hit& hit) const { return hit.approach_speed_m_s >= hearing_.audible_speed_m_s; }

  // Whether an audible hit at this time still belongs to the event.
  bool chains(double time_s) const;
  void add(const Hit& hit);
  void add(const Load& load);  // ignored outside the span and where nothing slips audibly
  Event event() const;

  double last_s() const { return last_s_; }

 private:
  HearingOptions hearing_;
  double span_s_;  // of the mark it shall meet; 0 for a discrete one
  Event event_;
  double last_s_ = 0.0, last_hit_s_ = 0.0;
  double squares_ = 0.0, slip_impulse_ = 0.0, weight_ = 0.0, moment_ = 0.0;
};

}  // namespace ifa
