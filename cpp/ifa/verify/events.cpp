#include "ifa/verify/events.hpp"

#include <algorithm>
#include <cmath>

namespace ifa::verify {
namespace {

constexpr double kWidestWindow = 0.050;  // s to either side of a mark
constexpr double kGapMargin = 1e-4;      // s, of the merge gap

// The ratio of the transition that a hit ends: hits on a mark belong to the one before it. The audible speed
// is one of the simulated body, so retiming is undone before comparing.
double retime_of_hit(double time_s, const MarkSet& marks, const Claims& claims, double tolerance_s) {
  for (std::size_t k = 0; k < marks.times_s.size(); ++k)
    if (time_s <= marks.times_s[k] + tolerance_s) return claims.retime.empty() ? 1.0 : claims.retime[k];
  return 1.0;
}

// Starts of the events that hits chain into; `event` receives the event of each hit taken, -1 for the others.
template <class Take>
std::vector<DetectedEvent> chain(const std::vector<DetectedHit>& hits, double gap_s, const Take& take,
                                 std::vector<int>* event) {
  std::vector<DetectedEvent> events;
  event->assign(hits.size(), -1);
  double previous = 0.0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!take(hits[i])) continue;
    if (events.empty() || hits[i].time_s - previous >= gap_s) events.push_back({hits[i].time_s, 0.0, 0});
    DetectedEvent& e = events.back();
    e.duration_s = hits[i].time_s - e.time_s;
    ++e.hits;
    previous = hits[i].time_s;
    (*event)[i] = static_cast<int>(events.size()) - 1;
  }
  return events;
}

bool in_marked_span(double time_s, const MarkSet& marks, double tolerance_s) {
  for (std::size_t k = 0; k < marks.durations_s.size(); ++k) {
    const double from = marks.times_s[k];
    if (marks.durations_s[k] > 0.0 && time_s >= from - tolerance_s &&
        time_s <= from + marks.durations_s[k] + tolerance_s)
      return true;
  }
  return false;
}

}  // namespace

void match_events(const Impacts& impacts, const MarkSet& marks, const Claims& claims, const Options& options,
                  Certificate* certificate) {
  Certificate& c = *certificate;
  for (const Impact& impact : impacts.list) {
    const double speed =
        impact.speed_m_s * retime_of_hit(impact.time_s, marks, claims, options.time_tolerance_s);
    if (speed <= options.audible_speed_m_s * (1.0 - options.speed_margin)) continue;
    const bool certain = speed > options.audible_speed_m_s * (1.0 + options.speed_margin);
    c.hits.push_back({impact.time_s, impact.speed_m_s, impact.position_m, certain, 0});
  }
  std::vector<int> wide, narrow;
  c.events = chain(c.hits, options.merge_gap_s + kGapMargin, [](const DetectedHit&) { return true; }, &wide);
  const auto certain_events = chain(
      c.hits, options.merge_gap_s - kGapMargin, [](const DetectedHit& h) { return h.certain; }, &narrow);
  for (std::size_t i = 0; i < c.hits.size(); ++i) c.hits[i].event = wide[i];

  std::vector<double> starts;
  for (const auto& e : certain_events) starts.push_back(e.time_s);
  for (const auto& e : c.events) starts.push_back(e.time_s);
  std::vector<double> met;
  const auto& times = marks.times_s;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double before = k > 0 ? 0.5 * (times[k] - times[k - 1]) : kWidestWindow;
    const double after = k + 1 < times.size() ? 0.5 * (times[k + 1] - times[k]) : kWidestWindow;
    const double low = times[k] - std::min(before, kWidestWindow);
    const double high = times[k] + std::min(after, kWidestWindow);
    MarkCheck check;
    check.target_s = times[k];
    for (const double s : starts) {
      if (s < low || s >= high) continue;  // half-open: an event belongs to one mark
      if (check.matched && std::abs(s - times[k]) >= std::abs(check.error_s)) continue;
      check.matched = true;
      check.achieved_s = s;
      check.error_s = s - times[k];
    }
    if (check.matched) {
      met.push_back(check.achieved_s);
      c.max_abs_error_s = std::max(c.max_abs_error_s, std::abs(check.error_s));
    } else {
      ++c.missed_hits;
    }
    c.marks.push_back(check);
  }

  const auto is_met = [&](double time_s) { return std::find(met.begin(), met.end(), time_s) != met.end(); };
  const double end = times.back() + (marks.durations_s.empty() ? 0.0 : marks.durations_s.back());
  for (std::size_t i = 0; i < c.hits.size(); ++i) {
    if (narrow[i] < 0 || certain_events[narrow[i]].time_s != c.hits[i].time_s) continue;  // starts no event
    const double time = c.hits[i].time_s;
    if (is_met(time) || is_met(c.events[wide[i]].time_s)) continue;
    if (in_marked_span(time, marks, options.time_tolerance_s)) continue;
    if (!marks.rest && time > end) continue;
    c.extra_events_s.push_back(time);
  }
  c.extra_hits = static_cast<int>(c.extra_events_s.size());
}

}  // namespace ifa::verify
