#include "ifa/verify/events.hpp"

#include <algorithm>
#include <cmath>

namespace ifa::verify {
namespace {

constexpr double kWidestWindow = 0.050;  // s to either side of a mark
constexpr double kGapMargin = 1e-4;      // s, of the merge gap
constexpr std::size_t kMostThresholds = 32;

// The ratio of the transition that a hit ends: hits on a mark belong to the one before it.
double retime_of_hit(double time_s, const MarkSet& marks, const Claims& claims, double tolerance_s) {
  for (std::size_t k = 0; k < marks.times_s.size(); ++k)
    if (time_s <= marks.times_s[k] + tolerance_s) return claims.retime.empty() ? 1.0 : claims.retime[k];
  return 1.0;
}

struct Reading {
  std::vector<DetectedEvent> events;
  std::vector<int> event_of;  // per hit; -1 where it is read as silent
};

// A hit with what it was before retiming.
struct Heard {
  double speed_m_s, retime;
};

struct Rule {
  double audible_speed_m_s;  // only hits above it are read
  double gap_s;
  bool before_retiming;  // whether the gap is
};

Reading read_hits(const std::vector<DetectedHit>& hits, const std::vector<Heard>& heard, const Rule& rule) {
  Reading reading;
  reading.event_of.assign(hits.size(), -1);
  double previous = 0.0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (heard[i].speed_m_s <= rule.audible_speed_m_s) continue;
    const double gap = (hits[i].time_s - previous) / (rule.before_retiming ? heard[i].retime : 1.0);
    if (reading.events.empty() || gap >= rule.gap_s) reading.events.push_back({hits[i].time_s, 0.0, 0});
    DetectedEvent& e = reading.events.back();
    e.duration_s = hits[i].time_s - e.time_s;
    ++e.hits;
    previous = hits[i].time_s;
    reading.event_of[i] = static_cast<int>(reading.events.size()) - 1;
  }
  return reading;
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
  const double loud = options.audible_speed_m_s * (1.0 + options.speed_margin);
  std::vector<Heard> heard;
  std::vector<double> thresholds{options.audible_speed_m_s * (1.0 - options.speed_margin)};
  for (const Impact& impact : impacts.list) {
    const double retime = retime_of_hit(impact.time_s, marks, claims, options.time_tolerance_s);
    const double speed = impact.speed_m_s * retime;
    if (speed <= thresholds.front()) continue;
    c.hits.push_back({impact.time_s, impact.speed_m_s, impact.position_m, speed > loud, 0});
    heard.push_back({speed, retime});
    if (speed <= loud) thresholds.push_back(speed);
  }
  std::sort(thresholds.begin(), thresholds.end());
  while (thresholds.size() > kMostThresholds) {  // every other one, the ends kept
    for (std::size_t k = 1; k + 1 < thresholds.size(); ++k) thresholds.erase(thresholds.begin() + k);
  }
  std::vector<Reading> readings;  // the first, of every hit and the widest gap, is reported
  std::size_t strict = 0;         // from here on, those without any hit that may be silent
  for (const double threshold : thresholds) {
    strict = readings.size();
    for (const double margin : {kGapMargin, -kGapMargin})
      for (const bool before_retiming : {false, true})
        readings.push_back(
            read_hits(c.hits, heard, {threshold, options.merge_gap_s + margin, before_retiming}));
  }
  c.events = readings.front().events;
  for (std::size_t i = 0; i < c.hits.size(); ++i) c.hits[i].event = readings.front().event_of[i];

  std::vector<double> starts;
  for (const Reading& reading : readings)
    for (const DetectedEvent& e : reading.events) starts.push_back(e.time_s);
  std::sort(starts.begin(), starts.end());
  starts.erase(std::unique(starts.begin(), starts.end()), starts.end());
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

  const double end = times.back() + (marks.durations_s.empty() ? 0.0 : marks.durations_s.back());
  for (std::size_t i = 0; i < c.hits.size(); ++i) {
    const double time = c.hits[i].time_s;
    const bool starts_one = std::any_of(readings.begin() + strict, readings.end(), [&](const Reading& r) {
      return r.event_of[i] >= 0 && r.events[r.event_of[i]].time_s == time;
    });
    if (!starts_one) continue;
    const bool answers = std::any_of(readings.begin(), readings.end(), [&](const Reading& r) {
      return r.event_of[i] >= 0 &&
             std::find(met.begin(), met.end(), r.events[r.event_of[i]].time_s) != met.end();
    });
    if (answers) continue;
    if (in_marked_span(time, marks, options.time_tolerance_s)) continue;
    if (!marks.rest && time > end) continue;
    c.extra_events_s.push_back(time);
  }
  c.extra_hits = static_cast<int>(c.extra_events_s.size());
}

}  // namespace ifa::verify
