#include "ifa/signature/constraints.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "ifa/base/error.hpp"
#include "ifa/base/message.hpp"
#include "ifa/signature/marks.hpp"

namespace ifa {
namespace {

constexpr double kFarthest_m = 1e6;  // squares of what lies farther say nothing of centimetres

void check_mark(const Marks& marks, std::size_t k) {
  if (k < marks.size()) return;
  throw ArgumentError("constraints: there is no mark " + std::to_string(k + 1) + ", only " +
                      std::to_string(marks.size()));
}

void check_direction(const Vec3& v, const std::string& name) {
  if (!v.allFinite()) throw ArgumentError(name + " is not finite");
  if (v.isZero(0.0)) throw ArgumentError(name + " is 0 and points nowhere");
}

template <class Kind>
void forget(std::vector<Kind>& all, std::size_t k) {
  std::erase_if(all, [k](const Kind& c) { return c.mark == k; });
  for (Kind& c : all)
    if (c.mark != kAtRest && c.mark > k) --c.mark;
}

}  // namespace

void Constraints::forget_mark(std::size_t k) {
  forget(positions, k);
  forget(orientations, k);
}

void Constraints::forget_rest() {
  std::erase_if(orientations, [](const OrientationConstraint& c) { return c.mark == kAtRest; });
}

double orientation_constraint_factor(double angle_rad) {
  return std::exp(-kOrientationWeight * angle_rad * angle_rad);
}

double position_constraint_factor(double distance_m) {
  return std::exp(-kPositionWeight * distance_m * distance_m);
}

double angle_between_rad(const Vec3& a, const Vec3& b) {
  const Vec3 u = a.stableNormalized(), v = b.stableNormalized();
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

void validate_constraints(const Marks& marks) {
  const auto name = [&](std::size_t k) { return mark_name(k, marks.times_s[k]); };
  std::vector<char> placed(marks.size(), 0);
  for (const PositionConstraint& c : marks.constraints.positions) {
    check_mark(marks, c.mark);
    if (!c.position_m.allFinite()) throw ArgumentError(name(c.mark) + ": its position is not finite");
    if (!(c.position_m.cwiseAbs().maxCoeff() <= kFarthest_m))
      throw ArgumentError(name(c.mark) + ": its position is farther than 1000 km from the origin");
    if (placed[c.mark]) throw ArgumentError(name(c.mark) + ": has two positions");
    placed[c.mark] = 1;
  }
  for (const OrientationConstraint& c : marks.constraints.orientations) {
    if (c.mark != kAtRest) check_mark(marks, c.mark);
    if (c.mark == kAtRest && marks.ending != Ending::rest)
      throw ArgumentError("constraints: an orientation at rest needs marks with the ending \"rest\"");
    const std::string of = (c.mark == kAtRest ? "rest" : name(c.mark)) + ": the ";
    check_direction(c.body_direction, of + "body_direction of its orientation");
    check_direction(c.direction, of + "direction of its orientation");
  }
}

}  // namespace ifa
