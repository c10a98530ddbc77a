// The event engine's kernels for each instruction set.
#pragma once

#include <span>

#include "ifa/rigid/lanes/sim.hpp"

namespace ifa::lanes {

// Those that this processor runs, in ascending width; the scalar ones come first. All give the same bits.
std::span<const Kernels* const> available_kernels();

}  // namespace ifa::lanes
