// Bodies whose symmetry groups are in every textbook.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "ifa/rigid/body.hpp"
#include "sample_bodies.hpp"

namespace ifa::sample {

// A solid of even density with these corners (and rings), its edges rounded.
inline Body solid(const std::vector<Vec3>& corners, double rounding_m, const std::vector<Ring>& rings = {}) {
  Body::Definition d;
  d.vertices_m = corners;
  d.rings_m = rings;
  d.radius_m = rounding_m;
  const MassProperties mass = rounded_hull_mass_properties(corners, rounding_m, 1200.0, rings);
  d.mass_kg = mass.mass_kg;
  d.centre_of_mass_m = mass.centre_of_mass_m;
  d.inertia_kg_m2 = mass.inertia_kg_m2;
  return Body::make(d);
}

// All signs of the coordinates, and with `cyclic` all turns of their order.
inline std::vector<Vec3> signed_points(const Vec3& p, bool cyclic) {
  std::vector<Vec3> points;
  for (int shift = 0; shift < (cyclic ? 3 : 1); ++shift)
    for (int signs = 0; signs < 8; ++signs) {
      Vec3 q(p[shift], p[(shift + 1) % 3], p[(shift + 2) % 3]);
      bool is_new = true;
      for (int i = 0; i < 3; ++i)
        if (signs >> i & 1) {
          is_new = is_new && q[i] != 0.0;
          q[i] = -q[i];
        }
      if (is_new) points.push_back(q);
    }
  return points;
}

inline std::vector<Vec3> tetrahedron() { return {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}; }

inline std::vector<Vec3> dodecahedron() {
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  std::vector<Vec3> points = signed_points({1, 1, 1}, false);
  const std::vector<Vec3> others = signed_points({0, 1 / golden, golden}, true);
  points.insert(points.end(), others.begin(), others.end());
  return points;
}

inline std::vector<Vec3> icosahedron() { return signed_points({0, 1, 0.5 * (1.0 + std::sqrt(5.0))}, true); }

// Corners of n-sided rings at z = height and, turned by `twist` parts of a side, at -height.
inline std::vector<Vec3> prism(int n, double height, double twist = 0.0) {
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i)
    for (const double side : {0.0, 1.0}) {
      const double angle = 2.0 * std::numbers::pi * (i + side * twist) / n;
      points.push_back({std::cos(angle), std::sin(angle), side > 0.0 ? -height : height});
    }
  return points;
}

// Ten equal faces: rings at +-h and tips at +-1, four corners in a plane.
inline std::vector<Vec3> trapezohedron() {
  const double c = std::cos(std::numbers::pi / 5.0);
  std::vector<Vec3> points = prism(5, (1.0 - c) / (1.0 + c), 0.5);
  points.push_back({0, 0, 1});
  points.push_back({0, 0, -1});
  return points;
}

inline std::vector<Vec3> scaled(double factor, std::vector<Vec3> points) {
  for (Vec3& p : points) p *= factor;
  return points;
}

struct Symmetric {
  std::string name;  // Schoenflies'
  std::size_t order;
  Body body;
};

inline std::vector<Symmetric> finite_bodies() {
  const double r = 0.01, rounding = 8e-4;
  std::vector<Vec3> pyramid = prism(4, 0.0);
  pyramid.push_back({0, 0, 1.3});
  std::vector<Vec3> wedge{{1, 0.3, 0.7}, {1, 0.3, -0.7}, {-1, 0.2, 0.4}, {-1, 0.2, -0.4}, {0.1, -1, 0}};
  std::vector<Vec3> slanted{{1, 0.2, 0.3}, {-0.4, 0.9, 0.1}, {0.3, -0.2, 1.1}};  // a box of no right angle
  for (int i = 0; i < 3; ++i) slanted.push_back(-slanted[i]);
  const std::vector<Vec3> irregular{{1, 0, 0}, {-0.7, 0.5, 0.2}, {-0.2, -0.9, 0.4}, {0.1, 0.3, -0.8}};
  return {{"Td", 24, solid(scaled(r, tetrahedron()), rounding)},
          {"Oh", 48, solid(scaled(r, signed_points({1, 1, 1}, false)), rounding)},
          {"Oh", 48, solid(scaled(r, signed_points({1, 0, 0}, true)), rounding)},
          {"Th", 24, solid(scaled(r, signed_points({1, 0.4, 0.7}, true)), rounding)},
          {"D5d", 20, solid(scaled(r, trapezohedron()), rounding)},
          {"Ih", 120, solid(scaled(r, dodecahedron()), rounding)},
          {"Ih", 120, solid(scaled(r, icosahedron()), rounding)},
          {"D2h", 8, solid(scaled(r, signed_points({2.15, 0.85, 0.55}, false)), rounding)},
          {"D2h", 8, solid(scaled(0.04, signed_points({1.07, 0.675, 0.007}, false)), 1e-4)},
          {"D7h", 28, solid(scaled(r, prism(7, 0.4)), rounding)},
          {"D4d", 16, solid(scaled(r, prism(4, 0.5, 0.5)), rounding)},
          {"D3", 6, solid(scaled(r, prism(3, 0.8, 0.2)), rounding)},
          {"C4v", 8, solid(scaled(r, pyramid), rounding)},
          {"Cs", 2, solid(scaled(r, wedge), rounding)},
          {"Ci", 2, solid(scaled(r, slanted), rounding)},
          {"C1", 1, solid(scaled(r, irregular), rounding)}};
}

// The order is that of what is left with the turns taken out.
inline std::vector<Symmetric> round_bodies() {
  const Ring rim{{0, 0, 0}, kUp, 0.03}, foot{{0, 0, 0.09}, kUp, 0.025};
  return {{"Dinfh", 4, coin()},
          {"Dinfh", 4, rod(0.1, 0.005, 0.02)},
          {"Cinfv", 2, solid({}, 1e-3, {rim, foot})},
          {"Kh", 2, ball(0.0135, 0.012)}};
}

}  // namespace ifa::sample
