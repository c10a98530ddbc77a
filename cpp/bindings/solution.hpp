// What a solve found, as Python sees it.
#pragma once

#include "bindings.hpp"
#include "ifa/solution/solution.hpp"

namespace ifa::bindings {

py::dict from_solution(const Solution& s);

}  // namespace ifa::bindings
