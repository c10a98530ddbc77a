#include "ifa/rigid/flight.hpp"

#include <algorithm>
#include <cmath>

namespace ifa {
namespace {

constexpr int kMaxAdvances = 100000;

double horner(const double* coefficients, int order, double t) {
  double sum = coefficients[order];
  for (int k = order - 1; k >= 0; --k) sum = sum * t + coefficients[k];
  return sum;
}

}  // namespace

Flight::Flight(const Body& body) : body_(&body) {}

void Flight::start(const State& state, const Vec3& gravity_m_s2) {
  start_ = state;
  gravity_ = gravity_m_s2;
  const Quat inverse = state.orientation.conjugate();
  body_spin_ = inverse * state.angular_velocity;
  up_ = inverse * kUp;
  spin_ = body_spin_.norm();
  ahead_.clear();
  behind_.clear();

  // |h''| <= |g_z| + r |d2(up)/dt2|. For a constant spin d2(up)/dt2 = (up x w) x w has the constant length
  // |up x w| |w|; else |up' x w + up x w'| <= w^2 + |w'| with w and w' bounded by energy and momentum.
  const double r = body_->bounding_radius_m();
  if (body_->isotropic()) {
    curvature_bound_ = std::abs(gravity_.z()) + r * up_.cross(body_spin_).norm() * spin_;
  } else {
    const Vec3& inertia = body_->principal_inertia();
    const Vec3 momentum = inertia.cwiseProduct(body_spin_);
    const double energy2 = momentum.dot(body_spin_);
    Vec3 largest;  // each component of the spin is bounded by the energy and by the momentum
    for (int i = 0; i < 3; ++i)
      largest[i] = std::min(std::sqrt(energy2 / inertia[i]), momentum.norm() / inertia[i]);
    Vec3 rate;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      rate[i] = std::abs(inertia[j] - inertia[k]) / inertia[i] * largest[j] * largest[k];
    }
    curvature_bound_ = std::abs(gravity_.z()) + r * (largest.squaredNorm() + rate.norm());
  }
}

Flight::Piece Flight::make_piece(double start_s, const Quat& q, const Vec3& body_spin,
                                 double direction) const {
  Piece piece;
  piece.start_s = start_s;
  const Vec3& inertia = body_->principal_inertia();
  const Vec3 ratio((inertia.y() - inertia.z()) / inertia.x(), (inertia.z() - inertia.x()) / inertia.y(),
                   (inertia.x() - inertia.y()) / inertia.z());
  auto& [qw, qx, qy, qz] = piece.q;
  auto& [wx, wy, wz] = piece.w;
  // In units of the spin's own time, so that no coefficient over- or underflows.
  const double unit = body_spin.norm() > 0 ? 1.0 / body_spin.norm() : 1.0;
  qw[0] = q.w(), qx[0] = q.x(), qy[0] = q.y(), qz[0] = q.z();
  wx[0] = body_spin.x() * unit, wy[0] = body_spin.y() * unit, wz[0] = body_spin.z() * unit;
  for (int n = 0; n < kOrder; ++n) {
    double yz = 0, zx = 0, xy = 0, dw = 0, dx = 0, dy = 0, dz = 0;
    for (int k = 0; k <= n; ++k) {
      const double a = wx[n - k], b = wy[n - k], c = wz[n - k];
      yz += wy[k] * c;
      zx += wz[k] * a;
      xy += wx[k] * b;
      dw -= qx[k] * a + qy[k] * b + qz[k] * c;  // 2 q' = q (0, w)
      dx += qw[k] * a + qy[k] * c - qz[k] * b;
      dy += qw[k] * b + qz[k] * a - qx[k] * c;
      dz += qw[k] * c + qx[k] * b - qy[k] * a;
    }
    const double next = 1.0 / (n + 1);
    wx[n + 1] = ratio.x() * yz * next;
    wy[n + 1] = ratio.y() * zx * next;
    wz[n + 1] = ratio.z() * xy * next;
    qw[n + 1] = 0.5 * dw * next, qx[n + 1] = 0.5 * dx * next;
    qy[n + 1] = 0.5 * dy * next, qz[n + 1] = 0.5 * dz * next;
  }
  // The step: the last two terms of every series below 1e-16.
  double length = 1e3;
  for (int n = kOrder - 1; n <= kOrder; ++n) {
    double largest = 1e-300;
    for (const auto& c : piece.q) largest = std::max(largest, std::abs(c[n]));
    for (const auto& c : piece.w) largest = std::max(largest, std::abs(c[n]));
    length = std::min(length, std::pow(1e-16 / largest, 1.0 / n));
  }
  piece.length_s = length * unit * direction;
  double scale = 1.0;
  for (int n = 1; n <= kOrder; ++n) {
    scale /= unit;
    for (auto& c : piece.q) c[n] *= scale;
    for (auto& c : piece.w) c[n] *= scale;
  }
  for (auto& c : piece.w)
    for (double& x : c) x /= unit;
  return piece;
}

