// Torque-free flight under constant gravity, and the instant at which it ends at the ground.
#pragma once

#include <memory>

#include "ifa/rigid/body.hpp"
#include "ifa/rigid/run.hpp"
#include "ifa/rigid/state.hpp"

namespace ifa {

// The position is a parabola. The rotation is a power series in pieces (lanes/rotation.hpp), or a constant
// spin for a body that does not couple its spin, as an isotropic one need not. States are in principal axes.
// Not thread-safe: pieces of the series are made when first asked for. The body must outlive it.
class Flight {
 public:
  explicit Flight(const Body& body);
  ~Flight();
  Flight(Flight&&) noexcept;
  Flight& operator=(Flight&&) noexcept;

  // Begins a new flight at time 0.
  void start(const State& state, const Vec3& gravity_m_s2);

  State at(double time_s) const;  // any sign; exact

  // Height above the ground of the hull point nearest to it.
  double clearance(double time_s) const;

  // The first instant in (0, until_s] at which some hull point reaches the ground from above; kNever if none.
  double next_contact(double until_s) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ifa
