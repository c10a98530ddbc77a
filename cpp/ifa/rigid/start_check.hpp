// What both engines can begin with.
#pragma once

#include <string>

#include "ifa/rigid/body.hpp"
#include "ifa/rigid/state.hpp"

namespace ifa {

// Beyond these, times and heights would be rounding, and a run would take for ever.
inline constexpr double kFastest_m_s = 1e6, kFastestSpin_rad_s = 1e6;

// Why a simulation of `body` cannot begin at `state` (principal axes), naming the field: it is below the
// ground by more than 2e-6 of its size, or too fast. Empty if it can.
std::string unfit_start(const Body& body, const State& state);

}  // namespace ifa
