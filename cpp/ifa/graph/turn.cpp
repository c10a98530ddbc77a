#include "ifa/graph/turn.hpp"

#include <algorithm>
#include <cmath>

// A turn and the one beside it that the slope's difference needs, flown side by side where every processor
// has the width for it. Either width gives the same bits.
#define IFA_LANES_NAMESPACE lanes_pair
#if defined(__x86_64__)
#define IFA_LANES_WIDTH 2
#else
#define IFA_LANES_WIDTH 1
#endif
#include "ifa/rigid/lanes/rotation.hpp"

namespace ifa {

namespace pair = lanes_pair;

namespace {

// Derivative of rotation_exp, as a turn in the axes it leads to.
Mat3 exp_slope(const Vec3& theta) {
  const double angle = theta.norm(), square = angle * angle;
  const bool small = angle < 1e-2;  // where the divisions would lose digits: the first terms left out are
                                    // below 1e-14
  const double a = small ? 0.5 - square / 24.0 + square * square / 720.0 : (1.0 - std::cos(angle)) / square;
  const double b = small ? 1.0 / 6.0 - square / 120.0 + square * square / 5040.0
                         : (angle - std::sin(angle)) / (square * angle);
  const Mat3 k = cross_matrix(theta);
  return Mat3::Identity() - a * k + b * k * k;
}

// The axis about which the body is symmetric in its moments, or -1.
int symmetry_axis(const lanes::BodyView& body) {
  for (int k = 0; k < 3; ++k) {
    const double i = body.inertia[(k + 1) % 3], j = body.inertia[(k + 2) % 3];
    if (std::abs(i - j) <= 1e-14 * i) return k;
  }
  return -1;
}

// Momentum L over the moment across the axis, then a turn about the axis: R = exp(L t / I) exp(rest t).
Turn symmetric_turn(const lanes::BodyView& body, int axis, const Vec3& spin, bool with_slope) {
  const double ratio = body.inertia[axis] / body.inertia[(axis + 1) % 3];
  Vec3 precession = spin;
  precession[axis] *= ratio;
  const Vec3 along = Vec3::Unit(axis);
  // 1 - ratio is exact where it is small (Sterbenz).
  const Quat own = rotation_exp((1.0 - ratio) * spin[axis] * along);
  Turn turn{rotation_exp(precession) * own, own.conjugate() * spin, Mat3::Zero()};
  if (with_slope) {
    turn.slope = own.conjugate().toRotationMatrix() * exp_slope(precession);
    turn.slope.col(axis) = ratio * turn.slope.col(axis) + (1.0 - ratio) * along;
  }
  return turn;
}

// A lane that has arrived is left alone.
template <int kCount>
void fly(const lanes::BodyView& body, const Vec3 (&spins)[kCount], Turn (&turns)[kCount]) {
  const pair::Pack one = pair::broadcast(1.0), zero = pair::broadcast(0.0);
  for (int first = 0; first < kCount; first += pair::kWidth) {
    pair::Pack3 spin;
    for (int l = 0; l < pair::kWidth; ++l) {
      const Vec3& w = spins[std::min(first + l, kCount - 1)];
      pair::set(spin.x, l, w.x()), pair::set(spin.y, l, w.y()), pair::set(spin.z, l, w.z());
    }
    pair::RotationSeries series;
    pair::Quaternion rotation{one, zero, zero, zero};
    for (pair::Pack start = zero; pair::any(start < one);) {
      const pair::Mask open = start < one;
      series.expand(body, start, rotation, spin, open);
      const pair::Pack end = pair::least(start + series.length_s, one);
      const auto values = series.at(end);
      rotation = pair::select(open, series.orientation(values), rotation);
      spin = pair::select(open, series.spin(values), spin);
      start = pair::select(open, end, start);
    }
    for (int l = 0; l < pair::kWidth && first + l < kCount; ++l) {
      turns[first + l].rotation = {pair::get(rotation.w, l), pair::get(rotation.x, l),
                                   pair::get(rotation.y, l), pair::get(rotation.z, l)};
      turns[first + l].spin_rad = {pair::get(spin.x, l), pair::get(spin.y, l), pair::get(spin.z, l)};
    }
  }
}

// Euler's equations.
Vec3 spin_rate(const lanes::BodyView& body, const Vec3& w) {
  const double* i = body.inertia;
  return {(i[1] - i[2]) / i[0] * w.y() * w.z(), (i[2] - i[0]) / i[1] * w.z() * w.x(),
          (i[0] - i[1]) / i[2] * w.x() * w.y()};
}

// Two of three directions need no difference. A spin times 1 + s is the same flight taken 1 + s times as
// long; and a spin moved along Euler's flow by s begins and ends the same flight later by s. Where the spin
// stays so near to a principal axis that this shift is lost in rounding, the second is a difference too.
Turn triaxial_turn(const lanes::BodyView& body, const Vec3& spin) {
  const double speed = spin.norm();
  if (speed < 1e-7) {  // the slope is 1 to this order
    Turn turn = turn_of(body, spin);
    turn.slope.setIdentity();
    return turn;
  }
  Turn turn[2];
  const double step = 1e-7 * (1.0 + speed);  // about the root of rounding: both errors are near 1e-7
  const auto slope_from = [&](const Turn& moved) -> Vec3 {
    const Quat q = turn[0].rotation.conjugate() * moved.rotation;
    return (q.w() < 0.0 ? -2.0 : 2.0) / step * q.vec();
  };
  Mat3 axes, slopes;
  axes.col(0) = spin / speed;
  const Vec3 rate = spin_rate(body, spin);
  const double along = rate.dot(axes.col(0));
  const Vec3 across = rate - along * axes.col(0);
  const double size = across.norm();
  const bool shifts = size > 1e-6 * speed;
  axes.col(1) = shifts ? Vec3(across / size) : Vec3(axes.col(0).unitOrthogonal());
  axes.col(2) = axes.col(0).cross(axes.col(1));
  fly(body, {spin, spin + step * axes.col(2)}, turn);
  slopes.col(0) = turn[0].spin_rad / speed;
  slopes.col(2) = slope_from(turn[1]);
  if (shifts) {
    slopes.col(1) = (turn[0].spin_rad - turn[0].rotation.conjugate() * spin - along * slopes.col(0)) / size;
  } else {
    slopes.col(1) = slope_from(turn_of(body, spin + step * axes.col(1)));
  }
  turn[0].slope = slopes * axes.transpose();
  return turn[0];
}

}  // namespace

Turn turn_with_slope(const lanes::BodyView& body, const Vec3& spin) {
  if (!body.couples_spin) return {rotation_exp(spin), spin, exp_slope(spin)};
  const int axis = symmetry_axis(body);
  return axis < 0 ? triaxial_turn(body, spin) : symmetric_turn(body, axis, spin, true);
}

Turn turn_of(const lanes::BodyView& body, const Vec3& spin) {
  if (!body.couples_spin) return {rotation_exp(spin), spin, Mat3::Zero()};
  const int axis = symmetry_axis(body);
  if (axis >= 0) return symmetric_turn(body, axis, spin, false);
  Turn turn[1];
  fly(body, {spin}, turn);
  return turn[0];
}

}  // namespace ifa
