#include "ifa/signature/events.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/base/counted.hpp"

namespace ifa {

void EventBuilder::begin(const Hit& first) {
  event_ = Event{};
  event_.time_s = last_s_ = last_hit_s_ = first.time_s;
  rest_s_ = kNever;
  squares_ = weight_ = moment_ = 0.0;
  loads_.clear();
  add(first);
}

std::optional<double> EventBuilder::judged_gap_s(double time_s) const {
  if (contact()) return time_s - last_s_;
  if (span_s_ > 0.0 && time_s <= event_.time_s + span_s_) return std::nullopt;
  return time_s - last_hit_s_;
}

void EventBuilder::add_impulse(const Hit& hit) {
  const double impulse = hit.impulse_n_s.norm();
  if (hearing_.amplitudes) {
    count_run(Effect::amplitude_matching);
    squares_ += impulse * impulse;
  }
  if (hearing_.centroids) {
    count_run(Effect::centroid_matching);
    weight_ += impulse;
    moment_ += impulse * (hit.time_s - event_.time_s);
  }
}

void EventBuilder::add(const Hit& hit) {
  if (hearing_.amplitudes || hearing_.centroids) add_impulse(hit);
  const double gap = hit.time_s - (contact() ? last_s_ : last_hit_s_);
  if (gap >= hearing_.merge_gap_s && !contact())
    event_.loose_s = hit.time_s - event_.time_s;
  else
    event_.gap_s = std::max(event_.gap_s, gap);
  last_hit_s_ = hit.time_s;
  last_s_ = std::max(last_s_, hit.time_s);
  ++event_.hits;
}

void EventBuilder::add(const Load& load) {
  if (load.impulse_n_s <= 0.0 || load.length_s <= 0.0) return;
  const double end = load.time_s + load.length_s;
  if (contact())
    event_.gap_s = std::max(event_.gap_s, load.time_s - last_s_);
  else if (end > event_.time_s + span_s_ || load.slip_speed_m_s < hearing_.audible_speed_m_s || !hears_slip())
    return;
  if (hearing_.lengths && span_s_ > 0.0) count_run(Effect::length_matching);
  loads_.push_back(load);
  last_s_ = std::max(last_s_, end);
}

Event EventBuilder::event() const {
  Event e = event_;
  double impulse = 0.0, moment = moment_, last = last_hit_s_;
  for (const Load& load : loads_) {
    const double length = std::min(load.length_s, rest_s_ - load.time_s);
    if (length <= 0.0) break;
    const double part = load.impulse_n_s * (length / load.length_s);
    impulse += part;
    moment += part * (load.time_s + 0.5 * length - e.time_s);
    last = std::max(last, load.time_s + length);
  }
  const double length = std::min(last, rest_s_) - e.time_s;
  e.length_s = length < hearing_.merge_gap_s ? 0.0 : length;
  if (hearing_.amplitudes) e.amplitude = std::sqrt(squares_) + impulse;
  const double weight = weight_ + impulse;
  if (hearing_.centroids) e.centroid_s = weight > 0.0 ? moment / weight : 0.0;
  return e;
}

}  // namespace ifa
