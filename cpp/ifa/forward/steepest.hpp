// Which way to go in the plausible region's 6-ball, from what a few trials there have shown.
#pragma once

#include <optional>
#include <span>

#include "ifa/base/linear_algebra.hpp"

namespace ifa {

struct Sample6 {
  Vec6 y;
  double value;
};

// A linear model of a function, fitted by ridge regression: fewer samples than unknowns give the smallest
// gradient. Samples that are not finite do not count; nothing if fewer than four do, or the function is flat.
struct Steepest {
  Vec6 along;     // the unit vector along which it grows most
  double slope;   // its growth there
  double middle;  // its value at 0

  // How far along the model says the function becomes 0.
  double root() const { return -middle / slope; }
};

std::optional<Steepest> steepest(std::span<const Sample6> samples);

}  // namespace ifa
