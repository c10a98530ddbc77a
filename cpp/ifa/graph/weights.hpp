// The sound-independent half of an edge weight: how well one take-off can stand in for another (paper
// sections 5.3.1 and 5.4, with the errata of docs/graph.md).
#pragma once

#include "ifa/graph/nodes.hpp"
#include "ifa/signature/factors.hpp"

namespace ifa {

// Transitions with a factor below exp(-10) are not looked at (paper section 5.5, optional speedups).
inline constexpr double kLeastLogFactor = -10.0;

// Carries unit vector `from` to `to`.
Mat3 smallest_turn(const Vec3& from, const Vec3& to);

// Leaving take-off i so that the flight ends in the pose in which j's flight ended, j turned and moved on the
// plane to fit i best. In i's principal axes.
struct Splice {
  Vec3 velocity;     // v_blend: j's, and what makes up for the difference in height over the flight
  Vec3 spin;         // j's, registered; the connection's own is found when it is needed
  double excess;     // |C v_eval|^2, v_eval = (v_blend - v_i+, omega_j+ - omega_i+)
  double angle_rad;  // between the two orientations, after the best turn about the vertical
  double log_velocity, log_orientation;  // log f_v and log f_q

  double log_weight() const { return log_velocity + log_orientation; }
};

// `region` is i's, in its principal axes; `flight_s` j's. The state modulo heading is (up, v, omega, height):
// the turn that is left between the two is the smallest that carries j's up to i's.
Splice splice(const TakeOffView& i, const PlausibleRegion& region, const TakeOffView& j, double flight_s);

PlausibleRegion region_of(const Nodes& nodes, std::size_t i, const Body& body);

// Kinetic and potential, J.
double energy_j(const Body& body, double gravity_m_s2, const Vec3& velocity, const Vec3& spin,
                double height_m);
double onset_energy_j(const Nodes& nodes, std::size_t i, const Body& body, double gravity_m_s2);

// Whether such a splice from i to node `target` gains no energy, neither at i (f_E, paper eq. 10; a little
// stricter: against the energy before the last contact of i's event, not the first) nor at the target, that
// is left as it was in its own simulation.
bool keeps_energy(const Nodes& nodes, std::size_t i, std::size_t target, const Splice& s, const Body& body,
                  double gravity_m_s2, double gain_j = 0.0);

}  // namespace ifa
