#include "ifa/rigid/contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace ifa {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr double kStalled = 3e-6;  // of the fastest point's speed: a remainder that nobody sees

// The impulse of a sliding point. With d = (c, s) the unit slip direction after, J = J_n (-mu d, 1), the
// normal speed after is the target, and the slip after, u_t, points along d. Of u_t x d = 0 remains one
// equation for d,
//   (d x f) (K_nn - mu k.d) + a (d x k - mu d x A d) = 0,  a = target - free_n,
// with the point's matrix K = [A k; k^T K_nn] and f the tangential velocity without its impulse.
struct Slide {
  const Mat3& matrix;
  Vec3 free;
  double target, friction;

  struct Value {
    double residual, slope;  // of the equation above, and its derivative by the angle of d
  };

  Value at(const Vec2& d) const {
    const double c = d.x(), s = d.y();
    const double a00 = matrix(0, 0), a01 = matrix(0, 1), a11 = matrix(1, 1);
    const double kx = matrix(0, 2), ky = matrix(1, 2);
    const double a = target - free.z();
    const double across = c * free.y() - s * free.x(), along = c * free.x() + s * free.y();
    const double k_across = c * ky - s * kx, k_along = c * kx + s * ky;
    const double twist = c * s * (a11 - a00) + (c * c - s * s) * a01;  // d x A d
    const double twist_slope = (c * c - s * s) * (a11 - a00) - 4.0 * c * s * a01;
    const double open = matrix(2, 2) - friction * k_along;
    return {across * open + a * (k_across - friction * twist),
            -along * open - across * friction * k_across - a * (k_along + friction * twist_slope)};
  }

  // The impulse for a root d; false if it would pull, or slip against d.
  bool impulse(const Vec2& d, Vec3& out, double& slip) const {
    const double open = matrix(2, 2) - friction * matrix.block<1, 2>(2, 0).dot(d);
    if (open <= 1e-9 * matrix(2, 2)) return false;
    const double normal = (target - free.z()) / open;
    out = {-friction * normal * d.x(), -friction * normal * d.y(), normal};
    slip = (free + matrix * out).head<2>().dot(d);
    return slip >= -1e-12 * free.norm();
  }

  // From a direction. `sharp` asks for a root to rounding; else two steps do, since the sweeps go on.
  bool newton(Vec2 d, bool sharp, Vec3& out) const {
    double slip;
    for (int i = 0; i < 20; ++i) {
      const Value here = at(d);
      if (!(std::abs(here.slope) > 0.0)) return false;
      const double turn = std::clamp(-here.residual / here.slope, -0.5, 0.5);
      d = (d + turn * Vec2(-d.y(), d.x())).normalized();
      // Newton squares the last turn: below rounding after this step.
      if (std::abs(turn) < 1e-9 || (!sharp && i == 1)) return impulse(d, out, slip);
    }
    return false;
  }

  // All directions, where Newton failed: of the roots that slip along d, the one that dissipates most.
  bool scan(Vec3& out) const {
    constexpr int kDirections = 32;
    const auto direction = [](double angle) { return Vec2(std::cos(angle), std::sin(angle)); };
    double best = -1.0;
    for (int i = 0; i < kDirections; ++i) {
      double low = 2 * std::numbers::pi * i / kDirections,
             high = 2 * std::numbers::pi * (i + 1) / kDirections;
      const double at_low = at(direction(low)).residual;
      if (at_low * at(direction(high)).residual > 0.0) continue;
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = 0.5 * (low + high);
        (at(direction(middle)).residual * at_low > 0.0 ? low : high) = middle;
      }
      Vec3 candidate;
      double slip = 0.0;
      if (impulse(direction(low), candidate, slip) && candidate.z() * slip > best) {
        best = candidate.z() * slip;
        out = candidate;
      }
    }
    return best >= 0.0;
  }
};

Vec3 solve_point(const Mat3& matrix, const Mat3& inverse, const Vec3& free, double target, double friction,
                 const Vec3& previous, bool alone) {
  if (free.z() >= target) return Vec3::Zero();
  if (friction == 0.0) return {0.0, 0.0, (target - free.z()) / matrix(2, 2)};
  const Vec3 stick = inverse * Vec3(-free.x(), -free.y(), target - free.z());
  if (stick.z() >= 0.0 && stick.head<2>().squaredNorm() <= friction * friction * stick.z() * stick.z())
    return stick;
  const Slide slide{matrix, free, target, friction};
  Vec3 impulse;
  const double before = previous.head<2>().norm(), slip = free.head<2>().norm();
  if (before > 0.0 && slide.newton(-previous.head<2>() / before, alone, impulse)) return impulse;
  if (slip > 0.0 && slide.newton(free.head<2>() / slip, true, impulse)) return impulse;
  if (slide.scan(impulse)) return impulse;
  // Jammed (Painleve): the normal impulse alone, friction opposing the free slip, inside the cone.
  const double normal = (target - free.z()) / matrix(2, 2);
  const Vec2 d = slip > 0.0 ? Vec2(free.head<2>() / slip) : Vec2(0.0, 0.0);
  const double share = std::min(friction, slip / (normal * matrix.topLeftCorner<2, 2>().trace()));
  return {-share * normal * d.x(), -share * normal * d.y(), normal};
}

