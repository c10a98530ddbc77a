// Finds the orthogonal maps of a body onto itself; what `Symmetry::of` is made from.
#pragma once

#include <vector>

#include "ifa/rigid/symmetry.hpp"

namespace ifa {

struct FoundSymmetry {
  Symmetry::Kind kind;
  Vec3 axis;  // of axial; of ball any
  std::vector<SymmetryElement>
      elements;  // finite: all; axial: {1} or {1, a half turn across the axis}; ball: {1}
};

FoundSymmetry find_symmetry(const Body& body, double tolerance);

// A direction that every element but the first, the identity, moves far: the best of a fixed lot.
Vec3 generic_direction(const std::vector<SymmetryElement>& elements);

// A unit vector across `axis`: the projection of the coordinate axis that is most across it.
Vec3 across(const Vec3& axis);

}  // namespace ifa
