// Conversion of states and hits, shared by the bindings.
#pragma once

#include "bindings.hpp"
#include "ifa/rigid/run.hpp"

namespace ifa::bindings {

// (positions (n, 3), quaternions wxyz (n, 4), velocities (n, 3), angular velocities (n, 3)) of states that
// have nothing to do with each other ...
py::tuple from_samples(const std::vector<State>& samples);
// ... and along a motion, where the sign of each quaternion follows its predecessor's
py::tuple from_states(std::vector<State> states);

// (times (n,), impulses (n, 3), approach speeds (n,), positions (n, 3))
py::tuple from_hits(const std::vector<Hit>& hits);

}  // namespace ifa::bindings
