// Convex hulls (by Qhull) and mass properties of closed triangle meshes.
#pragma once

#include <array>
#include <vector>

#include "ifa/base/linear_algebra.hpp"

namespace ifa {

using Triangle = std::array<int, 3>;

struct Hull {
  std::vector<Vec3> vertices;  // extreme points only, in the order of the input
  std::vector<Triangle>
      triangles;      // outward orientation (counter-clockwise seen from outside); empty if flat
  bool flat = false;  // the points span no volume: a point, a line or a plane
};

// Throws ArgumentError on no points or a coordinate that is not finite. Never aborts.
// Points closer to each other than 1e-9 of the extent are merged, and a set thinner than that is flat.
Hull convex_hull(const std::vector<Vec3>& points);

// The least, over all directions, of how far the points reach from the origin: the radius of the largest ball
// about it that their hull holds, or minus its distance from the hull if it lies outside. Throws as above.
double least_reach_m(const std::vector<Vec3>& points);

// A circular edge: the circle of this radius about `centre_m`, across the unit vector `axis`.
struct Ring {
  Vec3 centre_m = Vec3::Zero(), axis = kUp;
  double radius_m = 0.0;
};

inline constexpr int kMostRings = 8;  // of a body

// Makes the axes unit vectors. Throws ArgumentError naming the row: a number that is not finite, no radius,
// no axis; or more than kMostRings.
void check_rings(std::vector<Ring>& rings);

// How far a ring reaches along a unit vector.
inline double reach_m(const Ring& ring, const Vec3& along) {
  return along.dot(ring.centre_m) + ring.radius_m * (along - along.dot(ring.axis) * ring.axis).norm();
}

// So many points of each ring, evenly spread, one ring after the other.
std::vector<Vec3> ring_points(const std::vector<Ring>& rings, int points_each);

struct MassProperties {
  double volume_m3 = 0.0;
  double mass_kg = 0.0;
  Vec3 centre_of_mass_m = Vec3::Zero();
  Mat3 inertia_kg_m2 = Mat3::Zero();  // about the centre of mass
};

// Of the solid inside a closed, outward-oriented triangle mesh of uniform density, by the divergence
// theorem (Eberly 2002, "Polyhedral mass properties"). A mesh turned inside out gives a negative volume.
MassProperties mass_properties(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                               double density_kg_m3);

// Of the hull of `vertices` and `rings` rounded by `radius_m`. Without rings in closed form for every shape:
// a ball (one vertex), a capsule (two), a flat set, a solid. No volume (flat and radius 0) gives zeros. With
// rings extrapolated from polygons of 512 and 1024 corners: a cylinder or a cone is good to 1e-9, any other
// shape to 1e-6.
MassProperties rounded_hull_mass_properties(const std::vector<Vec3>& vertices, double radius_m,
                                            double density_kg_m3, const std::vector<Ring>& rings = {});

}  // namespace ifa
