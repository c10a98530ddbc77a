// Simulates again what a database does not store: the motion along an edge, from its stored beginning.
#pragma once

#include "ifa/graph/database.hpp"
#include "ifa/solution/passage.hpp"

namespace ifa {

// A simulation that does not lead where the stored one did: of another engine or processor.
class ReplayError : public Error {
 public:
  using Error::Error;
};

// Two states farther apart than this (state_difference) are not the same node.
inline constexpr double kReplayTolerance = 1e-6;

// How far apart two states of a body are, but for where on the plane: the largest of the difference in
// height, in bounding radii; the angle between the orientations, rad; the difference in velocity, and in spin
// times the bounding radius, as shares of the larger state's own speed |v| + R |omega|.
double state_difference(const Body& body, const State& a, const State& b);

// Node i's simulated edge, from its onset to the next one; from a terminal node to rest. Begins at x = y = 0.
// `passage.onset` is the next one's, both sides of its impact; `passage.event` is the node's, as stored.
// Throws ArgumentError where nothing follows node i (its simulation ended there, in flight or in contact),
// ReplayError naming it where the next onset differs from that of node i + 1, or rest is not reached.
Passage replay_edge(const Database& database, std::size_t i, Record& record,
                    const Progress* progress = nullptr);

// Node i's onset, both sides and the hit: from the edge that leads there, or at the beginning of a simulation
// from its sampled state. Throws ReplayError as above.
Onset replay_onset(const Database& database, std::size_t i, const Progress* progress = nullptr);

}  // namespace ifa
