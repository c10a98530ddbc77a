// An impact of a body at the points that touch the ground, for all test folders.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "ifa/rigid/contact.hpp"

namespace ifa::sample {

// The vertices within `within_m` of the ground, as contact points.
inline std::vector<ContactPoint> touching(const Body& body, const State& s, double within_m) {
  std::vector<ContactPoint> points;
  for (const Vec3& vertex : body.principal_vertices()) {
    ContactPoint p;
    p.arm = s.orientation * vertex - body.radius_m() * kUp;
    if (s.position.z() + p.arm.z() <= within_m) points.push_back(p);
  }
  return points;
}

inline ImpactResult strike(const Body& body, State& s, double within_m = 1e-12) {
  auto points = touching(body, s, within_m);
  EXPECT_FALSE(points.empty());
  return resolve_impact(body, 0.0, points, s);
}

}  // namespace ifa::sample
