#include "ifa/forward/estimate.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "ifa/base/error.hpp"
#include "ifa/base/message.hpp"
#include "ifa/signature/events.hpp"
#include "ifa/signature/factors.hpp"

namespace ifa {
namespace {

constexpr double kRetime = 1.07;               // the most that is still plausible (CONVENTIONS.md)
constexpr double kFastestThrow_m_s = 4.0;      // of the paper's samples (section 5.1)
constexpr double kRounding_s = 1e-9;           // of marks typed as decimals: spans that end at the next mark
constexpr double kBall = 1e-9;                 // of the radius; rounding, far below any real shape
constexpr Range kHintedRestitution{0.2, 0.8};  // where the hint was measured

Range centre_heights_m(const Body& body) {
  constexpr int kCorners =
      48;  // within the ring: the least height is never too large, 0.2 % too small at most
  std::vector<Vec3> points = body.vertices();
  for (const Vec3& p : ring_points(body.rings(), kCorners)) points.push_back(p);
  return {std::min(least_reach_m(points) + body.radius_m(), body.bounding_radius_m()),
          body.bounding_radius_m()};
}

// Rolls and bounces as a ball, whatever its moments are.
bool is_round(const Body& body) {
  return body.bounding_radius_m() - body.radius_m() <= kBall * body.radius_m();
}

// Vertical flights of length T from height z0 of the centre to z1, both in [low, low + spread]:
//   v = g T / 2 + (z1 - z0) / T
//   E / m = v^2 / 2 + g z0 = (g T)^2 / 8 + (z1 - z0)^2 / (2 T^2) + g (z0 + z1) / 2
struct Flights {
  double gravity_m_s2, mass_kg, spread_m;

