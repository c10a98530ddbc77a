// engine="ode": the velocity-level contact problem of the paper, by the Open Dynamics Engine. The engine to
// compare with, in fixed steps and with their errors.
#pragma once

#include "ifa/base/progress.hpp"
#include "ifa/rigid/run.hpp"

namespace ifa {

struct OdeOptions {
  Vec3 gravity_m_s2{0.0, 0.0, -9.81};
  double step_s = 1e-3;
  // Flight in closed form up to the exact instant of each contact, steps while something touches. False:
  // every step is ODE's, with its own gyroscopic term, and contacts begin up to a step late.
  bool skip_flight = true;
  double erp = 0.2;   // share of a penetration that a step corrects, at most 0.2
  double cfm = 1e-6;  // softness of a constraint, relative to its own: CFM = cfm * step * J M^-1 J^T
  double micro_speed_m_s = 0.01;  // slower approaches neither bounce nor are hits
  double rest_speed_m_s = 0.01;   // rest as in SimulationOptions
  double rest_duration_s = 0.05;
  int max_impacts = 100000;
};

// The run to rest or to `until_s`; `failed` where ODE complained or a state grew beyond all bounds. Nodes:
// the start, both sides of each impact, each step with contact, and the end; stepped flight is not kept. An
// impact is a step that begins with a touching vertex which approaches faster than `micro_speed_m_s`. Both
// its sides have the time and the pose of the step's beginning: with flight skipped the contacts act alone
// and at once, else the changed velocities are those that move the body for the whole step, gravity's part in
// them. A hit's impulse is the change of momentum. Throws ArgumentError on options out of their range, and
// where nothing could end the run.
Run simulate_ode(const Body& body, const State& state, const OdeOptions& options, double until_s,
                 const Progress* progress = nullptr);

}  // namespace ifa
