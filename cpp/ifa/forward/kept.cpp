#include "ifa/forward/kept.hpp"

#include <algorithm>
#include <cmath>
#include <ranges>
#include <vector>

#include "ifa/base/error.hpp"

namespace ifa {
namespace {

bool same_body(const Body& a, const Body& b) {
  const Material &m = a.material(), &n = b.material();
  const auto same_ring = [](const Ring& r, const Ring& s) {
    return r.centre_m == s.centre_m && r.axis == s.axis && r.radius_m == s.radius_m;
  };
  return a.mass_kg() == b.mass_kg() && a.radius_m() == b.radius_m() &&
         a.inertia_kg_m2() == b.inertia_kg_m2() && a.vertices() == b.vertices() &&
         std::ranges::equal(a.rings(), b.rings(), same_ring) && m.restitution == n.restitution &&
         m.friction == n.friction && m.rolling_friction_m == n.rolling_friction_m &&
         m.spin_friction_m == n.spin_friction_m;
}

bool same(const PositionConstraint& a, const PositionConstraint& b) { return a.position_m == b.position_m; }

bool same(const OrientationConstraint& a, const OrientationConstraint& b) {
  return a.body_direction == b.body_direction && a.direction == b.direction;
}

// Whether those of one mark are the same, in the same order.
template <class Kind>
bool same_at(const std::vector<Kind>& a, const std::vector<Kind>& b, std::size_t mark) {
  const auto at_mark = std::views::filter([mark](const Kind& c) { return c.mark == mark; });
  return std::ranges::equal(a | at_mark, b | at_mark,
                            [](const Kind& x, const Kind& y) { return same(x, y); });
}

}  // namespace

std::size_t marks_in_common(const Marks& a, const Marks& b) {
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  if (a.amplitudes.empty() != b.amplitudes.empty()) return 0;
  std::size_t k = 0;
  const auto same_constraints = [&](std::size_t mark) {
    return same_at(a.constraints.positions, b.constraints.positions, mark) &&
           same_at(a.constraints.orientations, b.constraints.orientations, mark);
  };
  while (k < std::min(a.size(), b.size()) && a.times_s[k] == b.times_s[k] &&
         a.durations_s[k] == b.durations_s[k] && same(a.centroids_s[k], b.centroids_s[k]) &&
         (a.amplitudes.empty() || a.amplitudes[k] == b.amplitudes[k]) && same_constraints(k))
    ++k;
  return k;
}

void check_reuse(const KeptSearch& kept, const Body& body, const SearchPhysics& physics, const Plan& plan) {
  if (!same_body(kept.bodies.front(), body)) throw ArgumentError("reuse: it is of another body or material");
  if (kept.physics.hearing.events != physics.hearing.events)
    throw ArgumentError("reuse: its events are of the other kind");
  if (kept.physics.energy_gain_j != physics.energy_gain_j)
    throw ArgumentError("reuse: its energy_gain_j was another one");
  if (kept.plan.on(Effect::material_fit) != plan.on(Effect::material_fit))
    throw ArgumentError("reuse: its material was chosen in the other way");
  if (!kept.plan.same_forced(plan)) throw ArgumentError("reuse: other effects were forced on or off");
}

}  // namespace ifa
