// Motions from the leaves of a beam.
#pragma once

#include "ifa/forward/beam.hpp"
#include "ifa/forward/solve.hpp"

namespace ifa {

// The best motion of the beam, which must have a level, and up to `takes` - 1 others that are plausible if it
// is, else succeeded, that meet the constraints if it does, and clearly different from it, from one another
// and from `before`: in the order of their rank. With `before`, the others alone.
std::vector<Solution> best_takes(const Problem& problem, const Beam& beam, int takes, double lead_in_s,
                                 const std::vector<Solution>& before, const Progress* progress);

}  // namespace ifa
