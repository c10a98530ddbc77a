#include <algorithm>
#include <cmath>

#include "ifa/base/error.hpp"
#include "ifa/base/message.hpp"
#include "ifa/verify/certificate.hpp"
#include "ifa/verify/events.hpp"
#include "ifa/verify/physics.hpp"

namespace ifa::verify {
namespace {

constexpr double kUnitTolerance = 1e-6;      // single precision
constexpr double kGravityTolerance = 1e-3;   // relative; 1e-6 is a double-precision exporter's, 5e-3 visible
constexpr double kMomentumTolerance = 1e-3;  // relative, likewise
constexpr double kStepSlack = 1e-6;          // relative, of the largest step: rounding of times
constexpr double kShortestStep = 1e-9;       // s: rounding of 1e-16 m is then 1e-7 m/s
constexpr int kListed = 10;                  // failures of one kind that are spelled out

void require(bool fine, const std::string& message) {
  if (!fine) throw ArgumentError(message);
}

void check_arguments(const Poses& poses, const MarkSet& marks, const Claims& claims, const Options& o) {
  const std::size_t n = poses.times_s.size();
  require(poses.positions_m.size() == n,
          "positions_m: needs one row for each of the " + std::to_string(n) + " times");
  require(poses.orientations.size() == n,
          "quaternions_wxyz: needs one row for each of the " + std::to_string(n) + " times");
  const std::size_t m = marks.times_s.size();
  require(m > 0, "marks: there are none");
  require(marks.durations_s.empty() || marks.durations_s.size() == m, "durations_s: needs one for each mark");
  for (std::size_t k = 0; k < m; ++k) {
    require(std::isfinite(marks.times_s[k]), "mark " + std::to_string(k + 1) + ": its time is not finite");
    require(k == 0 || marks.times_s[k] > marks.times_s[k - 1],
            mark_name(k, marks.times_s[k]) + " is not later than the mark before it");
    require(marks.durations_s.empty() || (std::isfinite(marks.durations_s[k]) && marks.durations_s[k] >= 0.0),
            mark_name(k, marks.times_s[k]) + ": its duration must be at least 0");
  }
  require(claims.retime.empty() || claims.retime.size() == m,
          "retime: needs one ratio for each of the " + std::to_string(m) + " marks");
  for (std::size_t k = 0; k < claims.retime.size(); ++k)
    require(std::isfinite(claims.retime[k]) && claims.retime[k] > 0.0,
            "retime: the ratio of " + mark_name(k, marks.times_s[k]) + " must be above 0");
  require(std::isfinite(claims.energy_gain_j) && claims.energy_gain_j >= 0.0,
          "energy_gain_j: must be at least 0");
  const std::pair<const char*, double> positive[] = {{"audible_speed_m_s", o.audible_speed_m_s},
                                                     {"merge_gap_s", o.merge_gap_s},
                                                     {"gravity_m_s2", o.gravity_m_s2},
                                                     {"rest_speed_m_s", o.rest_speed_m_s},
                                                     {"rest_duration_s", o.rest_duration_s},
                                                     {"time_tolerance_s", o.time_tolerance_s},
                                                     {"penetration_limit_m", o.penetration_limit_m},
                                                     {"retime_limit", o.retime_limit},
                                                     {"max_step_s", o.max_step_s}};
  for (const auto& [name, value] : positive)
    require(std::isfinite(value) && value > 0.0, std::string(name) + ": must be above 0");
  require(o.speed_margin >= 0.0 && o.speed_margin < 1.0, "speed_margin: must be in [0, 1)");
}

// Collects failures; of one kind, the first few are spelled out.
class Failures {
 public:
  explicit Failures(std::vector<std::string>* list) : list_(list) {}
  void begin_kind() { count_ = 0; }
  void add(const std::string& sentence) {
    if (++count_ <= kListed) list_->push_back(sentence);
  }
  void end_kind() {
    if (count_ > kListed) list_->push_back("and " + std::to_string(count_ - kListed) + " more of this kind");
  }

