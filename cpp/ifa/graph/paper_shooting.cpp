#include "ifa/graph/paper_shooting.hpp"

#include <numbers>

namespace ifa {
namespace {

Vec3 moments_of(const lanes::BodyView& body) { return Eigen::Map<const Vec3>(body.inertia); }

Quat stepped_turn(const Vec3& moments, const Vec3& spin, int steps) {
  struct Slope {
    Eigen::Vector4d q;  // x, y, z, w
    Vec3 w;
  };
  const auto slope = [&](const Eigen::Vector4d& q, const Vec3& w) {
    const Quat rate = Quat(q[3], q[0], q[1], q[2]) * Quat(0.0, w.x(), w.y(), w.z());
    return Slope{0.5 * rate.coeffs(), moments.cwiseProduct(w).cross(w).cwiseQuotient(moments)};
  };
  Eigen::Vector4d q(0.0, 0.0, 0.0, 1.0);
  Vec3 w = spin;
  const double h = 1.0 / steps;
  for (int n = 0; n < steps; ++n) {
    const Slope a = slope(q, w), b = slope(q + 0.5 * h * a.q, w + 0.5 * h * a.w),
                c = slope(q + 0.5 * h * b.q, w + 0.5 * h * b.w), d = slope(q + h * c.q, w + h * c.w);
    q += h / 6.0 * (a.q + 2.0 * (b.q + c.q) + d.q);
    w += h / 6.0 * (a.w + 2.0 * (b.w + c.w) + d.w);
  }
  q.normalize();
  return Quat(q[3], q[0], q[1], q[2]);
}

}  // namespace

PaperShooting shoot_as_paper(const lanes::BodyView& body, const Quat& target, const Vec3& guess,
                             double tolerance_rad, int most_iterations, PaperFlight flight) {
  constexpr double kMostTurn_rad = 10.0 * std::numbers::pi / 180.0;
  // In units of the largest moment, so that one difference step suits every body.
  const Vec3 moments = moments_of(body) / moments_of(body).maxCoeff();
  const auto squared_error = [&](const Vec3& momentum) {
    const Vec3 spin = momentum.cwiseQuotient(moments);
    const Quat turn =
        flight.steps > 0 ? stepped_turn(moments, spin, flight.steps) : turn_of(body, spin).rotation;
    return rotation_log(target.conjugate() * turn).squaredNorm();
  };
  Vec3 momentum = guess.cwiseProduct(moments);
  double f = squared_error(momentum);
  int iterations = 0;
  for (; f > tolerance_rad * tolerance_rad && iterations < most_iterations; ++iterations) {
    Vec3 j;
    for (int k = 0; k < 3; ++k) {
      const double step = 1e-7 * moments[k];  // 1e-7 rad of spin about that axis
      j[k] = (squared_error(momentum + step * Vec3::Unit(k)) - f) / step;
    }
    const Vec3 weighted = moments.cwiseProduct(j);  // W J^T
    const double denominator = j.dot(weighted);
    if (!(denominator > 0.0)) break;
    Vec3 change = -f / denominator * weighted;
    const double turn = change.cwiseQuotient(moments).norm();
    if (turn > kMostTurn_rad) change *= kMostTurn_rad / turn;
    momentum += change;
    f = squared_error(momentum);
  }
  const double error = std::sqrt(f);
  return {error <= tolerance_rad, momentum.cwiseQuotient(moments), error, iterations};
}

Vec3 paper_guess(const lanes::BodyView& body, const Quat& q0, const Vec3& w0, const Quat& q1,
                 const Vec3& w1) {
  const Vec3 moments = moments_of(body);
  const Vec3 other = q0.conjugate() * (q1 * moments.cwiseProduct(w1));
  return 0.5 * (w0 + other.cwiseQuotient(moments));
}

}  // namespace ifa
