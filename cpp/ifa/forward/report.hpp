// Turns found links into a motion, and measures it.
#pragma once

#include "ifa/forward/solve.hpp"

namespace ifa {

Solution make_solution(const Body& body, const SearchPhysics& physics, const Marks& marks, const Found& found);

// Better first: plausible, then succeeded, then by score.
bool better(const Solution& a, const Solution& b);

}  // namespace ifa