 private:
  std::vector<std::string>* list_;
  int count_ = 0;
};

// Whether the poses are such that anything can be computed from them.
bool check_poses(const Poses& poses, Certificate* c) {
  const std::size_t n = poses.times_s.size();
  const std::size_t before = c->failures.size();
  if (n < 3) c->failures.push_back("the motion has " + std::to_string(n) + " samples, too few to check");
  const auto sample = [&](std::size_t i) { return "sample " + std::to_string(i); };
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(poses.times_s[i]) || !poses.positions_m[i].allFinite() ||
        !poses.orientations[i].coeffs().allFinite()) {
      c->failures.push_back(sample(i) + " holds a number that is not finite");
      break;
    }
    if (i > 0 && poses.times_s[i] <= poses.times_s[i - 1]) {
      c->failures.push_back(sample(i) + " at " + seconds(poses.times_s[i]) +
                            " is not later than the one before it");
      break;
    }
    if (std::abs(poses.orientations[i].norm() - 1.0) > kUnitTolerance) {
      c->failures.push_back(sample(i) + " at " + seconds(poses.times_s[i]) + " has a quaternion of length " +
                            number(poses.orientations[i].norm()) + " instead of 1");
      break;
    }
  }
  return c->failures.size() == before;
}

// Unit quaternions, and of samples so near to each other that no velocity comes out, the first.
Poses usable(const Poses& given) {
  Poses poses;
  for (std::size_t i = 0; i < given.times_s.size(); ++i) {
    if (i > 0 && given.times_s[i] - poses.times_s.back() < kShortestStep) continue;
    poses.times_s.push_back(given.times_s[i]);
    poses.positions_m.push_back(given.positions_m[i]);
    poses.orientations.push_back(given.orientations[i].normalized());
  }
  return poses;
}

void judge_marks(const MarkSet& marks, const Claims& claims, const Options& options, Certificate* c) {
  const bool contact = options.events == Events::contact;
  Failures failures(&c->failures);
  failures.begin_kind();
  for (std::size_t k = 0; k < c->marks.size(); ++k) {
    const MarkCheck& m = c->marks[k];
    if (!m.matched)
      failures.add(mark_name(k, m.target_s) +
                   (contact ? ": no contact begins near it" : " has no audible hit near it"));
    else if (std::abs(m.error_s) > options.time_tolerance_s)
      failures.add(mark_name(k, m.target_s) + " is met " + number(1e3 * std::abs(m.error_s)) + " ms " +
                   (m.error_s > 0.0 ? "late" : "early"));
  }
  failures.end_kind();
  failures.begin_kind();
  for (const double t : c->extra_events_s)
    failures.add((contact ? "a contact that begins at " : "an audible hit at ") + seconds(t) +
                 " answers no mark");
  failures.end_kind();
  for (std::size_t k = 0; k < claims.retime.size(); ++k)
    if (std::abs(claims.retime[k] - 1.0) > options.retime_limit * (1.0 + 1e-9))
      c->failures.push_back("the transition to " + mark_name(k, marks.times_s[k]) +
                            " is retimed by the ratio " + number(claims.retime[k]));
}

void judge_flights(const std::vector<Flight>& flights, const Options& options, Certificate* c) {
  Failures failures(&c->failures);
  failures.begin_kind();
  for (const Flight& f : flights) {
    const FlightCheck& check = f.check;
    c->flights.push_back(check);
    c->max_gravity_error = std::max(c->max_gravity_error, check.gravity_error);
    c->max_horizontal_acceleration_m_s2 =
        std::max(c->max_horizontal_acceleration_m_s2, check.horizontal_acceleration_m_s2);
    c->max_momentum_drift = std::max(c->max_momentum_drift, check.momentum_drift);
    const std::string name = "the flight from " + seconds(check.start_s) + " to " + seconds(check.end_s);
    if (check.gravity_error > kGravityTolerance)
      failures.add(name + " departs from its parabola under gravity by " +
                   number(100.0 * check.gravity_error) + " %");
    if (check.horizontal_acceleration_m_s2 > kGravityTolerance * options.gravity_m_s2)
      failures.add(name + " accelerates horizontally by " + number(check.horizontal_acceleration_m_s2) +
                   " m/s^2");
    if (check.momentum_drift > kMomentumTolerance)
      failures.add(name + " changes its angular momentum by " + number(100.0 * check.momentum_drift) + " %");
  }
  failures.end_kind();
}

bool stands_long_enough(const Rest& rest, double end_s, const Options& options) {
  return end_s - rest.since_s >= options.rest_duration_s * (1.0 - 1e-9);
}

