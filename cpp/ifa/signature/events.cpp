#include "ifa/signature/events.hpp"

#include <algorithm>
#include <cmath>

namespace ifa {

void EventBuilder::begin(const Hit& first) {
  event_ = Event{};
  event_.time_s = last_s_ = last_hit_s_ = first.time_s;
  squares_ = slip_impulse_ = weight_ = moment_ = 0.0;
  add(first);
}

bool EventBuilder::chains(double time_s) const {
  if (span_s_ > 0.0 && time_s <= event_.time_s + span_s_) return true;
  return time_s - last_hit_s_ < hearing_.merge_gap_s;
}

void EventBuilder::add(const Hit& hit) {
  const double impulse = hit.impulse_n_s.norm();
  squares_ += impulse * impulse;
  weight_ += impulse;
  moment_ += impulse * (hit.time_s - event_.time_s);
  const double gap = hit.time_s - last_hit_s_;
  if (gap >= hearing_.merge_gap_s)
    event_.loose_s = hit.time_s - event_.time_s;
  else
    event_.gap_s = std::max(event_.gap_s, gap);
  last_hit_s_ = hit.time_s;
  last_s_ = std::max(last_s_, hit.time_s);
  ++event_.hits;
}

void EventBuilder::add(const Load& load) {
  const double end = load.time_s + load.length_s;
  if (end > event_.time_s + span_s_) return;
  if (load.impulse_n_s <= 0.0 || load.slip_speed_m_s < hearing_.audible_speed_m_s) return;
  slip_impulse_ += load.impulse_n_s;
  weight_ += load.impulse_n_s;
  moment_ += load.impulse_n_s * (load.time_s + 0.5 * load.length_s - event_.time_s);
  last_s_ = std::max(last_s_, end);
}

Event EventBuilder::event() const {
  Event e = event_;
  const double length = last_s_ - e.time_s;
  e.length_s = length < hearing_.merge_gap_s ? 0.0 : length;
  e.amplitude = std::sqrt(squares_) + slip_impulse_;
  e.centroid_s = weight_ > 0.0 ? moment_ / weight_ : 0.0;
  return e;
}

}  // namespace ifa
