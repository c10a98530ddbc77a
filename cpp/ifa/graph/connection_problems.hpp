// Connections to make, as the search of a graph meets them: to measure with.
#pragma once

#include <cstdint>
#include <vector>

#include "ifa/rigid/body.hpp"
#include "ifa/rigid/state.hpp"

namespace ifa {

struct ConnectionProblem {
  State from, like, to;  // as Connector::connect has them
  double duration_s;
  double flight_s;  // of the node's own flight, which touches the ground at both ends
};

// Random pairs of states within the paper's cut-off, log f_v > -10 and log f_q > -10: the take-off of a node
// of so many simulations, and that of another motion, which is the first one changed at random within the
// cut-off and whose flight of 0.02 to 0.5 s leads to the target. Throws ArgumentError where no simulation
// leaves the ground.
std::vector<ConnectionProblem> draw_connection_problems(const Body& body, std::uint64_t seed,
                                                        std::size_t simulations, std::size_t count,
                                                        const Vec3& gravity_m_s2);

}  // namespace ifa
