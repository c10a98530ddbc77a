#include "ifa/verify/events.hpp"

#include <algorithm>
#include <cmath>

namespace ifa::verify {
namespace {

constexpr double kWidestWindow = 0.050;  // s to either side of a mark
constexpr double kGapMargin = 1e-4;      // s, of the merge gap
constexpr std::size_t kMostThresholds = 32;

// What events are made of: a hit, or a touch. `level` is compared with the reading's threshold.
struct Piece {
  double begin_s, end_s, latest_end_s;
  double level;
  double retime;  // of the transition that it ends
  bool begins;    // whether an event may begin with it; or it only bridges what would be a gap
  int hit;        // its index in the certificate, -1 for none
};

struct Reading {
  std::vector<DetectedEvent> events;
  std::vector<int> event_of;  // per piece; -1 where it is left out
};

struct Rule {
  double threshold;      // only pieces above it are read
  double gap_s, margin;  // gaps shorter than the two together are bridged; > 0: gaps are as short as can be
  bool before_retiming;  // whether the gap is
};

Reading read_pieces(const std::vector<Piece>& pieces, const Rule& rule) {
  Reading reading;
  reading.event_of.assign(pieces.size(), -1);
  double previous = 0.0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& p = pieces[i];
    if (p.level <= rule.threshold) continue;
    const double gap = (p.begin_s - previous) / (rule.before_retiming ? p.retime : 1.0);
    const double end = rule.margin > 0.0 ? p.latest_end_s : p.end_s;
    if (reading.events.empty() || gap >= rule.gap_s + rule.margin) {
      if (!p.begins) continue;
      reading.events.push_back({p.begin_s, 0.0, 0});
      previous = end;
    }
    previous = std::max(previous, end);
    DetectedEvent& e = reading.events.back();
    e.duration_s = std::max(e.duration_s, p.end_s - e.time_s);
    e.hits += p.hit >= 0;
    reading.event_of[i] = static_cast<int>(reading.events.size()) - 1;
  }
  return reading;
}

// Hits above the lower edge of the hysteresis band; the thresholds are those at which a reading changes.
std::vector<Piece> audible_pieces(const Impacts& impacts, const Options& options, const RetimeAt& retime_to,
                                  std::vector<double>* thresholds, std::vector<DetectedHit>* hits) {
  const double loud = options.audible_speed_m_s * (1.0 + options.speed_margin);
  thresholds->push_back(options.audible_speed_m_s * (1.0 - options.speed_margin));
  std::vector<Piece> pieces;
  for (const Impact& impact : impacts.list) {
    const double retime = retime_to(impact.time_s);
    const double speed = impact.speed_m_s * retime;  // before retiming
    if (speed <= thresholds->front()) continue;
    pieces.push_back(
        {impact.time_s, impact.time_s, impact.time_s, speed, retime, true, static_cast<int>(hits->size())});
    hits->push_back({impact.time_s, impact.speed_m_s, impact.position_m, speed > loud, 0});
    if (speed <= loud) thresholds->push_back(speed);
  }
  std::sort(thresholds->begin(), thresholds->end());
  while (thresholds->size() > kMostThresholds) {  // every other one, the ends kept
    for (std::size_t k = 1; k + 1 < thresholds->size(); ++k) thresholds->erase(thresholds->begin() + k);
  }
  return pieces;
}

// Doubtful touches below the second threshold, certain ones above it.
std::vector<Piece> contact_pieces(const Impacts& impacts, const std::vector<Touch>& touches,
                                  const RetimeAt& retime_to, std::vector<double>* thresholds,
                                  std::vector<DetectedHit>* hits) {
  *thresholds = {0.0, 1.0};
  std::vector<Piece> pieces;
  for (const Touch& t : touches) {
    pieces.push_back(
        {t.begin_s, t.end_s, t.latest_end_s, t.certain ? 2.0 : 1.0, retime_to(t.begin_s), t.certain, -1});
    if (t.impact < 0) continue;
    const Impact& impact = impacts.list[t.impact];
    pieces.back().hit = static_cast<int>(hits->size());
    hits->push_back({impact.time_s, impact.speed_m_s, impact.position_m, true, 0});
  }
  return pieces;
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

void match_events(const Impacts& impacts, const std::vector<Touch>& touches, const MarkSet& marks,
                  const Options& options, const RetimeAt& retime_at, Certificate* certificate) {
  Certificate& c = *certificate;
  // What lies on a mark belongs to the transition before it.
  const RetimeAt retime_to = [&](double time_s) { return retime_at(time_s - options.time_tolerance_s); };
  const bool contact = options.events == Events::contact;
  std::vector<double> thresholds;
  const std::vector<Piece> pieces = contact
                                        ? contact_pieces(impacts, touches, retime_to, &thresholds, &c.hits)
                                        : audible_pieces(impacts, options, retime_to, &thresholds, &c.hits);
  std::vector<Reading> readings;
  std::size_t strict = 0;  // from here on, those without any piece that may be none
  for (const double threshold : thresholds) {
    strict = readings.size();
    for (const double margin : {kGapMargin, -kGapMargin})
      for (const bool before_retiming : {false, true})
        readings.push_back(read_pieces(pieces, {threshold, options.merge_gap_s, margin, before_retiming}));
  }
  const Reading& reported = readings.front();  // of all pieces, and the widest gap
  c.events = reported.events;
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (pieces[i].hit >= 0) c.hits[pieces[i].hit].event = reported.event_of[i];

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

  // Events that begin there are asked for: at a met mark, or within the span of one, whose chain may go on
  // beyond it.
  std::vector<double> asked = met;
  if (!contact)
    for (const Piece& p : pieces)
      if (in_marked_span(p.begin_s, marks, options.time_tolerance_s)) asked.push_back(p.begin_s);
  const double end = times.back() + (marks.durations_s.empty() ? 0.0 : marks.durations_s.back());
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const double time = pieces[i].begin_s;
    const bool starts_one = std::any_of(readings.begin() + strict, readings.end(), [&](const Reading& r) {
      return r.event_of[i] >= 0 && r.events[r.event_of[i]].time_s == time;
    });
    if (!starts_one) continue;
    if (!c.extra_events_s.empty() && c.extra_events_s.back() == time) continue;  // the impact of this touch
    const bool answers = std::any_of(readings.begin(), readings.end(), [&](const Reading& r) {
      return r.event_of[i] >= 0 &&
             std::find(asked.begin(), asked.end(), r.events[r.event_of[i]].time_s) != asked.end();
    });
    if (answers) continue;
    if (!marks.rest && time > end) continue;
    c.extra_events_s.push_back(time);
  }
  c.extra_hits = static_cast<int>(c.extra_events_s.size());
}

}  // namespace ifa::verify
