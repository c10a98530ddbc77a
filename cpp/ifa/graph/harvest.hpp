// Random simulations, and the nodes they yield (paper section 5.1).
#pragma once

#include <cstdint>

#include "ifa/graph/nodes.hpp"
#include "ifa/motion/sampling.hpp"
#include "ifa/solution/passage.hpp"

namespace ifa {

// The nodes of simulations `first` to `first + count - 1` of the seed, in their order: each begins at its
// sampled state before a contact and runs to rest, for `until_s` at most. A simulation's nodes depend on its
// number and the seed alone. One thread; a cancelled `progress` ends it with Cancelled.
NodeColumns harvest(const Body& body, const SearchPhysics& physics, const SamplingOptions& sampling,
                    std::uint64_t seed, std::uint64_t first, std::size_t count, double until_s,
                    const Progress* progress = nullptr);

}  // namespace ifa
