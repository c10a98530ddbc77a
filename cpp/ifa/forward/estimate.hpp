// What marks say before any search: closed forms, in microseconds.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "ifa/rigid/body.hpp"
#include "ifa/signature/marks.hpp"

namespace ifa {

struct Range {
  double least, most;
};

// The gap that leads from one mark to the next, as a single flight that begins where the first mark's span
// ends. All figures are of the vertical motion of the centre of mass. Nothing forces the body to fly: between
// marks it may also rest on an edge, rock or roll in silence, which takes less energy.
struct GapEstimate {
  double gap_s;     // from mark to mark
  double flight_s;  // the gap without the first mark's span
  // With the centre of mass as high at the landing as at the take-off, and the range that its heights in a
  // contact allow (Estimate::centre_height_m). A speed below 0 is a centre that already sinks.
  double takeoff_speed_m_s;
  Range takeoff_speed_range_m_s;
  double apex_m;  // how far the centre rises above its height at the take-off
  Range apex_range_m;
  // Vertical kinetic energy and weight times the height over the lowest centre: the least and the most such a
  // flight can have. `needed_j` is the largest least of this and all later gaps: what the body must have in
  // all, turning and travel included, to fly them. Energy can only be lost.
  double energy_j, most_energy_j, needed_j;
  // What the flight before cannot have had even if both gaps are retimed by 7 %: it comes from the body's
  // spin or travel, or must be given. 0: nothing.
  double surplus_j;
  std::optional<double> ratio;  // of the flight to the one before; none where there is none
};

struct Finding {
  std::size_t mark;  // index from 0
  std::string text;  // without the mark's name
};

struct Estimate {
  Range centre_height_m;  // of the centre of mass in a contact: the hull's least and largest reach
  bool ball;              // these are equal: no pose matters, and every bounce is the last one times e
  std::vector<GapEstimate> gaps;
  // To begin a material fit with. Exact for a ball, else a hint; friction is the body's own, since gaps do
  // not show it.
  double restitution, friction;
  bool restitution_from_gaps;  // else too few gaps, or the longest is the last: the body's own
  // Where the last gap is a flight and the last mark has no span: the bounce that would follow by
  // `restitution`. Rest is near unless more is left of that bounce, after a plausible change of the last
  // impact, than can end without another audible hit.
  std::optional<double> next_gap_s;
  bool rest_is_near;
  std::vector<Finding> findings;  // in the order of the marks
};

// Throws ArgumentError naming the mark or the argument: marks that `validate` refuses, a gap so long that its
// energy overflows, gravity that is not finite or does not
// point into the ground.
Estimate estimate(const Body& body, const Marks& marks, const Vec3& gravity_m_s2 = {0.0, 0.0, -9.81});

}  // namespace ifa
