// The contact problem at one instant: impulses at points of a body on the ground.
#pragma once

#include <vector>

#include "ifa/base/linear_algebra.hpp"

namespace ifa {

struct ContactPoint {
  Vec3 arm;                     // from the centre of mass to the contact point, world axes, m
  double target_speed = 0.0;    // least normal speed after, m/s: -e times the approach, or 0
  Vec3 impulse = Vec3::Zero();  // on the body, world axes, N s
  int vertex = -1;
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
class ContactSolver {
 public:
  void solve(const ContactBody& body, std::vector<ContactPoint>& points, Vec3& velocity,
             Vec3& angular_velocity, double tolerance, int max_sweeps);

 private:
  std::vector<Mat3> local_, local_inverse_;
};

}  // namespace ifa
