// What the engine makes of scenes that call for neither spin coupling, sustained contact nor circular edges.
// Compiled twice: as everything else is, and in the namespace ifa_plain with these effects compiled out.
#pragma once

#include <vector>

namespace ifa {

// Times, states and impulses of flights, impacts and batches, number after number.
std::vector<double> trace();

}  // namespace ifa
