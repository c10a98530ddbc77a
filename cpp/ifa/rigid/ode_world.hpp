// One body above the ground in a world of the Open Dynamics Engine (ODE 0.16), with the engine's traps
// closed. ode_world.cpp is the only file that includes ode.h.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "ifa/rigid/state.hpp"

namespace ifa {

// A point of the body on the ground. Coefficients are those of dSurfaceParameters, all limits proportional to
// the normal force (dContactApprox1).
struct OdeContact {
  Vec3 position;
  double depth = 0.0;
  Vec3 slip_direction = Vec3::UnitX();  // unit, horizontal
  double friction = 0.0;                // along slip_direction
  double cross_friction = 0.0;          // across it
  double restitution = 0.0;
  std::array<double, 3> softness{};  // CFM of the normal row and of those along and across the slip
};

struct OdeStep {
  double length = 0.0;
  bool instant = false;  // the contacts act alone: no gravity, no gyroscopic term
  double erp = 0.0;
  double layer = 0.0;             // depth that is not corrected
  double correcting_speed = 0.0;  // the largest that a correction may ask for
  double bounce_speed = 0.0;      // slower approaches do not bounce
  Vec3 torque = Vec3::Zero();     // on the body, besides the contacts
};

// Any consistent units. Worlds share nothing, so that each may be in a thread of its own; a step does not
// depend on earlier ones but through `state`.
class OdeWorld {
 public:
  // In principal axes.
  OdeWorld(double mass, const Vec3& inertia, const Vec3& gravity);
  ~OdeWorld();
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  void set(const State& state);
  State get() const;

  // One dWorldStep. `normal_forces`, where not empty, receives that of each contact. False where ODE reported
  // an error or a message: what it then computed is not to be used.
  bool step(const OdeStep& step, std::span<const OdeContact> contacts, std::span<double> normal_forces = {});

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// Calls `work` as the worlds call ODE; false where ODE complained in it on this thread, be it by a message,
// an error or a failed assertion. For tests.
bool without_ode_complaint(void (*work)());

}  // namespace ifa
