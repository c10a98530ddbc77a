// Many root searches for the instant of the next hit, side by side.
#pragma once

#include <span>
#include <vector>

#include "ifa/forward/root.hpp"
#include "ifa/forward/trial.hpp"

namespace ifa {

double ratio_of(double a, double b);  // the larger over the smaller

// Between a trial that comes early and one that comes late lies one that comes in time (the ball is convex),
// unless the interval jumps there.
struct Closing {
  Vec6 from, along;
  Bracket bracket;
  Trial best;              // of those that hit, by the product of its factors; excess infinite if none does
  double worth = -kNever;  // its logarithm
  double slope_s = 0.0;    // of the lateness along the line, where it was last looked at; 0 if unknown
  bool open = true;
};

// Pairs of trials of the same candidate that enclose the mark after event k, the mildest first, each trial
// used once, at most `most` for a candidate. `used` is set for those that are.
std::vector<Closing> enclose(const Problem& problem, std::span<const Trial> trials,
                             std::span<const Candidate> candidates, std::size_t k, std::size_t most,
                             std::vector<char>& used);

// Closes in on the mark.
void close_in(Trials& trials, std::span<const Candidate> candidates, std::size_t k, double largest_excess,
              std::vector<Closing>& closings);

// A trial that came in time, and a line along which its lateness can be corrected.
struct Anchor {
  Trial trial;
  Vec6 along;
  double slope_s;
};

// The best of each closing that can be corrected and lies within the tolerance.
std::vector<Anchor> anchors_of(const std::vector<Closing>& closings, double target_s,
                               const Tolerance& tolerance);

// Runs trials in place of the anchors' own, and brings them back to the mark along the anchors' lines, as far
// as two steps do.
std::vector<Anchor> run_anchors(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                                const Tolerance& tolerance, std::vector<Anchor> anchors);

// As near to `y` as a change may be.
Vec6 within(const Vec6& y, const Tolerance& tolerance);

// More that come in time: `count` for each anchor, off to its side and back along its line. Some of them
// miss.
std::vector<Anchor> vary(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                         const Tolerance& tolerance, std::span<const Anchor> anchors, int count,
                         std::span<RandomStream> random);

// More that come in time, and after an event k that lasts as long as its mark: about the best of each
// candidate's, and where a linear model of the length says. Some of them miss.
std::vector<Anchor> fit_length(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                               const Tolerance& tolerance, std::span<const Anchor> anchors,
                               std::span<RandomStream> random);

}  // namespace ifa
