// Ways to leave an event, tried side by side.
#pragma once

#include <span>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/base/random.hpp"
#include "ifa/forward/candidate.hpp"

namespace ifa {

// One way: a point of the plausible region's 6-ball, and what became of it.
struct Trial {
  std::size_t candidate = 0;  // index
  Vec6 y = Vec6::Zero();
  State after;
  double excess = 0.0;
  Passage passage;
  // At the next mark; of the last event, by how much it lasts longer than its mark. Infinite where no hit
  // came, or the motion does not end as asked.
  double lateness_s = kNever;
  bool meets = false;  // a hit that can be told, or the ending as asked

  // Log of all factors of the event k that it leaves and, where it hits, of the way to the next.
  double log_factors(const Problem& problem, std::size_t k, double first_amplitude) const;
};

// Works on candidates of one body that are at one event.
class Trials {
 public:
  Trials(const Problem& problem, int body, const Progress* progress);

  // Leaves with the change `y`; nothing where it is not allowed: beyond `largest_excess`, or with more energy
  // than it came with and the gain that is granted (f_E, paper eq. 10).
  std::optional<Trial> propose(std::span<const Candidate> candidates, std::size_t index, const Vec6& y,
                               double largest_excess) const;

  PlausibleRegion region(const Onset& onset) const;

  // The change that leaves `onset` with `after`.
  Vec6 change(const Onset& onset, const State& after) const;

  // What look_ahead has seen.
  Trial unchanged(std::span<const Candidate> candidates, std::size_t index, std::size_t k) const;

  // Simulates them from event k on.
  void run(std::span<const Candidate> candidates, std::size_t k, std::span<Trial> trials);

  // Lets events k go on unchanged.
  std::vector<Passage> follow(std::span<const Onset> onsets, std::size_t k);

  const Problem& problem() const { return problem_; }
  const Body& body() const { return body_; }
  int body_index() const { return body_index_; }
  Passages& passages() { return passages_; }

 private:
  const Problem& problem_;
  int body_index_;
  const Body& body_;
  const Progress* progress_;
  Passages passages_;
  std::vector<Departure> departures_;
  std::vector<Passage> arrivals_;
};

// Whether a passage that leaves the last event ends as the marks ask.
bool ends_as_asked(const Passage& passage, Ending ending);

// A random point of the ball in which |y|^2 is at most `largest_excess`, mild ones more often than evenly.
Vec6 random_change(double largest_excess, RandomStream& random);

}  // namespace ifa
