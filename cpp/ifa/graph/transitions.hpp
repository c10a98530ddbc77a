// Transition edges of the contact-event graph: which flights could be flown in place of one's own (paper
// section 5.2). They depend on the database alone and are made once for it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/graph/images.hpp"
#include "ifa/graph/nodes.hpp"

namespace ifa {

// In rows: those of node i are first[i] to first[i + 1] - 1, the best first. One leads from i to `target`,
// whose own simulation came there from node target - 1, by a splice of the image of target - 1 under the
// `element` of the body's symmetry group.
template <template <class> class Column>
struct TransitionTable {
  Column<std::uint64_t> first;   // (n + 1)
  Column<std::uint32_t> target;  // (m)
  Column<std::uint16_t> cost;    // (m) -log(f_v f_q) in units of kCostUnit
  Column<std::uint8_t> element;  // (m) number in Images
};

inline constexpr double kCostUnit =
    20.0 / 65535.0;  // both factors at their least, over all values of 16 bits

using TransitionColumns = TransitionTable<Owned>;
using Transitions = TransitionTable<View>;

Transitions view_of(const TransitionColumns& columns);

// A node that can be left in flight, and whose flight can be flown by others: it leads to the next event, and
// nobody could hear that differently.
inline bool flies(const Nodes& nodes, std::size_t i) {
  return nodes.flight_s[i] > 0.0f && (nodes.flags[i] & kEdge) != 0 && (nodes.flags[i] & kDubious) == 0;
}

// From each node that flies, the `most` best splices of other such nodes' flights, over all of `images`, with
// log f_v and log f_q above kLeastLogFactor and no gain of energy beyond `gain_j`. Of the images of one flight
// only the best: they lead to the same event. Exact: nothing within these limits is missed but what rounding
// decides. The same bytes for any number of threads; a cancelled `progress` ends it with Cancelled.
TransitionColumns make_transitions(const Nodes& nodes, const Body& body, const Images& images,
                                   double gravity_m_s2, double gain_j, std::size_t most, int threads,
                                   Progress* progress = nullptr);

}  // namespace ifa
