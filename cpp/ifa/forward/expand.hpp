// From candidates at one event to their children at the next.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/base/random.hpp"
#include "ifa/forward/candidate.hpp"

namespace ifa {

inline constexpr double kLongestRest_s = 30.0;  // a body that has not come to rest by then is given up
inline constexpr double kOpenTail_s = 0.5;      // how long a motion with an open ending goes on at most

struct ExpandOptions {
  int proposals;  // root searches for each candidate, at most
  Tolerance tolerance;
  int round;  // of proposals for the same candidates; the first one is 0
};

// One way to leave an event: a point of the plausible region's 6-ball, and what became of it.
struct Trial {
  std::size_t candidate;  // index
  Vec6 y;
  State after;
  double excess;
  Passage passage;
  double lateness_s;  // infinite where no hit came in time
};

// Works on candidates of one body. Each impact is changed within the plausible region (paper section 5.4) so
// that the next audible hit comes exactly when the next mark asks for it. A handful of changes is tried;
// between one that comes early and one that comes late lies one that comes in time (the ball is convex),
// found along the line between them unless the interval jumps there.
class Expander {
 public:
  Expander(const Problem& problem, int body, const Progress* progress);

  // Children of `parents`, which are at event k and have the indices from `first`, appended. `random[i]` is
  // parent i's.
  void expand(std::span<const Candidate> parents, std::size_t first, std::size_t k,
              const ExpandOptions& options, std::span<RandomStream> random, std::vector<Candidate>& children);

  // Those children to which nothing is changed.
  void follow(std::span<const Candidate> parents, std::size_t first, std::size_t k,
              const Tolerance& tolerance, std::vector<Candidate>& children);

  // Lets candidates at event k go on unchanged, and looks how well the next mark, or the ending, would be
  // met.
  void look_ahead(std::span<Candidate> candidates, std::size_t k);

  // Changes of the last impact after which the motion ends as the marks ask: the mildest for each candidate
  // (excess infinite if none), of `changes` tried. Their passages go to the end.
  std::vector<Trial> finish(std::span<const Candidate> candidates, int changes, double largest_excess,
                            std::span<RandomStream> random);

  double simulated_s() const { return passages_.simulated_s(); }
  Passages& passages() { return passages_; }

 private:
  bool prepare(const Candidate& candidate, double largest_excess, Trial& trial) const;
  Trial unchanged_trial(const Candidate& candidate, std::size_t index, std::size_t k) const;
  void run(std::span<const Candidate> candidates, std::size_t k, std::vector<Trial>& trials);
  void add_child(const Candidate& parent, std::size_t index, std::size_t k, const Tolerance& tolerance,
                 const Trial& trial, std::vector<Candidate>& children) const;

  const Problem& problem_;
  int body_index_;
  const Body& body_;
  const Progress* progress_;
  Passages passages_;
  std::vector<Departure> departures_;
  std::vector<Passage> arrivals_;
};

}  // namespace ifa
