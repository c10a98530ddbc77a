// Keeping to a motion that is known, while its marks move a little.
#pragma once

#include <span>
#include <vector>

#include "ifa/forward/trial.hpp"

namespace ifa {

// Ways to leave event k after which the next mark is met plausibly and the body strikes as nearly as possible
// as in `wanted`, but for its place and heading; the nearest first, few from each candidate. Gauss and Newton
// on finite differences, about the change `y` that the known motion made there. random[i] is candidate i's.
std::vector<Trial> track(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                         const Onset& wanted, const Vec6& y, std::span<RandomStream> random);

}  // namespace ifa
