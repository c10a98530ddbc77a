#include <algorithm>
#include <cmath>

#include "ifa/graph/shooting.hpp"

namespace ifa {
namespace {

using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

constexpr double kOnCurve_rad = 1e-11;   // of what certifies a fold
constexpr double kNearCurve_rad = 1e-5;  // of steps along it: they only lead there
constexpr double kAtTarget_rad = 1e-6;   // a fold nearer to the target than this is not told from one at it
constexpr int kMostCorrections = 5;

struct Point {
  Vec4 at = Vec4::Zero();       // spin, and how far the target has moved, all rad
  Vec4 tangent = Vec4::Zero();  // of length 1
};

// The curve of those (spin, way) whose flight ends at the moved target.
class Curve {
 public:
  Curve(const lanes::BodyView& body, const Quat& from, const Vec3& back) : body_(body), from_(from) {
    length_ = back.norm();
    axis_ = back / length_;
  }

  double length() const { return length_; }

  // The point of the curve on the plane through `guess` across `forward`; its tangent points forward too.
  bool meet(const Vec4& guess, const Vec4& forward, double tolerance_rad, Point& point) const {
    Vec4 at = guess;
    for (int i = 0; i < kMostCorrections; ++i) {
      if (!(at.head<3>().norm() <= kMostSpin_rad)) return false;
      const Turn turn = turn_with_slope(body_, at.head<3>());
      const Vec3 error = rotation_log((from_ * rotation_exp(-at[3] * axis_)).conjugate() * turn.rotation);
      if (error.norm() <= tolerance_rad) {
        point = {at, tangent(turn.slope, forward)};
        return true;
      }
      Mat4 system;
      system << turn.slope, axis_, forward.transpose();
      const Vec4 step = system.partialPivLu().solve((Vec4() << -error, 0.0).finished());
      if (!(step.norm() < 1.0)) return false;
      at += step;
    }
    return false;
  }

  // The null direction of [slope | axis], from its minors: well defined at a fold too. Its last component has
  // the sign of the slope's determinant, or the opposite all along.
  Vec4 tangent(const Mat3& slope, const Vec4& forward) const {
    Vec4 t;
    t[3] = slope.determinant();
    for (int k = 0; k < 3; ++k) {
      Mat3 minor = slope;
      minor.col(k) = axis_;
      t[k] = -minor.determinant();  // Cramer's rule for slope x = -axis
    }
    t.normalize();
    return t.dot(forward) < 0.0 ? Vec4(-t) : t;
  }

 private:
  const lanes::BodyView& body_;
  Quat from_;
  Vec3 axis_;  // the target moves about its opposite
  double length_;
};

// Where the way has its maximum between `here` and `there`, a step ahead: by regula falsi (Illinois) on its
// rate. Sure if two points beside it, exact like itself, have clearly come less far.
bool turns_back(const Curve& curve, const Point& here, const Point& there, double step, Point& top) {
  constexpr double kFlat = 1e-4;
  double low = 0.0, high = step, rate_low = here.tangent[3], rate_high = there.tangent[3], at = 0.0;
  bool rose = false;
  top = here;
  for (int i = 0; i < 30 && std::abs(top.tangent[3]) > kFlat; ++i) {
    at = (low * rate_high - high * rate_low) / (rate_high - rate_low);
    if (!curve.meet(here.at + at * here.tangent, here.tangent, kOnCurve_rad, top)) return false;
    const bool rises = top.tangent[3] > 0.0;
    (rises ? low : high) = at;
    (rises ? rate_low : rate_high) = top.tangent[3];
    if (i > 0 && rises == rose) (rises ? rate_high : rate_low) *= 0.5;
    rose = rises;
  }
  for (const double aside : {1e-2, 1e-3, 1e-4}) {
    Point before, after;
    if (curve.meet(top.at - aside * top.tangent, top.tangent, kOnCurve_rad, before) &&
        curve.meet(top.at + aside * top.tangent, top.tangent, kOnCurve_rad, after) &&
        top.at[3] - std::max(before.at[3], after.at[3]) > 100.0 * kOnCurve_rad)
      return true;
  }
  return false;
}

// Newton's method from a point of the curve that is near the target.
bool finish(const lanes::BodyView& body, const Quat& target, Vec3 spin, Shooting& shooting) {
  for (int i = 0; i < 8; ++i) {
    const Turn turn = turn_with_slope(body, spin);
    const Vec3 error = rotation_log(target.conjugate() * turn.rotation);
    if (error.norm() <= kShootingTolerance_rad) {
      shooting.outcome = Shot::converged;
      shooting.spin_rad = spin;
      shooting.error_rad = error.norm();
      return true;
    }
    const Vec3 step = turn.slope.inverse() * -error;
    if (!(step.norm() < 1.0)) return false;
    spin += step;
  }
  return false;
}

}  // namespace

Shooting follow(const lanes::BodyView& body, const Quat& target, const Vec3& start) {
  constexpr int kMostSteps = 150;
  constexpr double kFirstStep = 0.2, kLeastStep = 1e-6;
  Shooting shooting;
  shooting.spin_rad = start;
  const Turn begin = turn_with_slope(body, start);
  const Vec3 back = rotation_log(target.conjugate() * begin.rotation);
  shooting.error_rad = back.norm();
  if (shooting.error_rad <= kShootingTolerance_rad) {
    shooting.outcome = Shot::converged;
    return shooting;
  }
  const Curve curve(body, begin.rotation, back);
  Point here;
  here.at << start, 0.0;
  here.tangent = curve.tangent(begin.slope, Vec4::UnitW());
  double step = kFirstStep;
  for (; shooting.iterations < kMostSteps && step >= kLeastStep; ++shooting.iterations) {
    Point next;
    // A sharp bend within a step may hide another branch: take it in smaller ones.
    if (!curve.meet(here.at + step * here.tangent, here.tangent, kNearCurve_rad, next) ||
        next.tangent.dot(here.tangent) < 0.9) {
      step *= 0.5;
      continue;
    }
    if (next.tangent[3] <= 0.0) {
      Point top;
      if (!turns_back(curve, here, next, step, top)) {
        step *= 0.5;
        continue;
      }
      if (top.at[3] < curve.length() - kAtTarget_rad) {
        shooting.outcome = Shot::fold;
        shooting.spin_rad = top.at.head<3>();
        shooting.error_rad = curve.length() - top.at[3];
        shooting.fold_at = top.at[3] / curve.length();
        return shooting;
      }
      next = top;  // beyond the target
    }
    if (next.at[3] >= curve.length()) {
      const double share = (curve.length() - here.at[3]) / (next.at[3] - here.at[3]);
      const Vec4 guess = here.at + share * (next.at - here.at);
      if (finish(body, target, guess.head<3>(), shooting)) return shooting;
      step *= 0.5;
      continue;
    }
    here = next;
    step *= 1.5;
  }
  shooting.spin_rad = here.at.head<3>();
  shooting.error_rad = std::abs(curve.length() - here.at[3]);
  return shooting;
}

}  // namespace ifa
