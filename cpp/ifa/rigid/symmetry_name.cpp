// Schoenflies' name of a point group, from the elements alone.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "ifa/rigid/symmetry.hpp"

namespace ifa {
namespace {

constexpr double kSame = 1e-3;  // of matrix entries; far above noise, far below the least turn, 2 pi / 255

// How often a turn has to be repeated.
int order_of(const Mat3& rotation) {
  constexpr double kNoise = 1e-5;  // of the angle; 255 times that is less than the 1 / 255 between two orders
  const double angle = Eigen::AngleAxisd(rotation).angle();
  if (angle < kNoise) return 1;
  for (int n = 2; n <= Symmetry::kMostElements; ++n) {
    const double turns = n * angle / (2.0 * std::numbers::pi);
    if (std::abs(turns - std::round(turns)) < kNoise * n) return n;
  }
  return 1;
}

bool same(const Mat3& a, const Mat3& b) { return (a - b).cwiseAbs().maxCoeff() < kSame; }

}  // namespace

std::string Symmetry::name() const {
  if (kind_ == Kind::ball) return "Kh";
  if (kind_ == Kind::axial) return flips_ ? "Dinfh" : "Cinfv";

  int turns = 0, n = 1;
  Vec3 main = kUp;  // axis of the turn of highest order
  for (const SymmetryElement& g : elements_) {
    if (!g.proper) continue;
    ++turns;
    if (const int order = order_of(g.map); order > n) {
      n = order;
      main = Eigen::AngleAxisd(g.map).axis();
    }
  }
  const bool improper = elements_.size() > static_cast<std::size_t>(turns);
  const auto has = [&](const Mat3& map) {
    return std::any_of(elements_.begin(), elements_.end(), [&](const auto& g) { return same(g.map, map); });
  };
  const bool inversion = has(-Mat3::Identity());
  if (turns == 12 && n == 3) return improper ? (inversion ? "Th" : "Td") : "T";
  if (turns == 24 && n == 4) return improper ? "Oh" : "O";
  if (turns == 60 && n == 5) return improper ? "Ih" : "I";

  const bool across_axis = has(Mat3::Identity() - 2.0 * main * main.transpose());
  const bool along_axis = std::any_of(elements_.begin(), elements_.end(), [&](const auto& g) {
    return !g.proper && (g.map * main - main).norm() < kSame;
  });
  const auto named = [](char letter, int order, const char* ending) {
    return std::string(1, letter).append(std::to_string(order)).append(ending);
  };
  if (turns > n) return named('D', n, !improper ? "" : across_axis ? "h" : "d");
  if (!improper) return named('C', n, "");
  if (n == 1) return inversion ? "Ci" : "Cs";
  if (across_axis) return named('C', n, "h");
  return along_axis ? named('C', n, "v") : named('S', 2 * n, "");
}

}  // namespace ifa
