// Bodies, options and states as the kernels' plain data.
#pragma once

#include "ifa/rigid/body.hpp"
#include "ifa/rigid/event_engine.hpp"
#include "ifa/rigid/lanes/sim.hpp"
#include "ifa/rigid/state.hpp"

namespace ifa {

lanes::BodyView view_of(const Body& body);  // valid as long as the body
lanes::Settings settings_of(const Body& body, const SimulationOptions& options);

// A simulation that begins at `state`: in flight, or in contact if it touches the ground and does not leave.
lanes::Sim begin_sim(const lanes::BodyView& body, const lanes::Settings& settings, const State& state,
                     double time_s);
State state_of(const lanes::Sim& sim);

}  // namespace ifa
