// Looks up which of many points lies within a small distance of a place.
#pragma once

#include <vector>

#include "ifa/base/linear_algebra.hpp"

namespace ifa {

// Points sorted along one direction of irrational slopes, in which only true neighbours come close as a rule.
// Small distances only: those much below the distance of most points.
class NearPoints {
 public:
  explicit NearPoints(const std::vector<Vec3>& points);

  // The lowest index of a point within `distance` of p; -1 if there is none.
  int first_within(const Vec3& p, double distance) const;

 private:
  std::size_t bucket(double along) const;

  struct Place {
    double along;
    int index;
    Vec3 point;
  };
  std::vector<Place> places_;       // sorted along the direction
  std::vector<std::size_t> start_;  // first place of each bucket, and one past the last
  double low_ = 0.0, per_length_ = 0.0;
};

}  // namespace ifa
