#include "torque_free.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace ifa {
namespace {

constexpr Real kPi = std::numbers::pi_v<Real>;

// Carlson's R_F by duplication (Carlson 1995, "Numerical computation of real or complex elliptic integrals").
Real carlson_rf(Real x, Real y, Real z) {
  const Real x0 = x, y0 = y;
  const Real mean0 = (x + y + z) / 3;
  Real mean = mean0, power = 1;
  const Real spread = std::max({std::abs(mean - x), std::abs(mean - y), std::abs(mean - z)});
  const Real reach = spread * 1400;  // (3 epsilon)^(-1/6)
  for (int n = 0; n < 60 && power * reach >= std::abs(mean); ++n) {
    const Real l = std::sqrt(x) * std::sqrt(y) + std::sqrt(x) * std::sqrt(z) + std::sqrt(y) * std::sqrt(z);
    x = (x + l) / 4, y = (y + l) / 4, z = (z + l) / 4, mean = (mean + l) / 4;
    power /= 4;
  }
  const Real a = (mean0 - x0) * power / mean, b = (mean0 - y0) * power / mean, c = -a - b;
  const Real e2 = a * b - c * c, e3 = a * b * c;
  return (1 - e2 / 10 + e3 / 14 + e2 * e2 / 24 - 3 * e2 * e3 / 44) / std::sqrt(mean);
}

struct Elliptic {
  Real sn, cn, dn;
};

// By descending Landen transformations (Abramowitz and Stegun 16.4).
Elliptic jacobi(Real u, Real complement) {
  const Real quarter = complete_elliptic_k(complement);
  u = std::remainder(u, 4 * quarter);
  std::array<Real, 40> a, c;
  a[0] = 1;
  Real b = std::sqrt(complement);
  int n = 0;
  while (std::abs(a[n] - b) > 4e-19L * a[n] && n + 1 < 40) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
    ++n;
  }
  Real phi = std::ldexp(a[n] * u, n);
  for (; n > 0; --n) phi = (phi + std::asin(c[n] / a[n] * std::sin(phi))) / 2;
  const Real s = std::sin(phi), cosine = std::cos(phi);
  return {s, cosine, std::sqrt(cosine * cosine + complement * s * s)};
}

// Nodes and weights of Gauss and Legendre on [-1, 1], by Newton's method on the polynomial.
struct Gauss {
  static constexpr int kPoints = 16;
  std::array<Real, kPoints> node, weight;
  Gauss() {
    for (int i = 0; i < kPoints; ++i) {
      Real x = std::cos(kPi * (i + 0.75L) / (kPoints + 0.5L)), slope = 1;
      for (int round = 0; round < 10; ++round) {
        Real before = 1, here = x;
        for (int k = 2; k <= kPoints; ++k) {
          const Real next = ((2 * k - 1) * x * here - (k - 1) * before) / k;
          before = here;
          here = next;
        }
        slope = kPoints * (x * here - before) / (x * x - 1);
        x -= here / slope;
      }
      node[i] = x;
      weight[i] = 2 / ((1 - x * x) * slope * slope);
    }
  }
};

}  // namespace

Real complete_elliptic_k(Real complement) {
  Real a = 1, b = std::sqrt(complement);
  while (std::abs(a - b) > 4e-19L * a) {
    const Real next = (a + b) / 2;
    b = std::sqrt(a * b);
    if (next == a) break;
    a = next;
  }
  return kPi / (a + b);
}

TorqueFree::TorqueFree(const Body& body, const State& state) {
  const Vec3l moments = body.principal_inertia().cast<Real>();
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int i, int j) { return moments[i] < moments[j]; });
  principal_from_sorted_.setZero();
  for (int i = 0; i < 3; ++i) {
    principal_from_sorted_(order[i], i) = 1;
    moments_[i] = moments[order[i]];
  }
  if (principal_from_sorted_.determinant() < 0) principal_from_sorted_.col(1) *= -1;

  const Mat3l start = to_matrix(state.orientation);
  const Vec3l w =
      principal_from_sorted_.transpose() * (start.transpose() * state.angular_velocity.cast<Real>());
  const auto [i1, i2, i3] = std::array{moments_[0], moments_[1], moments_[2]};
  momentum_ = moments_.cwiseProduct(w).norm();
  const Real below = i1 * (i3 - i1) * w[0] * w[0] + i2 * (i3 - i2) * w[1] * w[1];  // 2 E I3 - L^2
  const Real above = i2 * (i2 - i1) * w[1] * w[1] + i3 * (i3 - i1) * w[2] * w[2];  // L^2 - 2 E I1
  const Real apart = i3 * (i3 - i2) * w[2] * w[2] - i1 * (i2 - i1) * w[0] * w[0];  // L^2 - 2 E I2
  about_largest_ = apart > 0;
  const Real volume = i1 * i2 * i3;
  const Real side1 = w[0] < 0 ? -1 : 1, side3 = w[2] < 0 ? -1 : 1;
  const Real most1 = std::sqrt(below / (i1 * (i3 - i1))), most3 = std::sqrt(above / (i3 * (i3 - i1)));
  if (about_largest_) {
    amplitudes_ = {most1, side3 * std::sqrt(below / (i2 * (i3 - i2))), side3 * most3};
    rate_ = std::sqrt((i3 - i2) * above / volume);
    complement_ = apart * (i3 - i1) / ((i3 - i2) * above);
  } else {
    amplitudes_ = {side1 * most1, side1 * std::sqrt(above / (i2 * (i2 - i1))), most3};
    rate_ = std::sqrt((i2 - i1) * below / volume);
    complement_ = -apart * (i3 - i1) / ((i2 - i1) * below);
  }
  complement_ = std::clamp(complement_, Real(0), Real(1));
  const int cosine = about_largest_ ? 0 : 2;
  const Real angle =
      amplitudes_[1] == 0 ? 0 : std::atan2(w[1] / amplitudes_[1], w[cosine] / amplitudes_[cosine]);
  const Real s = std::sin(angle), c = std::cos(angle);
  phase_ = s * carlson_rf(c * c, c * c + complement_ * s * s, 1);
  if (c < 0) phase_ = std::copysign(2 * complete_elliptic_k(complement_), s) - phase_;
  spin_bound_ = std::max(w.norm(), amplitudes_.cwiseAbs().maxCoeff());
  world_triad_ = start * principal_from_sorted_ * body_triad(sorted_spin(0));
}

