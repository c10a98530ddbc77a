#include "ifa/forward/candidate.hpp"

#include <algorithm>

namespace ifa {

double Problem::travel_budget_m_s(int body, std::size_t k) const {
  if (physics.hearing.events != Events::contact || marks.ending != Ending::rest) return kNever;
  const double g = physics.simulation.gravity_m_s2.norm();
  const Material& material = bodies[static_cast<std::size_t>(body)].material();
  double normal_m_s = g * marks.durations_s[k];  // impulse over mass
  for (std::size_t j = k + 1; j < marks.size(); ++j) {
    const double flight_s = marks.times_s[j] - marks.times_s[j - 1] - marks.durations_s[j - 1];
    normal_m_s += g * marks.durations_s[j] + 0.5 * (1.0 + material.restitution) * g * flight_s;
  }
  constexpr double kRolled_m_s = 0.1;  // edges take more than friction does
  return material.friction * normal_m_s + kRolled_m_s;
}

void Candidate::constrain(const Problem& problem, std::size_t k) {
  const Constraints& asked = problem.marks.constraints;
  if (!problem.plan.constrains()) return;
  const Body& own = problem.bodies[static_cast<std::size_t>(body)];
  alignment.add(asked, k, own, onset.before);
  log_constraints = -alignment.cost();
  const Placement placement = alignment.best();
  for (const OrientationConstraint& c : asked.orientations) {
    if (c.mark != k) continue;
    const Vec3 now = placement.turned(seen(own, onset.before, c.body_direction));
    if (orientation_constraint_factor(angle_between_rad(now, c.direction)) < kMetFactor) ++unmet;
  }
}

double Candidate::log_rest(const Problem& problem, const Passage& passage) const {
  if (!problem.plan.constrains()) return 0.0;
  Alignment at_rest = alignment;
  at_rest.add(problem.marks.constraints, kAtRest, problem.bodies[static_cast<std::size_t>(body)],
              passage.end);
  return std::min(0.0, alignment.cost() - at_rest.cost());
}

}  // namespace ifa
