// From candidates at one event to their children at the next, and from the last event to the end.
#pragma once

#include <span>
#include <vector>

#include "ifa/forward/trial.hpp"

namespace ifa {

struct ExpandOptions {
  int proposals;  // root searches for each candidate, at most
  int variants;   // of each that succeeds
  Tolerance tolerance;
  bool first_round;  // of proposals for these candidates
};

// Works on candidates of one body. Each impact is changed within the plausible region (paper section 5.4) so
// that the next audible hit comes exactly when the next mark asks for it.
class Expander {
 public:
  Expander(const Problem& problem, int body, const Progress* progress) : trials_(problem, body, progress) {}

  // Children of `parents`, which are at event k and have the indices from `first`, appended and looked ahead
  // for. `random[i]` is parent i's. A handful of changes is scattered over the region, one more goes where
  // these say that the mark is; between those that come early and late the exact one is sought, and varied.
  void expand(std::span<const Candidate> parents, std::size_t first, std::size_t k,
              const ExpandOptions& options, std::span<RandomStream> random, std::vector<Candidate>& children);

  // Those children to which nothing is changed.
  void follow(std::span<const Candidate> parents, std::size_t first, std::size_t k,
              std::vector<Candidate>& children);

  // The children that keep to a known motion, which struck as `wanted` after it had left event k as `link`
  // says.
  void track(std::span<const Candidate> parents, std::size_t first, std::size_t k, const Link& link,
             const Onset& wanted, std::span<RandomStream> random, std::vector<Candidate>& children);

  // Lets candidates at event k go on unchanged, and guesses how well the next mark, or the ending, will be
  // met.
  void look_ahead(std::span<Candidate> candidates, std::size_t k);

  // The mildest change of the last impact after which each candidate's motion ends as the marks ask; its
  // excess is infinite where none was found. What sounds after the last mark is made softer from round to
  // round.
  std::vector<Trial> finish(std::span<const Candidate> candidates, int rounds, double largest_excess,
                            std::span<RandomStream> random);

  Passages& passages() { return trials_.passages(); }
  double simulated_s() { return trials_.passages().simulated_s(); }

 private:
  std::vector<Trial> scatter(std::span<const Candidate> parents, std::size_t k, const ExpandOptions& options,
                             std::span<RandomStream> random);
  double miss(const Passage& passage, std::size_t k) const;
  double toll(const Candidate& candidate, const Passage& passage, std::size_t k) const;
  void add_child(const Candidate& parent, std::size_t index, std::size_t k, const Tolerance& tolerance,
                 const Trial& trial, std::vector<Candidate>& children) const;

  Trials trials_;
};

}  // namespace ifa