const Flight::Piece& Flight::piece_at(double time_s) const {
  const bool forward = time_s >= 0.0;
  auto& pieces = forward ? ahead_ : behind_;
  const double direction = forward ? 1.0 : -1.0;
  if (pieces.empty()) pieces.push_back(make_piece(0.0, start_.orientation, body_spin_, direction));
  while (std::abs(time_s) > std::abs(pieces.back().start_s + pieces.back().length_s)) {
    const Piece& last = pieces.back();
    const double l = last.length_s;
    Quat q(horner(last.q[0].data(), kOrder, l), horner(last.q[1].data(), kOrder, l),
           horner(last.q[2].data(), kOrder, l), horner(last.q[3].data(), kOrder, l));
    const Vec3 w(horner(last.w[0].data(), kOrder, l), horner(last.w[1].data(), kOrder, l),
                 horner(last.w[2].data(), kOrder, l));
    q.normalize();
    pieces.push_back(make_piece(last.start_s + l, q, w, direction));
  }
  std::size_t i = pieces.size() - 1;
  while (i > 0 && std::abs(time_s) < std::abs(pieces[i].start_s)) --i;
  return pieces[i];
}

void Flight::rotation_at(double time_s, Quat& q, Vec3& body_spin) const {
  if (spin_ == 0.0) {
    q = start_.orientation;
    body_spin = body_spin_;
  } else if (body_->isotropic()) {
    q = start_.orientation * rotation_exp(body_spin_ * time_s);
    body_spin = body_spin_;
  } else {
    const Piece& p = piece_at(time_s);
    const double t = time_s - p.start_s;
    q = Quat(horner(p.q[0].data(), kOrder, t), horner(p.q[1].data(), kOrder, t),
             horner(p.q[2].data(), kOrder, t), horner(p.q[3].data(), kOrder, t));
    body_spin = Vec3(horner(p.w[0].data(), kOrder, t), horner(p.w[1].data(), kOrder, t),
                     horner(p.w[2].data(), kOrder, t));
  }
  q.normalize();
}

void Flight::up_at(double time_s, Vec3& up, Vec3& up_rate) const {
  if (body_->isotropic()) {  // Rodrigues: up turns about the spin by -|w| t
    if (spin_ == 0.0) {
      up = up_;
      up_rate.setZero();
      return;
    }
    const Vec3 axis = body_spin_ / spin_;
    const double c = std::cos(spin_ * time_s), s = std::sin(spin_ * time_s);
    const Vec3 along = axis * axis.dot(up_), across = up_ - along, turned = up_.cross(axis);
    up = along + c * across + s * turned;
    up_rate = spin_ * (c * turned - s * across);
    return;
  }
  Quat q;
  Vec3 w;
  rotation_at(time_s, q, w);
  up = q.conjugate() * kUp;
  up_rate = up.cross(w);
}

State Flight::at(double time_s) const {
  State s;
  Vec3 body_spin;
  rotation_at(time_s, s.orientation, body_spin);
  s.position = start_.position + time_s * (start_.velocity + 0.5 * time_s * gravity_);
  s.velocity = start_.velocity + time_s * gravity_;
  s.angular_velocity = body_->isotropic() ? start_.angular_velocity : Vec3(s.orientation * body_spin);
  return s;
}

double Flight::clearance(double time_s) const {
  Vec3 up, up_rate;
  up_at(time_s, up, up_rate);
  double lowest = kNever;
  for (const Vec3& p : body_->principal_vertices()) lowest = std::min(lowest, up.dot(p));
  return lowest - body_->radius_m() + start_.position.z() +
         time_s * (start_.velocity.z() + 0.5 * time_s * gravity_.z());
}

double Flight::next_contact(double until_s) const {
  const double bound = curvature_bound_;
  const double height_floor = 1e-14 * body_->bounding_radius_m();
  double t = 0.0;
  Vec3 up, up_rate;
  for (int i = 0; i < kMaxAdvances && t <= until_s; ++i) {
    up_at(t, up, up_rate);
    const double z =
        start_.position.z() - body_->radius_m() + t * (start_.velocity.z() + 0.5 * t * gravity_.z());
    const double vz = start_.velocity.z() + t * gravity_.z();
    double step = kNever;
    for (const Vec3& p : body_->principal_vertices()) {
      const double h = std::max(0.0, z + up.dot(p));
      const double rate = vz + up_rate.dot(p);
      if (h <= height_floor && rate < 0.0) return t;
      // the positive root of h + rate s - bound s^2 / 2, without cancellation
      const double root = std::sqrt(rate * rate + 2.0 * bound * h);
      step = std::min(step, rate >= 0.0 ? (rate + root) / bound : 2.0 * h / (root - rate));
    }
    if (!(step < kNever)) return kNever;
    // Rounding in h is worth this much time: the root is here.
    if (step <= 4e-16 * (t + 1e-3)) {
      bool approaching = false;
      for (const Vec3& p : body_->principal_vertices())
        approaching |= z + up.dot(p) <= 100 * height_floor && vz + up_rate.dot(p) < 0.0;
      if (approaching) return t;
      step = 1e-12;  // grazing and on its way up
    }
    t += step;
  }
  return t <= until_s ? t : kNever;  // absurdly fast spin: stop here, the caller goes on from this instant
}

}  // namespace ifa
