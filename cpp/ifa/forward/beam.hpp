// The forward search: a beam of states that have all reached event k (design after the paper's section 5.1
// and 5.4; no database). The best children of its states go on to event k + 1.
#pragma once

#include <cstdint>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/forward/select.hpp"

namespace ifa {

// How each state's impact is changed on the way to its next event.
struct Proposals {
  int roots = 3;     // searches for a change that meets the next mark, at most
  int variants = 4;  // of each change that does
};

struct BeamOptions {
  int beam = 300;  // states kept at each event
  std::uint64_t seed = 0;
  int threads = 0;
  Proposals proposals;
  bool few_starts = false;  // of a single mark: no more first contacts than it takes
};

// A candidate of the last level with the way its motion ends.
struct Leaf {
  int candidate;
  Leave leave;
  double log_weight;
  int violations, unmet, stretched;
};

// What a search has found, and all that it kept on the way.
struct Beam {
  std::vector<Level> levels;  // by event; as many as were reached
  std::vector<Leaf> leaves;   // complete motions, best first
  double simulated_s = 0.0;
};

// `kept`, where given, is an earlier beam for marks that were the same up to and with event `same - 1`: its
// levels up to there are gone on from.
Beam search_beam(const Problem& problem, const BeamOptions& options, Progress* progress,
                 const Beam* kept = nullptr, std::size_t same = 0);

Found trace(const Beam& beam, const Leaf& leaf);

// The beam of one motion: that of `kept`'s best leaf for marks that were the same up to and with event `same`
// - 1, kept to as nearly as these marks allow. Without leaves where it is lost.
Beam track_beam(const Problem& problem, const BeamOptions& options, Progress* progress, const Beam& kept,
                std::size_t same);

// Of the motions that the beam reached: the best leaf, else the candidate that came farthest. The beam must
// have a level.
Found best_of(const Beam& beam);

}  // namespace ifa
