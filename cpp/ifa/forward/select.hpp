// Which children go on.
#pragma once

#include <vector>

#include "ifa/forward/candidate.hpp"

namespace ifa {

inline constexpr std::size_t kMostChildren = 4;  // of one parent that are kept, as long as there are others

// At most `room` of `all`, those of one body side by side. Plausible ones come first; of these half by rank,
// half shared evenly among bands of energy, the best of each, since the marks to come may need a lively body
// or a tired one. Few children of one parent, few descendants of one start. `even` gives each body its share.
std::vector<Candidate> select(std::vector<Candidate>&& all, const Problem& problem, std::size_t room,
                              bool even);

}  // namespace ifa
