// Which children go on.
#pragma once

#include <algorithm>
#include <vector>

#include "ifa/forward/candidate.hpp"

namespace ifa {

inline constexpr std::size_t kMostChildren = 4;  // of one parent that are kept, as long as there are others

// Candidates in the order in which they are gone on from: batches of `room`, those of one body side by side
// in each.
struct Level {
  std::vector<Candidate> candidates;
  std::vector<std::size_t> batch_ends;

  // What is not needed any more once children are chosen: candidates that never had a turn, and passages.
  void forget(std::size_t from) {
    candidates.resize(std::min(from, candidates.size()));
    std::erase_if(batch_ends, [from](std::size_t end) { return end > from; });
    candidates.shrink_to_fit();
    for (Candidate& c : candidates) c.unchanged.reset();
  }
};

// The most promising fill the first batch, those that were left out the next, and so on, at most `batches`.
// Sound ones come first; of these half by rank, half shared evenly among bands of energy, the best of
// each, since the marks to come may need a lively body or a tired one. Few children of one parent, few
// descendants of one start. `even` gives each body its share.
Level select(std::vector<Candidate>&& all, const Problem& problem, std::size_t room, std::size_t batches,
             bool even);

}  // namespace ifa