Real TorqueFree::period_s() const { return 4 * complete_elliptic_k(complement_) / rate_; }

Vec3l TorqueFree::sorted_spin(Real time_s) const {
  const auto [sn, cn, dn] = jacobi(phase_ + rate_ * time_s, complement_);
  return about_largest_ ? Vec3l(amplitudes_[0] * cn, amplitudes_[1] * sn, amplitudes_[2] * dn)
                        : Vec3l(amplitudes_[0] * dn, amplitudes_[1] * sn, amplitudes_[2] * cn);
}

Vec3l TorqueFree::body_spin(Real time_s) const { return principal_from_sorted_ * sorted_spin(time_s); }

// Along the momentum, across it and the axis of the least moment, and the third.
Mat3l TorqueFree::body_triad(const Vec3l& spin) const {
  const Vec3l along = moments_.cwiseProduct(spin).normalized();
  const Vec3l across = Vec3l(0, -along[2], along[1]).normalized();
  Mat3l triad;
  triad << along, across, along.cross(across);
  return triad;
}

// `across` turns about the momentum at L (I2 w2^2 + I3 w3^2) / (I2^2 w2^2 + I3^2 w3^2).
Real TorqueFree::turn_about_momentum(Real time_s) const {
  static const Gauss gauss;
  const int panels = 1 + static_cast<int>(std::abs(time_s) * spin_bound_ / 0.5L);
  const Real half = time_s / panels / 2;
  Real sum = 0;
  for (int panel = 0; panel < panels; ++panel)
    for (int i = 0; i < Gauss::kPoints; ++i) {
      const Vec3l w = sorted_spin(half * (2 * panel + 1 + gauss.node[i]));
      const Real l2 = moments_[1] * w[1], l3 = moments_[2] * w[2];
      sum += gauss.weight[i] * (l2 * w[1] + l3 * w[2]) / (l2 * l2 + l3 * l3);
    }
  return momentum_ * half * sum;
}

Mat3l TorqueFree::orientation(Real time_s) const {
  const Real angle = turn_about_momentum(time_s);
  Mat3l turn;
  turn << 1, 0, 0, 0, std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle);
  return world_triad_ * turn * body_triad(sorted_spin(time_s)).transpose() *
         principal_from_sorted_.transpose();
}

void integrate_torque_free(const Vec3l& moments, Real time_s, Quatl& q, Vec3l& body_spin) {
  using State7 = Eigen::Matrix<Real, 7, 1>;  // x, y, z, w of q; spin
  const auto slope = [&](const State7& y) {
    const Vec3l w = y.tail<3>();
    const Quatl rate = Quatl(y[3], y[0], y[1], y[2]) * Quatl(0, w[0], w[1], w[2]);
    State7 d;
    d.head<4>() = rate.coeffs() / 2;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      d[4 + i] = (moments[j] - moments[k]) / moments[i] * w[j] * w[k];
    }
    return d;
  };
  State7 y;
  y << q.coeffs(), body_spin;
  constexpr int kColumns = 9;  // order 18
  const int steps = 1 + static_cast<int>(std::abs(time_s) * body_spin.norm() / 0.25L);
  const Real step = time_s / steps;
  for (int n = 0; n < steps; ++n) {
    std::array<State7, kColumns> row;
    for (int k = 0; k < kColumns; ++k) {
      const int substeps = 2 * (k + 1);
      const Real h = step / substeps;
      State7 before = y, here = y + h * slope(y);
      for (int i = 1; i < substeps; ++i) {
        const State7 next = before + 2 * h * slope(here);
        before = here;
        here = next;
      }
      State7 value = (before + here + h * slope(here)) / 2;  // Gragg's last, smoothing step
      for (int j = 0; j < k; ++j) {                          // Neville, in powers of h^2
        const Real ratio = Real(substeps) / (2 * (k - j));
        const State7 extrapolated = value + (value - row[j]) / (ratio * ratio - 1);
        row[j] = value;
        value = extrapolated;
      }
      row[k] = value;
    }
    y = row[kColumns - 1];
    y.head<4>().normalize();
  }
  q.coeffs() = y.head<4>();
  body_spin = y.tail<3>();
}

Real angle_between(const Mat3l& a, const Mat3l& b) {
  const Mat3l between = a.transpose() * b;
  const Vec3l twice_sine(between(2, 1) - between(1, 2), between(0, 2) - between(2, 0),
                         between(1, 0) - between(0, 1));
  return std::atan2(twice_sine.norm(), between.trace() - 1);
}

Mat3l to_matrix(const Quat& q) { return q.cast<Real>().normalized().toRotationMatrix(); }

}  // namespace ifa
