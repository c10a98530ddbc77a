// Transition edges of the contact-event graph: which flights could be flown in place of one's own (paper
// section 5.2). They depend on the database alone and are made once for it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

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
  Column<std::uint8_t> element;  // (m) index into Symmetry::elements()
};

inline constexpr double kCostUnit =
    20.0 / 65535.0;  // both factors at their least, over all values of 16 bits

using TransitionColumns = TransitionTable<Owned>;
using Transitions = TransitionTable<View>;

Transitions view_of(const TransitionColumns& columns);

}  // namespace ifa