// Normal impulses that reach the targets without friction: the least-norm solution, so that a symmetric body
// is loaded symmetrically, and a good start for the sweeps where points are redundant. The n x n matrix of
// the normal problem is J J^T with rows J_i = (1 / sqrt(m), L^T (r_i x up)), L L^T the horizontal inverse
// inertia.
void share_load(const ContactBody& body, std::vector<ContactPoint>& points, const Vec3& velocity,
                const Vec3& angular_velocity) {
  const Mat2 l = Eigen::LLT<Mat2>(body.inverse_inertia.topLeftCorner<2, 2>()).matrixL();
  const double heave = 1.0 / std::sqrt(body.mass_kg);
  const auto row = [&](const ContactPoint& p) {
    const Vec2 tilt = l.transpose() * Vec2(p.arm.y(), -p.arm.x());
    return Vec3(heave, tilt.x(), tilt.y());
  };
  Mat3 gram = Mat3::Zero();
  Vec3 wanted = Vec3::Zero();
  for (const ContactPoint& p : points) {
    const Vec3 j = row(p);
    gram += j * j.transpose();
    const double speed = (velocity + angular_velocity.cross(p.arm)).z();
    wanted += std::max(0.0, p.target_speed - speed) * j;
  }
  const Eigen::LDLT<Mat3> solver(gram);
  if (solver.info() != Eigen::Success || solver.rcond() < 1e-12) return;
  const Vec3 response = solver.solve(solver.solve(wanted));
  for (ContactPoint& p : points) p.impulse.z() = std::max(0.0, row(p).dot(response));
}

}  // namespace

void ContactSolver::solve(const ContactBody& body, std::vector<ContactPoint>& points, Vec3& velocity,
                          Vec3& angular_velocity, double tolerance, int max_sweeps) {
  const std::size_t n = points.size();
  local_.resize(n);
  local_inverse_.resize(n);
  double reach = 0.0, speed = 0.0;
  bool warm = false;
  for (std::size_t i = 0; i < n; ++i) {
    speed = std::max(speed, (velocity + angular_velocity.cross(points[i].arm)).norm());
    const Mat3 arm = cross_matrix(points[i].arm);
    local_[i] = Mat3::Identity() / body.mass_kg - arm * body.inverse_inertia * arm;
    local_inverse_[i] = local_[i].inverse();
    reach = std::max(reach, points[i].arm.norm());
    warm |= points[i].impulse.z() > 0.0;
  }
  if (!warm && n >= 3) share_load(body, points, velocity, angular_velocity);
  for (const ContactPoint& p : points) {
    velocity += p.impulse / body.mass_kg;
    angular_velocity += body.inverse_inertia * p.arm.cross(p.impulse);
  }
  const bool torques = body.rolling_friction_m > 0.0 || body.spin_friction_m > 0.0;
  const Mat2 roll_mass = torques ? Mat2(body.inverse_inertia.topLeftCorner<2, 2>().inverse()) : Mat2::Zero();
  Vec3 torque = Vec3::Zero();  // angular impulse of rolling and spin friction so far

  // Redundant points that slide may have targets that no impulses reach exactly: the impulses then drift
  // between the points while the motion stands still but for a remainder. Sweeps that stopped gaining end
  // there.
  double previous_change = kUnbounded;
  int stalled = 0;
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    double change = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      ContactPoint& p = points[i];
      const Vec3 now = velocity + angular_velocity.cross(p.arm);
      const Vec3 free = now - local_[i] * p.impulse;
      const Vec3 impulse = solve_point(local_[i], local_inverse_[i], free, p.target_speed, body.friction,
                                       p.impulse, n == 1 && !torques);
      const Vec3 delta = impulse - p.impulse;
      if (delta.isZero(0.0)) continue;
      p.impulse = impulse;
      velocity += delta / body.mass_kg;
      angular_velocity += body.inverse_inertia * p.arm.cross(delta);
      change = std::max(change, (local_[i] * delta).cwiseAbs().maxCoeff());
    }
    if (torques) {
      double normal = 0.0;
      for (const ContactPoint& p : points) normal += p.impulse.z();
      Vec3 wanted = torque;
      wanted.head<2>() -= roll_mass * angular_velocity.head<2>();
      const double roll = wanted.head<2>().norm(), roll_limit = body.rolling_friction_m * normal;
      if (roll > roll_limit) wanted.head<2>() *= roll_limit / roll;
      wanted.z() = std::clamp(wanted.z() - angular_velocity.z() / body.inverse_inertia(2, 2),
                              -body.spin_friction_m * normal, body.spin_friction_m * normal);
      const Vec3 spin_change = body.inverse_inertia * (wanted - torque);
      angular_velocity += spin_change;
      torque = wanted;
      change = std::max(change, spin_change.norm() * reach);
    }
    if (change <= tolerance || (n == 1 && !torques)) return;
    stalled = change > 0.7 * previous_change ? stalled + 1 : 0;
    if (n >= 3 && stalled >= 4 && change <= kStalled * speed) return;
    previous_change = change;
  }
}

}  // namespace ifa
