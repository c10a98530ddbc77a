#include "ifa/graph/shooting.hpp"

#include <cmath>
#include <numbers>

namespace ifa {

namespace {

constexpr int kMostNewtonSteps = 12, kMostHalvings = 3;
// A longer step than this turns the end by so much that the slope says nothing of it.
constexpr double kLongestStep_rad = 2.0;

// The axis of a constant spin is the target's, and there is a spin for each number of whole turns; at the
// identity any axis will do.
Vec3 constant_spin(const Quat& target, const Vec3& guess) {
  const Vec3 least = rotation_log(target);
  const double angle = least.norm(), speed = guess.norm();
  constexpr double kTurn = 2.0 * std::numbers::pi;
  if (angle == 0.0) return speed > 0.0 ? Vec3(kTurn * std::round(speed / kTurn) / speed * guess) : guess;
  const Vec3 axis = least / angle;
  return (angle + kTurn * std::round((guess.dot(axis) - angle) / kTurn)) * axis;
}

// From `shooting.spin_rad`; whether it converges. What it leaves is nearer to the target or the same.
bool newton(const lanes::BodyView& body, const Quat& target, double tolerance_rad, Shooting& shooting) {
  Turn turn = turn_with_slope(body, shooting.spin_rad);
  Vec3 error = rotation_log(target.conjugate() * turn.rotation);
  shooting.error_rad = error.norm();
  for (int i = 0; i < kMostNewtonSteps; ++i) {
    if (shooting.error_rad <= tolerance_rad) return true;
    // The target is turn exp(-error): no derivative of the logarithm is needed.
    Vec3 step = turn.slope.inverse() * -error;
    const double length = step.norm();
    if (!(length < 1e100)) return false;  // singular
    if (length > kLongestStep_rad) step *= kLongestStep_rad / length;
    ++shooting.iterations;
    bool shrank = false;
    for (int halving = 0; halving < kMostHalvings && !shrank; ++halving, step *= 0.5) {
      const Vec3 next = shooting.spin_rad + step;
      if (!(next.norm() <= kMostSpin_rad)) continue;
      const Turn there = turn_with_slope(body, next);
      const Vec3 left = rotation_log(target.conjugate() * there.rotation);
      shrank = left.norm() < 0.9 * shooting.error_rad;
      if (!shrank) continue;
      shooting.spin_rad = next;
      turn = there;
      error = left;
      shooting.error_rad = left.norm();
    }
    if (!shrank) return false;
  }
  return shooting.error_rad <= tolerance_rad;
}

}  // namespace

Shooting shoot(const lanes::BodyView& body, const Quat& target, const Vec3& guess, const Vec3& other_guess,
               double tolerance_rad) {
  Shooting shooting;
  shooting.spin_rad = guess;
  if (!body.couples_spin) {
    shooting.outcome = Shot::converged;
    shooting.spin_rad = constant_spin(target, guess);
    return shooting;
  }
  if (!(guess.norm() <= kMostSpin_rad) || !(other_guess.norm() <= kMostSpin_rad)) {
    shooting.outcome = Shot::too_fast;
    shooting.error_rad = std::numbers::pi;  // at most: to fly it would take long
    return shooting;
  }
  shooting.outcome = Shot::converged;
  if (newton(body, target, tolerance_rad, shooting)) return shooting;
  Shooting other{Shot::converged, other_guess, 0.0, shooting.iterations, 0.0};
  if (newton(body, target, tolerance_rad, other)) return other;
  Shooting best;
  for (const Vec3& start : {guess, other_guess}) {
    Shooting followed = follow(body, target, start);
    followed.iterations += other.iterations;
    if (followed.outcome == Shot::converged) return followed;
    if (followed.outcome == Shot::fold || best.outcome != Shot::fold) best = followed;
  }
  return best;
}

}  // namespace ifa
