#include "ifa/graph/images.hpp"

#include <numbers>

namespace ifa {
namespace {

// 6 degrees apart. With the four elements that flips and mirrors make at most, they fit a byte.
constexpr int kTurns = 60;

}  // namespace

Images::Images(const Symmetry& symmetry) : symmetry_(symmetry), elements_(symmetry.elements()) {
  if (symmetry.kind() == Symmetry::Kind::finite) return;
  const std::vector<SymmetryElement> still = elements_;
  for (int k = 1; k < kTurns; ++k)
    for (const SymmetryElement& e : still)
      elements_.push_back(
          {e.map * Eigen::AngleAxisd(2.0 * std::numbers::pi * k / kTurns, symmetry.axis()), e.proper});
}

Mat3 Images::folding(const Vec3& up) const {
  return symmetry_.kind() == Symmetry::Kind::finite ? Mat3(Mat3::Identity()) : symmetry_.fold(up).map;
}

SymmetryElement Images::element(std::size_t number, const Vec3& from_up, const Vec3& seen_up) const {
  const SymmetryElement& e = elements_[number];
  if (symmetry_.kind() == Symmetry::Kind::finite) return e;
  return {folding(from_up).transpose() * e.map * folding(seen_up), e.proper};
}

TakeOffView image(const SymmetryElement& g, const TakeOffView& view) {
  return {g.map * view.up, g.map * view.velocity, (g.proper ? 1.0 : -1.0) * (g.map * view.spin),
          view.height_m};
}

}  // namespace ifa
