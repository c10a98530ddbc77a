// What a solve found, as Python sees it.
#pragma once

#include <map>
#include <string>

#include "bindings.hpp"
#include "ifa/solution/solution.hpp"

namespace ifa::bindings {

py::dict from_solution(const Solution& s);

// By name.
ForcedEffects to_forced(const std::map<std::string, bool>& forced);

}  // namespace ifa::bindings
