// Turns found links into a motion, and measures it.
#pragma once

#include "ifa/forward/solve.hpp"

namespace ifa {

Solution make_solution(const Body& body, const SearchPhysics& physics, const Marks& marks, const Found& found,
                       double lead_in_s, const Progress* progress = nullptr);

// Whether a is better: plausible, then succeeded, then fewer missed and extra hits, then the score.
bool better(const Solution& a, const Solution& b);

}  // namespace ifa