  double takeoff_m_s(double flight_s, double rise_m) const {
    return 0.5 * gravity_m_s2 * flight_s + rise_m / flight_s;
  }
  double apex_m(double flight_s, double rise_m) const {
    const double v = takeoff_m_s(flight_s, rise_m);
    if (v >= gravity_m_s2 * flight_s) return rise_m;  // still rising when it lands
    return v > 0.0 ? 0.5 * v * v / gravity_m_s2 : 0.0;
  }
  // Above that of a centre at rest in its lowest place: least for z0 = z1 = low; most in a corner, since E is
  // convex.
  double least_energy_j(double flight_s) const {
    const double fall = gravity_m_s2 * flight_s;
    return 0.125 * mass_kg * fall * fall;
  }
  double most_energy_j(double flight_s) const {
    const double across = spread_m / flight_s, weight = gravity_m_s2 * spread_m;
    return least_energy_j(flight_s) + mass_kg * std::max(weight, 0.5 * (weight + across * across));
  }
};

GapEstimate estimate_gap(const Flights& flights, double gap_s, double span_s) {
  GapEstimate gap{};
  gap.gap_s = gap_s;
  const double t = gap_s - span_s;
  if (t < kRounding_s) return gap;  // no flight at all
  gap.flight_s = t;
  gap.takeoff_speed_m_s = flights.takeoff_m_s(t, 0.0);
  gap.takeoff_speed_range_m_s = {flights.takeoff_m_s(t, -flights.spread_m),
                                 flights.takeoff_m_s(t, flights.spread_m)};
  gap.apex_m = flights.apex_m(t, 0.0);
  gap.apex_range_m = {flights.apex_m(t, -flights.spread_m), flights.apex_m(t, flights.spread_m)};
  gap.energy_j = flights.least_energy_j(t);
  gap.most_energy_j = flights.most_energy_j(t);
  return gap;
}

// A ball's gaps are each the one before times e, so that those after the longest are e times those before the
// last. For other bodies the sum of Zeno's series, T e / (1 - e) after a gap T, is the better hint: over
// simulated throws of the library's bodies but the ball it is off by 0.15 on average, from 0.26 for a
// restitution of 0.2 to 0.05 for 0.8 (the median of the ratios: 0.23, from 0.46 to 0.02).
std::optional<double> restitution_of_gaps(const Body& body, const Marks& marks) {
  std::vector<double> gaps_s;
  for (std::size_t k = 1; k < marks.size(); ++k) gaps_s.push_back(marks.times_s[k] - marks.times_s[k - 1]);
  const auto longest = std::max_element(gaps_s.begin(), gaps_s.end());
  if (gaps_s.size() < 2 || longest + 1 == gaps_s.end()) return std::nullopt;
  const double after_s = std::accumulate(longest + 1, gaps_s.end(), 0.0);
  if (is_round(body)) return std::min(after_s / (*longest + (after_s - gaps_s.back())), 1.0);
  return std::clamp(after_s / (*longest + after_s), kHintedRestitution.least, kHintedRestitution.most);
}

std::vector<Finding> findings_of(const Estimate& e, Ending ending) {
  std::vector<Finding> findings;
  for (std::size_t k = 0; k < e.gaps.size(); ++k) {
    const GapEstimate& gap = e.gaps[k];
    if (gap.takeoff_speed_range_m_s.least > kFastestThrow_m_s)
      findings.push_back({k + 1, "the gap before it needs an apex of " + measure(gap.apex_m, "m") +
                                     " if the body flies, and a take-off at " + brief(gap.takeoff_speed_m_s) +
                                     " m/s"});
    if (gap.surplus_j > 0.0) {
      const std::string energy = "at least " + measure(gap.surplus_j, "J");
      std::string text =
          "the gap before it is " + brief(*gap.ratio) + " times as long as the one before that: ";
      if (e.ball)
        text += "a ball's bounces do not grow, so " + energy +
                " must be given, or be taken from its travel by changing the impact";
      else
        text += "if the body flies, " + energy +
                " must come from its spin or travel, or be given; it may also roll in between";
      findings.push_back({k + 1, std::move(text)});
    }
  }
  if (ending == Ending::rest && !e.rest_is_near)
    findings.push_back(
        {e.gaps.size(),
         "if the body flies up to it, it lands at " + brief(e.gaps.back().takeoff_speed_m_s) +
             " m/s and bounces again for " + measure(*e.next_gap_s, "s") +
             ", more than a plausible change of the impact takes away, but the ending asks for rest"});
  return findings;
}

}  // namespace

Estimate estimate(const Body& body, const Marks& marks, const Vec3& gravity_m_s2) {
  constexpr double kAnyGap_s = 0.0;  // whoever made the marks had a merge gap of their own
  validate(marks, kAnyGap_s);
  if (!gravity_m_s2.allFinite()) throw ArgumentError("gravity_m_s2: must be finite");
  if (!(gravity_m_s2.z() < 0.0)) throw ArgumentError("gravity_m_s2: must point into the ground");

  Estimate e{};
  e.centre_height_m = centre_heights_m(body);
  e.ball = is_round(body);
  const double spread_m = e.ball ? 0.0 : e.centre_height_m.most - e.centre_height_m.least;
  const Flights flights{-gravity_m_s2.z(), body.mass_kg(), spread_m};
  for (std::size_t k = 1; k < marks.size(); ++k) {
    GapEstimate gap =
        estimate_gap(flights, marks.times_s[k] - marks.times_s[k - 1], marks.durations_s[k - 1]);
    if (!std::isfinite(gap.most_energy_j))
      throw ArgumentError(mark_name(k, marks.times_s[k]) + ": the gap before it is too long to compute with");
    const double before_s = e.gaps.empty() ? 0.0 : e.gaps.back().flight_s;
    if (before_s > 0.0 && gap.flight_s > 0.0) {
      gap.ratio = gap.flight_s / before_s;
      // The most energy is convex in the squared length: largest at one end of what retiming allows.
      const double had_j =
          std::max(flights.most_energy_j(before_s * kRetime), flights.most_energy_j(before_s / kRetime));
      gap.surplus_j = std::max(0.0, flights.least_energy_j(gap.flight_s / kRetime) - had_j);
    }
    e.gaps.push_back(gap);
  }
  double needed_j = 0.0;
  for (auto gap = e.gaps.rbegin(); gap != e.gaps.rend(); ++gap)
    gap->needed_j = needed_j = std::max(needed_j, gap->energy_j);

  const std::optional<double> seen = restitution_of_gaps(body, marks);
  e.restitution = seen.value_or(body.material().restitution);
  e.friction = body.material().friction;
  e.restitution_from_gaps = seen.has_value();
  e.rest_is_near = true;
  if (!e.gaps.empty() && e.gaps.back().flight_s > 0.0 && marks.durations_s.back() == 0.0) {
    e.next_gap_s = e.restitution * e.gaps.back().flight_s;
    // What a plausible change of the last impact leaves of that bounce, if it is a ball's, must be silent.
    // Other bodies can also lose one that is no higher than their centre can sink by turning.
    const double v = e.gaps.back().takeoff_speed_m_s;
    const PlausibleRegion region({0.0, 0.0, (1.0 + e.restitution) * v}, Vec3::Zero(),
                                 body.bounding_radius_m());
    const double left_m_s = e.restitution * v - region.velocity_offset(Vec6::Unit(0)).norm();
    e.rest_is_near = left_m_s <= std::max(HearingOptions{}.audible_speed_m_s,
                                          std::sqrt(2.0 * flights.gravity_m_s2 * spread_m));
  }
  e.findings = findings_of(e, marks.ending);
  return e;
}

}  // namespace ifa
