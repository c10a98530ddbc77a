#include "ifa/forward/steepest.hpp"

#include <cmath>

namespace ifa {

std::optional<Steepest> steepest(std::span<const Sample6> samples) {
  constexpr int kFewest = 4;
  constexpr double kRidge = 0.02;  // of squared coordinates, which are of order 1
  Vec6 centre = Vec6::Zero();
  double mean = 0.0;
  int n = 0;
  for (const Sample6& s : samples) {
    if (!std::isfinite(s.value)) continue;
    centre += s.y;
    mean += s.value;
    ++n;
  }
  if (n < kFewest) return std::nullopt;
  centre /= n;
  mean /= n;
  Mat6 squares = kRidge * Mat6::Identity();
  Vec6 moment = Vec6::Zero();
  for (const Sample6& s : samples) {
    if (!std::isfinite(s.value)) continue;
    const Vec6 y = s.y - centre;
    squares += y * y.transpose();
    moment += y * (s.value - mean);
  }
  const Vec6 gradient = squares.ldlt().solve(moment);
  const double slope = gradient.norm();
  if (!(slope > 0.0)) return std::nullopt;
  return Steepest{gradient / slope, slope, mean - gradient.dot(centre)};
}

}  // namespace ifa
