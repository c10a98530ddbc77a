// What a solve keeps for another one of almost the same marks.
#pragma once

#include "ifa/forward/beam.hpp"
#include "ifa/forward/solve.hpp"

namespace ifa {

struct KeptSearch {
  std::vector<Body> bodies;  // the given one first
  SearchPhysics physics;
  Marks marks;
  bool fit_material;
  int rung;
  Beam beam;
};

// How many marks at the start are the same in every respect.
std::size_t marks_in_common(const Marks& a, const Marks& b);

// Throws ArgumentError unless `kept` is of this body and these options.
void check_reuse(const KeptSearch& kept, const Body& body, const SearchPhysics& physics, bool fit_material);

}  // namespace ifa
