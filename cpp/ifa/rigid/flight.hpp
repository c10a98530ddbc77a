// Torque-free flight under constant gravity, and the instant at which it ends at the ground.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "ifa/rigid/body.hpp"
#include "ifa/rigid/state.hpp"

namespace ifa {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

// The position is a parabola. The rotation of an isotropic body is a constant spin; of any other it is the
// solution of Euler's equations and of the quaternion's, as Taylor series of order 16 with a step chosen so
// that the last terms are below rounding (relative 1e-16 a step). States are in principal axes. Not
// thread-safe: pieces of the series are made when first asked for. The body must outlive it.
class Flight {
 public:
  explicit Flight(const Body& body);

  // Begins a new flight at time 0.
  void start(const State& state, const Vec3& gravity_m_s2);

  State at(double time_s) const;  // any sign; exact

  // Height above the ground of the hull point nearest to it.
  double clearance(double time_s) const;

  // The first instant in (0, until_s] at which some hull point reaches the ground from above; kNever if none.
  // Conservative advancement: from a time t every hull point stays above h + h' s - A s^2 / 2, with A a bound
  // on |h''| over the whole flight, so no root is stepped over, and near a root the step is Newton's.
  double next_contact(double until_s) const;

 private:
  static constexpr int kOrder = 16;
  struct Piece {
    double start_s, length_s;
    std::array<std::array<double, kOrder + 1>, 4> q;  // w, x, y, z; powers of (t - start)
    std::array<std::array<double, kOrder + 1>, 3> w;  // spin in principal axes
  };

  const Piece& piece_at(double time_s) const;
  Piece make_piece(double start_s, const Quat& q, const Vec3& body_spin, double direction) const;
  void rotation_at(double time_s, Quat& q, Vec3& body_spin) const;
  void up_at(double time_s, Vec3& up, Vec3& up_rate) const;  // the ground's normal in principal axes

  const Body* body_;
  State start_;
  Vec3 gravity_ = Vec3::Zero();
  Vec3 body_spin_ = Vec3::Zero();  // at the start, principal axes
  Vec3 up_ = kUp;                  // at the start, principal axes
  double spin_ = 0.0;
  double curvature_bound_ = 0.0;  // A above
  mutable std::vector<Piece> ahead_, behind_;
};

}  // namespace ifa
