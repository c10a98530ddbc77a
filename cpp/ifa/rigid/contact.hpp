// The contact problem at one instant: impulses at points of a body on the ground. What the event engine does
// for a pack of simulations (lanes/contacts.hpp, lanes/impact.hpp), here for one.
#pragma once

#include <vector>

#include "ifa/base/linear_algebra.hpp"
#include "ifa/rigid/body.hpp"
#include "ifa/rigid/state.hpp"

namespace ifa {

struct ContactPoint {
  Vec3 arm;                     // from the centre of mass to the contact point, world axes, m
  double target_speed = 0.0;    // least normal speed after, m/s: -e times the approach, or 0
  Vec3 impulse = Vec3::Zero();  // on the body, world axes, N s
};

// What the impulses act on, at one pose.
struct ContactBody {
  double mass_kg;
  Mat3 inverse_inertia;  // world axes
  double friction;
  double rolling_friction_m = 0.0, spin_friction_m = 0.0;
};

// Finds impulses with v_n >= target, J_n >= 0, complementary, |J_t| <= mu J_n, and J_t = -mu J_n along the
// remaining slip where it slips (Coulomb's law, a true cone), by block Gauss-Seidel with an exact solve at
// each point; a single point takes one sweep. Rolling and spin friction are torques about the horizontal and
// the vertical, at most their length times the normal impulse. Sweeps begin from the points' impulses; all
// zero, three points or more begin from an even share. Changes velocity and angular velocity in place.
// `tolerance` is the largest change of any velocity (m/s, and rad/s times the arm) in the last sweep.
void solve_contacts(const ContactBody& body, std::vector<ContactPoint>& points, Vec3& velocity,
                    Vec3& angular_velocity, double tolerance, int max_sweeps);

// Resolves the impact of `state` at `points`: a Newton target -e v_n at each point that approaches faster
// than `micro_speed`, Coulomb's cone, and where the kinetic energy would grow, the whole impulse blended
// towards that of e = 0 until it does not. Changes `state`, and the points' impulses.
struct ImpactResult {
  Vec3 impulse_n_s = Vec3::Zero();
  Vec3 position_m = Vec3::Zero();  // centre of the normal impulses
};
ImpactResult resolve_impact(const Body& body, double micro_speed, std::vector<ContactPoint>& points,
                            State& state);

Mat3 inverse_inertia_world(const Body& body, const Quat& orientation);
double kinetic_energy(const Body& body, const State& state);

}  // namespace ifa
