#include "ifa/motion/difference.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ifa/base/error.hpp"

namespace ifa {
namespace {

constexpr double kRate_hz = 240.0;
constexpr double kMostSamples = 96000.0;  // bounds what a mistake in the times can cost: 40 MB

// Two poses of one body differ at its point r by (x_a - x_b) + (R_a - R_b) r. The mean square of this over
// the mass takes of the body only its second moments C = int r r^T dm / m, r from the centre of mass:
//   |x_a - x_b|^2 + tr((R_a - R_b) C (R_a - R_b)^T),    C = P diag(l_i) P^T,    l_i = (tr(I) / 2 - I_i) / m
// so six points at +-sqrt(3 l_i) on the principal axes P, a sixth of the mass each, stand for the whole body.
// With the arms A = R P diag(sqrt(l_i)) the second term is the squared norm of A_a - A_b. Here P
// diag(sqrt(l_i)):
Mat3 spread_of(const Body& body) {
  const Vec3& moments = body.principal_inertia();
  const Vec3 second = (Vec3::Constant(0.5 * moments.sum()) - moments) / body.mass_kg();
  const Vec3 lengths = second.cwiseMax(0.0).cwiseSqrt();  // a flat body's may round to below 0
  return body.body_from_principal().toRotationMatrix() * lengths.asDiagonal();
}

bool same_body(const Body& a, const Body& b) {
  constexpr double kRounding = 1e-9;  // of bodies that were written to a file, or replaced in part
  const double size = a.inertia_kg_m2().cwiseAbs().maxCoeff();
  return std::abs(a.mass_kg() - b.mass_kg()) <= kRounding * a.mass_kg() &&
         std::abs(a.bounding_radius_m() - b.bounding_radius_m()) <= kRounding * a.bounding_radius_m() &&
         (a.inertia_kg_m2() - b.inertia_kg_m2()).cwiseAbs().maxCoeff() <= kRounding * size;
}

struct Pose {
  Vec3 position;  // of the centre of mass
  Mat3 arms;      // A
};

std::vector<Pose> poses(const Motion& motion, const Mat3& spread, const std::vector<double>& times_s) {
  std::vector<Pose> out;
  out.reserve(times_s.size());
  for (const State& s : motion.sample(times_s))
    out.push_back({s.position, s.orientation.toRotationMatrix() * spread});
  return out;
}

Vec2 mean_place(const std::vector<Pose>& poses) {
  Vec2 sum = Vec2::Zero();
  for (const Pose& p : poses) sum += p.position.head<2>();
  return sum / static_cast<double>(poses.size());
}

}  // namespace

double difference(const Motion& a, const Motion& b, double from_s, double to_s) {
  if (!std::isfinite(from_s)) throw ArgumentError("from_s: must be finite");
  if (!(to_s > from_s && std::isfinite(to_s - from_s)))
    throw ArgumentError("to_s: must be finite and after from_s");
  if (!same_body(a.body(), b.body())) throw ArgumentError("other: is a motion of another body");

  const double intervals = std::clamp(std::ceil((to_s - from_s) * kRate_hz), 1.0, kMostSamples);
  std::vector<double> times_s(static_cast<std::size_t>(intervals));
  for (std::size_t i = 0; i < times_s.size(); ++i)
    times_s[i] = from_s + (to_s - from_s) * ((static_cast<double>(i) + 0.5) / intervals);
  const Mat3 spread = spread_of(a.body());
  const std::vector<Pose> pa = poses(a, spread, times_s), pb = poses(b, spread, times_s);

  // Orthogonal Procrustes in the plane: the best shift brings the mean places together, and the best turn Q
  // has the largest tr(Q^T M), M the sum of a b^T over all points and times.
  const Vec2 centre_a = mean_place(pa), centre_b = mean_place(pb);
  Mat2 m = Mat2::Zero();
  for (std::size_t i = 0; i < pa.size(); ++i) {
    m += (pa[i].position.head<2>() - centre_a) * (pb[i].position.head<2>() - centre_b).transpose();
    m += (pa[i].arms * pb[i].arms.transpose()).topLeftCorner<2, 2>();
  }
  const double yaw = std::atan2(m(1, 0) - m(0, 1), m(0, 0) + m(1, 1));
  const Mat3 turn = Eigen::AngleAxisd(yaw, kUp).toRotationMatrix();

  // Summed from the differences, not from the squares above, which would cancel.
  const Vec3 about_a(centre_a.x(), centre_a.y(), 0.0), about_b(centre_b.x(), centre_b.y(), 0.0);
  double squares = 0.0;
  for (std::size_t i = 0; i < pa.size(); ++i) {
    squares += ((pa[i].position - about_a) - turn * (pb[i].position - about_b)).squaredNorm();
    squares += (pa[i].arms - turn * pb[i].arms).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(pa.size())) / a.body().bounding_radius_m();
}

}  // namespace ifa
