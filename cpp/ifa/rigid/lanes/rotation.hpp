// Torque-free rotation as power series.
#pragma once

#include "ifa/rigid/lanes/effects.hpp"

namespace ifa::IFA_LANES_NAMESPACE {

// The rotation is split by its conserved momentum. With l the momentum's unit vector in principal axes,
//   R(t) = R(0) Rot(l0, psi) A,   A the least rotation that takes l(t) to l0,
//   psi' = omega . (l + l0) / (1 + l . l0),   omega . l = 2 E / |L| for good,
// so that beside Euler's equations for omega only the one angle psi needs a series, and the momentum's
// direction in the world holds to rounding. Time x counts from the piece's start in units of 1 / |omega0|, so
// that no coefficient over- or underflows. Order 16; a piece ends where its last two terms reach 3e-15, and
// at x = 1.5, where l has turned by less than 90 degrees.
struct RotationSeries {
  static constexpr int kOrder = 16;

  Pack start_s, length_s, rate;
  Quaternion start;  // R(0)
  Pack3 up0;         // the ground's normal in principal axes at the start
  Pack3 l0, gain;    // l = gain * omega / rate, component by component
  Pack wx[kOrder + 1], wy[kOrder + 1], wz[kOrder + 1], psi[kOrder + 1];

  // `spin` in principal axes. Counts those of `where`.
  void expand(const BodyView& body, Pack start_time_s, const Quaternion& orientation, const Pack3& spin,
              Mask where);

  struct Values {
    Pack3 spin;  // over `rate`
    Pack3 l;
    Pack psi;
  };
  Values at(Pack time_s) const;
  Pack3 up(const Values& v) const;
  Quaternion orientation(const Values& v) const;
  Pack3 spin(const Values& v) const { return rate * v.spin; }
};

inline void RotationSeries::expand(const BodyView& body, Pack start_time_s, const Quaternion& orientation,
                                   const Pack3& spin0, Mask where) {
  count(Effect::spin_coupling, where);
  const Pack one = broadcast(1.0), zero = broadcast(0.0);
  start_s = start_time_s;
  start = orientation;
  up0 = rotation(orientation).up();
  const double ix = body.inertia[0], iy = body.inertia[1], iz = body.inertia[2];
  const Pack speed = norm(spin0);
  rate = select(speed > zero, speed, one);
  const Pack3 w = (one / rate) * spin0;
  const Pack3 momentum{ix * w.x, iy * w.y, iz * w.z};
  const Pack size = norm(momentum);
  const Pack inverse = select(size > zero, one / size, zero);
  l0 = inverse * momentum;
  gain = {ix * inverse, iy * inverse, iz * inverse};
  const Pack twice_energy = dot(w, l0);  // over |L|
  const double ax = (iy - iz) / ix, ay = (iz - ix) / iy, az = (ix - iy) / iz;
  const Pack3 tilt{l0.x * gain.x, l0.y * gain.y, l0.z * gain.z};
  Pack part[kOrder + 1], rise[kOrder];  // of 1 + l . l0, and of psi'
  wx[0] = w.x, wy[0] = w.y, wz[0] = w.z, psi[0] = zero;
  const Pack half = one / (one + dot(l0, l0));
  // Unrolled: loops this short cost more than their sums.
#pragma GCC unroll 16
  for (int n = 0; n < kOrder; ++n) {
    Pack yz = zero, zx = zero, xy = zero, carried = zero;
#pragma GCC unroll 16
    for (int k = 0; k <= n; ++k) {
      yz += wy[k] * wz[n - k];
      zx += wz[k] * wx[n - k];
      xy += wx[k] * wy[n - k];
    }
    part[n] = tilt.x * wx[n] + tilt.y * wy[n] + tilt.z * wz[n];
#pragma GCC unroll 16
    for (int k = 1; k <= n; ++k) carried += part[k] * rise[n - k];
    const Pack along = l0.x * wx[n] + l0.y * wy[n] + l0.z * wz[n];
    rise[n] = ((n == 0 ? twice_energy + along : along) - carried) * half;
    const double next = 1.0 / (n + 1);
    wx[n + 1] = (ax * next) * yz;
    wy[n + 1] = (ay * next) * zx;
    wz[n + 1] = (az * next) * xy;
    psi[n + 1] = next * rise[n];
  }
  Pack last = broadcast(1e-300);
  for (int n = kOrder - 1; n <= kOrder; ++n) {
    last = greatest(last, greatest(magnitude(wx[n]), magnitude(gain.x * wx[n])));
    last = greatest(last, greatest(magnitude(wy[n]), magnitude(gain.y * wy[n])));
    last = greatest(last, greatest(magnitude(wz[n]), magnitude(gain.z * wz[n])));
    last = greatest(last, magnitude(psi[n]));
  }
  constexpr double kSmallestTerm = 3e-15;
  const Pack reach = root(root(root(root(kSmallestTerm / last))));  // (tolerance / last)^(1 / 16)
  length_s = least(reach, broadcast(1.5)) / rate;
}

inline RotationSeries::Values RotationSeries::at(Pack time_s) const {
  const Pack x = (time_s - start_s) * rate;
  Values v{{wx[kOrder], wy[kOrder], wz[kOrder]}, {}, psi[kOrder]};
  for (int n = kOrder - 1; n >= 0; --n) {
    v.spin.x = v.spin.x * x + wx[n];
    v.spin.y = v.spin.y * x + wy[n];
    v.spin.z = v.spin.z * x + wz[n];
    v.psi = v.psi * x + psi[n];
  }
  v.l = {gain.x * v.spin.x, gain.y * v.spin.y, gain.z * v.spin.z};
  return v;
}

// R(t)^T up = A^T Rot(l0, -psi) up0.
inline Pack3 RotationSeries::up(const Values& v) const {
  const SinCos turn = sin_cos(v.psi);
  const Pack3 along = dot(l0, up0) * l0, across = up0 - along;
  const Pack3 turned = along + turn.cosine * across - turn.sine * cross(l0, up0);
  const Pack3 axis = cross(l0, v.l), once = cross(axis, turned);
  return turned + once + (1.0 / (1.0 + dot(l0, v.l))) * cross(axis, once);
}

inline Quaternion RotationSeries::orientation(const Values& v) const {
  const SinCos half = sin_cos(0.5 * v.psi);
  const Quaternion turn{half.cosine, half.sine * l0.x, half.sine * l0.y, half.sine * l0.z};
  const Pack3 axis = cross(v.l, l0);
  return normalized(start * turn * Quaternion{1.0 + dot(l0, v.l), axis.x, axis.y, axis.z});
}

}  // namespace ifa::IFA_LANES_NAMESPACE
