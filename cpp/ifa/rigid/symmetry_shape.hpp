// What the maps of a body onto itself have to fit: its hull, rings and inertia, without scale.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "ifa/rigid/body.hpp"
#include "ifa/rigid/near_points.hpp"

namespace ifa {

// Points as columns of coordinates, to be projected on a direction all at once.
class Projected {
 public:
  explicit Projected(const std::vector<Vec3>& points)
      : coordinates_(points.size(), 3), along_(coordinates_.rows()) {
    for (Eigen::Index i = 0; i < coordinates_.rows(); ++i)
      coordinates_.row(i) = points[static_cast<std::size_t>(i)].transpose();
  }

  Eigen::ArrayXd& on(const Vec3& d) {
    along_ = d.x() * coordinates_.col(0) + d.y() * coordinates_.col(1) + d.z() * coordinates_.col(2);
    return along_;
  }

 private:
  Eigen::Array<double, Eigen::Dynamic, 3> coordinates_;
  Eigen::ArrayXd along_;
};

// The body in units of its bounding radius and its largest moment.
class SymmetryShape {
 public:
  SymmetryShape(const Body& body, double tolerance);

  bool maps_onto_itself(const Mat3& g) const { return may_map(g) && vertices_fit(g, vertices_.size()); }
  // As far as the inertia, the rings and a few corners tell.
  bool may_map(const Mat3& g) const {
    return inertia_fits(g) && rings_fit(g) && vertices_fit(g, std::min<std::size_t>(corners_, 8));
  }

  // A place that the group must carry to places alike.
  struct Feature {
    Vec3 at;
    int kind;  // vertex, pole of a ring, tip of a principal axis
    double moment;
    int likeness = 0;  // the same for all that could be images of each other (and by chance for others)
  };
  std::vector<Feature> hull_features() const;
  std::vector<Feature> inertia_features() const;

  double tolerance() const { return tolerance_; }

 private:
  struct HalfSpace {
    Vec3 normal;
    double offset;
  };

  bool inertia_fits(const Mat3& g) const;
  bool rings_fit(const Mat3& g) const;
  bool vertices_fit(const Mat3& g, std::size_t first_ones) const;
  void corners_first(const std::vector<Vec3>& outwards);
  std::vector<Vec3> mean_normals() const;
  const std::vector<HalfSpace>& inside() const;
  Feature feature(const Vec3& at, int kind) const { return {at, kind, at.dot(moments_.cwiseProduct(at))}; }

  double tolerance_;
  Vec3 moments_;
  std::vector<Ring> rings_;
  std::vector<Vec3> vertices_;  // corners first
  std::size_t corners_ = 0;     // vertices that are surely not just noise on a face or an edge
  mutable std::optional<std::vector<HalfSpace>> inside_;  // see inside()
  NearPoints near_vertices_{{}};
};

}  // namespace ifa
