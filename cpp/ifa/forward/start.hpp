// First contacts to begin a search from (paper section 5.1).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "ifa/base/random.hpp"
#include "ifa/forward/candidate.hpp"

namespace ifa {

struct StartOptions {
  double least_speed_m_s;  // speed: uniform between these
  double most_speed_m_s;
  double clear_s;                                    // the flight before must last this long; 0: none is
  std::optional<OrientationConstraint> facing = {};  // at the first mark
};

// The paper's 0.5 to 4 m/s; further where a gap between marks needs it.
StartOptions start_options(const Body& body, const Marks& marks, double gravity_m_s2);

// A random pre-contact state in principal axes: any orientation, pushed into contact at its lowest point, a
// velocity cosine-weighted about straight down, a spin of random direction. Half are dropped (the paper's 30
// degrees and up to 20 rad/s), half are thrown to roll (the paper's 80 degrees for rolling bodies, and a spin
// up to that of rolling). None if the lowest point does not approach audibly or the flight before is too
// short.
std::optional<State> sample_start(const Body& body, const SearchPhysics& physics, const StartOptions& options,
                                  RandomStream& random);

// A gentle touchdown near a pose in which the body can rest, for a motion that shall rest after a single
// mark: the end of a random drop, tilted by 1e-4 to 0.1 rad, falling at 0.06 to 1 m/s. None as above.
std::optional<State> sample_touchdown(const Body& body, const SearchPhysics& physics,
                                      const StartOptions& options, RandomStream& random);

// First contacts of one body, one at most from each stream, appended: their speeds are chosen so that the
// second mark is met without any change. Where no start leads to a second hit at all, those that just end
// there.
void begin_candidates(const Problem& problem, int body, Passages& passages, std::span<RandomStream> random,
                      std::vector<Candidate>& out, const Progress* progress);

}  // namespace ifa
