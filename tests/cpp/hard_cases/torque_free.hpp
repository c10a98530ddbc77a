// Torque-free rotation in closed form, in long double (64-bit significand): the answer to hard cases 1, 2
// and 4.
#pragma once

#include <Eigen/Dense>

#include "ifa/rigid/body.hpp"
#include "ifa/rigid/state.hpp"

namespace ifa {

using Real = long double;
using Vec3l = Eigen::Matrix<Real, 3, 1>;
using Mat3l = Eigen::Matrix<Real, 3, 3>;
using Quatl = Eigen::Quaternion<Real>;

// Complete elliptic integral of the first kind from its complementary parameter 1 - k^2, by the
// arithmetic-geometric mean.
Real complete_elliptic_k(Real complement);

// The rotation of a body whose moments are not all equal, from Jacobi's elliptic functions: Landau and
// Lifshitz, Mechanics, section 37, with the moments in ascending order. The angle about the angular momentum
// is the integral of a function of the spin, which is smooth for the axis of the least moment and done by
// Gauss. Written with sums of products of like sign, so that symmetric bodies, needles and spins close to the
// separatrix lose no digits.
class TorqueFree {
 public:
  // `state` in principal axes, as everywhere in the engine.
  TorqueFree(const Body& body, const State& state);

  // World from principal axes at any time of either sign.
  Mat3l orientation(Real time_s) const;
  Vec3l body_spin(Real time_s) const;  // principal axes

  Real complement() const { return complement_; }  // 1 - k^2
  Real period_s() const;                           // of the spin in the body, four quarters

 private:
  Vec3l sorted_spin(Real time_s) const;
  Mat3l body_triad(const Vec3l& sorted_spin) const;
  Real turn_about_momentum(Real time_s) const;

  Mat3l principal_from_sorted_;
  Vec3l moments_;     // ascending
  Vec3l amplitudes_;  // of cn or dn, sn, dn or cn
  Real momentum_ = 0, rate_ = 0, complement_ = 1, phase_ = 0, spin_bound_ = 0;
  bool about_largest_ = false;  // the spin circles the axis of the largest moment, not of the least
  Mat3l world_triad_;
};

// The same motion by another road: the equations for (q, spin), integrated by Gragg, Bulirsch and Stoer's
// extrapolated midpoint rule in long double.
void integrate_torque_free(const Vec3l& moments, Real time_s, Quatl& q, Vec3l& body_spin);

// Angle between orientations, rad; good for small ones.
Real angle_between(const Mat3l& a, const Mat3l& b);
Mat3l to_matrix(const Quat& q);

}  // namespace ifa
