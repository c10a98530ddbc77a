// What a solve keeps for another one of almost the same marks.
#pragma once

#include "ifa/forward/beam.hpp"
#include "ifa/forward/solve.hpp"

namespace ifa {

struct KeptSearch {
  std::vector<Body> bodies;  // the given one first
  SearchPhysics physics;
  Marks marks;  // as the plan has them
  Plan plan;
  int rung;
  Beam beam;
};

// How many marks at the start are the same in every respect.
std::size_t marks_in_common(const Marks& a, const Marks& b);

// Throws ArgumentError unless `kept` is of this body and these options.
void check_reuse(const KeptSearch& kept, const Body& body, const SearchPhysics& physics, const Plan& plan);

}  // namespace ifa
