// The contact-time signature of a motion: what of it is heard, and how that chains into events.
#pragma once

#include <optional>
#include <vector>

#include "ifa/rigid/run.hpp"

namespace ifa {

// What an event is: a chain of audible hits, or an interval of contact between two flights (paper section 4).
enum class Events { audible, contact };

struct HearingOptions {
  Events events = Events::audible;
  double audible_speed_m_s = 0.05;  // a softer impact is silent; so is slower slip; of no account for contact
  double merge_gap_s = 0.010;  // hits nearer than this chain into one event; flights shorter join contact
  // What of an event is wanted: an amplitude or a centroid that is not stays 0, and where none of these is,
  // slip in a span goes unheard.
  bool amplitudes = true, lengths = true, centroids = true;
};

// An event, timed at its first hit. One shorter than the merge gap is discrete (length 0).
//
// Audible: a chain of audible hits. Inside the span of a mark with a duration, slip under load sounds too and
// hits chain over any gap; from the last hit inside the span the chain goes on beyond it, by the merge gap.
//
// Contact: from an impact after a flight of at least the merge gap until the next such flight, impacts of any
// speed and sustained contact together, shorter flights included. A mark's span excuses nothing.
struct Event {
  double time_s = 0.0;
  double length_s = 0.0;
  // sqrt(sum J^2) over its hits, N s, plus the normal force's time integral: while it slips audibly in a
  // span, or in all sustained contact. (The two-norm of the steps' impulses would depend on the step.)
  double amplitude = 0.0;
  double centroid_s = 0.0;  // of the amplitude, from the event's start
  double loose_s = 0.0;     // from the start to the last hit that only the mark's span holds in the event
  double gap_s = 0.0;       // the longest that the merge gap bridges: between hits; of contact, a flight
  int hits = 0;
};

// Builds one event from its parts, given in the order of time.
class EventBuilder {
 public:
  EventBuilder(const HearingOptions& hearing, double span_s) : hearing_(hearing), span_s_(span_s) {}

  void begin(const Hit& first);

  // Whether an impact belongs to events at all: any does where contact makes them.
  bool audible(const Hit& hit) const {
    return contact() || hit.approach_speed_m_s >= hearing_.audible_speed_m_s;
  }

  // How long before such a hit at this time the event was last heard (of contact: the flight between), where
  // that is what decides whether it still belongs to the event; none inside the span, where any does.
  std::optional<double> judged_gap_s(double time_s) const;

  // Whether such a hit at this time still belongs to the event.
  bool chains(double time_s) const {
    const std::optional<double> gap_s = judged_gap_s(time_s);
    return !gap_s || *gap_s < hearing_.merge_gap_s;
  }
  void add(const Hit& hit);
  // Ignored without a normal impulse; audible events also ignore it outside the span and where nothing slips
  // audibly.
  void add(const Load& load);
  // The body rests from then on: its weight on the ground is not heard.
  void clip(double rest_s) { rest_s_ = rest_s; }
  Event event() const;

  double last_s() const { return last_s_; }  // the end of what was added last; clip does not change it

 private:
  void add_impulse(const Hit& hit);
  bool contact() const { return hearing_.events == Events::contact; }
  bool hears_slip() const { return hearing_.amplitudes || hearing_.lengths || hearing_.centroids; }

  HearingOptions hearing_;
  double span_s_;  // of the mark it shall meet; 0 for a discrete one
  Event event_;
  double last_s_ = 0.0, last_hit_s_ = 0.0, rest_s_ = kNever;
  double squares_ = 0.0, weight_ = 0.0, moment_ = 0.0;  // of hits
  std::vector<Load> loads_;
};

}  // namespace ifa