void judge_rest(const Rest& rest, double end, const MarkSet& marks, const Options& options, Certificate* c) {
  if (!marks.rest || c->at_rest) return;
  if (stands_long_enough(rest, end, options))
    c->failures.push_back("the body stands still from " + seconds(rest.since_s) +
                          " where nothing supports its mass centre");
  else
    c->failures.push_back("the body is not at rest at the end: at " + seconds(rest.since_s) +
                          " a point still moves at " + number(rest.last_speed_m_s) +
                          " m/s, and the motion ends at " + seconds(end));
}

}  // namespace

Certificate verify(const Poses& given, const Body& body, const MarkSet& marks, const Claims& claims,
                   const Options& options) {
  check_arguments(given, marks, claims, options);
  Certificate c;
  Poses poses;
  if (check_poses(given, &c)) {
    poses = usable(given);
    if (poses.times_s.size() < 3) c.failures.push_back("the motion is too short to check");
  }
  if (!c.failures.empty()) {
    for (const double t : marks.times_s) c.marks.push_back({t, false, 0.0, 0.0});
    c.missed_hits = static_cast<int>(marks.times_s.size());
    return c;
  }
  const Track track(poses, body, options.gravity_m_s2);

  Failures failures(&c.failures);
  failures.begin_kind();
  for (int j = 0; j + 1 < track.size(); ++j)
    if (track.step(j) > options.max_step_s * (1.0 + kStepSlack) + 1e-9)
      failures.add("sampled too coarsely at " + seconds(track.time(j)) + ": a step of " +
                   number(1e3 * track.step(j)) + " ms");
  failures.end_kind();
  failures.begin_kind();
  for (const int j : find_jumps(track)) failures.add("the body jumps at " + seconds(track.time(j)));
  failures.end_kind();

  const double end = track.time(track.size() - 1);
  const Rest rest = find_rest(track, options.rest_speed_m_s);
  c.at_rest = rest.supported && stands_long_enough(rest, end, options);
  c.rest_s = c.at_rest ? rest.since_s : end;

  const Impacts impacts = find_impacts(track);
  // Which events answer the marks is not known yet: transitions end at the marks.
  const RetimeAt retime_by_marks = [&](double time_s) {
    for (std::size_t k = 0; k < claims.retime.size(); ++k)
      if (time_s <= marks.times_s[k]) return claims.retime[k];
    return 1.0;
  };
  std::vector<Touch> touches;
  if (options.events == Events::contact)
    touches = find_touches(track, impacts, options, retime_by_marks, c.rest_s);
  match_events(impacts, touches, marks, options, retime_by_marks, &c);
  judge_marks(marks, claims, options, &c);

  // Transitions end at the events found; where a mark has none, at the mark.
  const RetimeAt retime_at = [&](double time_s) {
    for (std::size_t k = 0; k < claims.retime.size(); ++k)
      if (time_s <= (c.marks[k].matched ? c.marks[k].achieved_s : c.marks[k].target_s))
        return claims.retime[k];
    return 1.0;
  };
  const auto flights = find_flights(track, impacts, options.gravity_m_s2, retime_at);
  judge_flights(flights, options, &c);

  const EnergyGain gain =
      energy_gain(track, impacts, flights, options.gravity_m_s2, claims.energy_gain_j, retime_at);
  c.max_energy_gain_j = gain.largest_j;
  c.max_contact_energy_gain_j = gain.contact_j;
  if (gain.flights_j > 0.0)
    c.failures.push_back("the energy grows by " + number(gain.flights_j) + " J before " +
                         seconds(gain.flights_time_s) + ", where " + number(gain.flights_tolerance_j) +
                         " J is allowed");
  if (gain.contact_j > 0.0)
    c.failures.push_back("the energy grows by more than " + number(gain.contact_j) + " J in contact before " +
                         seconds(gain.contact_time_s));

  find_penetration(track, impacts, options.penetration_limit_m, options.gravity_m_s2, &c.max_penetration_m,
                   &c.max_penetration_time_s);
  if (c.max_penetration_m > options.penetration_limit_m)
    c.failures.push_back("the body is " + number(1e3 * c.max_penetration_m) + " mm in the ground at " +
                         seconds(c.max_penetration_time_s));
  judge_rest(rest, end, marks, options, &c);
  c.passed = c.failures.empty();
  return c;
}

}  // namespace ifa::verify
