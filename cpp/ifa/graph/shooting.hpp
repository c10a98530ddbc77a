// Torque-free turns from one orientation to another, by shooting.
#pragma once

#include "ifa/graph/turn.hpp"

namespace ifa {

// The largest spin that is followed, |w| T: in half a second, 300 turns a second.
inline constexpr double kMostSpin_rad = 1000.0;

enum class Shot { converged, fold, too_fast, stalled };

struct Shooting {
  Shot outcome = Shot::stalled;
  Vec3 spin_rad = Vec3::Zero();  // where it has not converged: the nearest that was found
  double error_rad = 0.0;        // angle between the end and the target
  int iterations = 0;            // of Newton's method; of the continuation: its steps
  double fold_at = 0.0;          // where the outcome is a fold: the share of the way at which it lies
};

// So that 1e-10 holds with the rounding of such a flight.
inline constexpr double kShootingTolerance_rad = 5e-11;

// A spin near `guess_rad` that turns the body by `target`, to within `tolerance_rad`; what takes a
// continuation is always found to kShootingTolerance_rad. Newton's method on the rotation vector from the
// target to where the flight ends, from the guess, and where that does not converge from `other_guess_rad`,
// the spin of a flight that is known to end near the target; then continuation, likewise. A fold is what none
// of these passes and one of the two curves is certified to have.
//
// Many spins end there, with more or fewer windings. It is one that a guess leads to while the end is turned
// into the target along the shortest arc: steps are bounded and the error may only shrink, so that it never
// passes pi, where its branch would change.
Shooting shoot(const lanes::BodyView& body, const Quat& target, const Vec3& guess_rad,
               const Vec3& other_guess_rad, double tolerance_rad = kShootingTolerance_rad);

// Follows the spin from `start_rad` while the target moves, along the shortest arc, from where that spin ends
// (0) to `target` (1), by pseudo-arclength (Keller 1977): so the curve (spin, share of the way) can be
// followed around where the share turns back. There, at a fold, two spins merge, the slope is singular, and
// no spin continues the guess's. A fold is certified by three successive points of the curve, each exact to
// 1e-11 rad: the share of the middle one is less than 1, and beyond that of the other two by more than 100
// times their error. That is numerical, not a proof; and it says that the curve ends before the target, not
// that no other spin reaches it.
Shooting follow(const lanes::BodyView& body, const Quat& target, const Vec3& start_rad);

}  // namespace ifa
