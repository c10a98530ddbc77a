#include "ifa/rigid/symmetry_shape.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ifa {

SymmetryShape::SymmetryShape(const Body& body, double tolerance)
    : tolerance_(tolerance), moments_(body.principal_inertia() / body.principal_inertia().maxCoeff()) {
  const double scale = 1.0 / body.bounding_radius_m();
  for (const Vec3& p : body.principal_vertices()) vertices_.push_back(scale * p);
  for (const Ring& ring : body.principal_rings())
    rings_.push_back({scale * ring.centre_m, ring.axis, scale * ring.radius_m});
  // outwards as on an ellipsoid with the second moments of the mass, kept from being flat
  const Vec3 second = Vec3::Constant(0.5 * moments_.sum()) - moments_;
  const Vec3 weight = (second.array() + 1e-3 * second.sum()).inverse();
  std::vector<Vec3> outwards;
  for (const Vec3& p : vertices_) outwards.push_back(weight.cwiseProduct(p));
  corners_first(outwards);
  // too few to tell by: the normals of the hull tell better, but the hull takes longer than all else
  if (corners_ < 4 && corners_ < vertices_.size()) corners_first(mean_normals());
  near_vertices_ = NearPoints(vertices_);
}

// How far a vertex stands out from the hull of the others is at least its lead over them along any direction.
void SymmetryShape::corners_first(const std::vector<Vec3>& outwards) {
  Projected all(vertices_);
  std::vector<Vec3> corners, others;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    Eigen::ArrayXd& along = all.on(outwards[i].normalized());
    const double own =
        std::exchange(along[static_cast<Eigen::Index>(i)], -2.0);  // all are within 1 of the origin
    const bool stands_out = own - along.maxCoeff() > 4.0 * tolerance_;
    (stands_out ? corners : others).push_back(vertices_[i]);
  }
  corners_ = corners.size();
  vertices_ = std::move(corners);
  vertices_.insert(vertices_.end(), others.begin(), others.end());
}

// Of the faces at each vertex; no direction where the hull is flat.
std::vector<Vec3> SymmetryShape::mean_normals() const {
  std::vector<Vec3> outwards(vertices_.size(), Vec3::Zero());
  for (const HalfSpace& half : inside())
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      if (half.normal.dot(vertices_[i]) >= half.offset - 1e-12) outwards[i] += half.normal;  // rounding
  return outwards;
}

// The half spaces of which the hull is the intersection; none where it is flat or has rings.
const std::vector<SymmetryShape::HalfSpace>& SymmetryShape::inside() const {
  if (inside_) return *inside_;
  inside_.emplace();
  if (!rings_.empty() || vertices_.size() < 4) return *inside_;
  const Hull hull = convex_hull(vertices_);
  for (const Triangle& t : hull.triangles) {
    const Vec3 &a = hull.vertices[t[0]], &b = hull.vertices[t[1]], &c = hull.vertices[t[2]];
    const Vec3 area = (b - a).cross(c - a);
    if (!(area.norm() > 0.0)) continue;
    const Vec3 normal = area.normalized();
    inside_->push_back({normal, std::max({normal.dot(a), normal.dot(b), normal.dot(c)})});
  }
  return *inside_;
}

bool SymmetryShape::inertia_fits(const Mat3& g) const {
  const Mat3 carried = g * moments_.asDiagonal() * g.transpose();
  return (carried - Mat3(moments_.asDiagonal())).cwiseAbs().maxCoeff() <= tolerance_;
}

bool SymmetryShape::rings_fit(const Mat3& g) const {
  return std::all_of(rings_.begin(), rings_.end(), [&](const Ring& ring) {
    const Vec3 centre = g * ring.centre_m, axis = g * ring.axis;
    return std::any_of(rings_.begin(), rings_.end(), [&](const Ring& other) {
      return (centre - other.centre_m).norm() <= tolerance_ &&
             std::abs(ring.radius_m - other.radius_m) <= tolerance_ &&
             ring.radius_m * axis.cross(other.axis).norm() <= tolerance_;
    });
  });
}

bool SymmetryShape::vertices_fit(const Mat3& g, std::size_t first_ones) const {
  for (std::size_t i = 0; i < first_ones; ++i) {
    const Vec3 p = g * vertices_[i];
    if (near_vertices_.first_within(p, tolerance_) >= 0) continue;
    // it may be noise on a face, where the other side has none
    if (i < corners_ || inside().empty()) return false;
    for (const HalfSpace& half : inside())
      if (half.normal.dot(p) > half.offset + tolerance_) return false;
  }
  return true;
}

std::vector<SymmetryShape::Feature> SymmetryShape::hull_features() const {
  std::vector<Feature> features;
  const std::size_t used = corners_ > 0 ? corners_ : vertices_.size();
  for (std::size_t i = 0; i < used; ++i) features.push_back(feature(vertices_[i], 0));
  for (const Ring& ring : rings_)
    for (const double side : {1.0, -1.0})
      features.push_back(feature(ring.centre_m + side * ring.radius_m * ring.axis, 1));
  return features;
}

// Where the hull leaves a turn open, the inertia may not.
std::vector<SymmetryShape::Feature> SymmetryShape::inertia_features() const {
  std::vector<Feature> features;
  for (int i = 0; i < 3; ++i) {
    const double nearest = std::min(std::abs(moments_[i] - moments_[(i + 1) % 3]),
                                    std::abs(moments_[i] - moments_[(i + 2) % 3]));
    if (nearest > tolerance_)
      for (const double side : {1.0, -1.0}) features.push_back(feature(side * Vec3::Unit(i), 2 + i));
  }
  return features;
}

}  // namespace ifa
