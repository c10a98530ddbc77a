#include "ifa/rigid/symmetry.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "ifa/base/error.hpp"
#include "ifa/rigid/symmetry_search.hpp"

namespace ifa {
namespace {

constexpr double kPi = std::numbers::pi;

Mat3 turn(const Vec3& axis, double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

Mat3 mirror(const Vec3& normal) { return Mat3::Identity() - 2.0 * normal * normal.transpose(); }

// Turns a half plane onto itself and through; see Symmetry::elements.
std::vector<SymmetryElement> half_plane_maps(const Vec3& axis, const Vec3& side, bool flips) {
  const Mat3 through = mirror(axis.cross(side)), flip = mirror(axis);
  if (!flips) return {{Mat3::Identity(), true}, {through, false}};
  return {{Mat3::Identity(), true}, {through * flip, true}, {through, false}, {flip, false}};
}

}  // namespace

Symmetry Symmetry::of(const Body& body, double tolerance) {
  if (!(tolerance > 0.0 && tolerance <= 0.01))
    throw ArgumentError("tolerance: must lie above 0 and be at most 0.01");
  FoundSymmetry found = find_symmetry(body, tolerance);
  return Symmetry(found.kind, found.axis, std::move(found.elements), tolerance);
}

Symmetry::Symmetry(Kind kind, const Vec3& axis, std::vector<SymmetryElement> elements, double tolerance)
    : kind_(kind), axis_(axis), side_(across(axis)), elements_(std::move(elements)), slack_(tolerance) {
  if (kind_ != Kind::finite) {
    flips_ = kind_ == Kind::axial && elements_.size() > 1;
    elements_ = half_plane_maps(axis_, side_, flips_);
    return;
  }
  const Vec3 d = generic_direction(elements_);
  for (const SymmetryElement& g : elements_) pulled_.push_back(g.map.transpose() * d);
  for (std::size_t i = 1; i < pulled_.size(); ++i) walls_.push_back(d - pulled_[i]);
  // most images that are not near fail at a wall close to d
  std::stable_sort(walls_.begin(), walls_.end(),
                   [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  for (Vec3& wall : walls_) wall.normalize();
}

Mat3 Symmetry::turn_away(const Vec3& up) const {
  if (kind_ == Kind::ball) return Quat::FromTwoVectors(up, axis_).normalized().toRotationMatrix();
  return turn(axis_, -std::atan2(axis_.cross(side_).dot(up), side_.dot(up)));
}

int Symmetry::fold_element(const Vec3& up) const {
  if (kind_ != Kind::finite) return flips_ && axis_.dot(up) < 0.0 ? 1 : 0;
  int best = 0;
  double largest = pulled_[0].dot(up);
  for (int i = 1; i < static_cast<int>(pulled_.size()); ++i)
    if (const double along = pulled_[i].dot(up); along > largest) {
      largest = along;
      best = i;
    }
  return best;
}

SymmetryElement Symmetry::fold(const Vec3& up) const {
  const SymmetryElement& element = elements_[fold_element(up)];
  if (kind_ == Kind::finite) return element;
  return {element.map * turn_away(up), element.proper};
}

std::vector<SymmetryElement> Symmetry::images_near(const Vec3& up, double max_angle_rad,
                                                   double max_turn_rad) const {
  if (!(max_angle_rad >= 0.0)) throw ArgumentError("max_angle_rad: must not be negative");
  const double sine = max_angle_rad < 0.5 * kPi ? std::sin(max_angle_rad) : 1.0;
  std::vector<SymmetryElement> images;
  if (kind_ == Kind::finite) {
    for (const SymmetryElement& g : elements_) {
      const Vec3 w = g.map * up;
      // within an angle of the domain is within that angle of each of its hemispheres
      if (std::all_of(walls_.begin(), walls_.end(),
                      [&](const Vec3& wall) { return wall.dot(w) >= -sine - slack_; }))
        images.push_back(g);
    }
    return images;
  }

  if (!(max_turn_rad > 0.0)) throw ArgumentError("max_turn_rad: must be above 0");
  const Mat3 away = turn_away(up);
  const double along = axis_.dot(up), radius = (up - along * axis_).norm();
  const bool any_turn = kind_ == Kind::ball || radius <= sine + slack_;
  const double range = any_turn ? kPi : std::asin((sine + slack_) / radius);
  // the middles of an odd number of equal parts: one of them is no turn
  const int half = static_cast<int>(std::ceil(std::max(0.0, range / max_turn_rad - 0.5)));
  const double step = 2.0 * range / (2 * half + 1);
  for (const SymmetryElement& g : elements_) {
    if (flips_ && axis_.dot(g.map * axis_) * along < -sine - slack_) continue;  // beyond the quarter
    for (int k = -half; k <= half; ++k) images.push_back({g.map * turn(axis_, k * step) * away, g.proper});
  }
  return images;
}

State image(const SymmetryElement& g, const State& s) {
  State out = s;
  if (g.proper) {
    out.orientation = (s.orientation * Quat(Mat3(g.map.transpose()))).normalized();
    return out;
  }
  // M R g^-1 = (M R M) (M g^-1), both turns; M R M turns by the mirrored rotation vector, an axial one
  const Quat& q = s.orientation;
  out.orientation =
      (Quat(q.w(), -q.x(), q.y(), -q.z()) * Quat(Mat3(kWorldMirror * g.map.transpose()))).normalized();
  out.position = kWorldMirror * s.position;
  out.velocity = kWorldMirror * s.velocity;
  out.angular_velocity = -(kWorldMirror * s.angular_velocity);
  return out;
}

}  // namespace ifa
