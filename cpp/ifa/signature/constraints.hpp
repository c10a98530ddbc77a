// What is asked of a motion's poses beside its marks (paper section 6): which side of the body points where,
// and where on the ground it is.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "ifa/base/linear_algebra.hpp"

namespace ifa {

struct Marks;

inline constexpr std::size_t kAtRest = std::numeric_limits<std::size_t>::max();  // in place of a mark's index

// Where the centre of mass, seen from above, shall be when mark `mark`'s event begins.
struct PositionConstraint {
  std::size_t mark;
  Vec2 position_m;
};

// What `body_direction` shall point along when mark `mark`'s event begins, or at rest.
struct OrientationConstraint {
  std::size_t mark;
  Vec3 body_direction;  // body axes, of any length
  Vec3 direction;       // world axes, of any length
};

struct Constraints {
  std::vector<PositionConstraint> positions;  // one for a mark at most
  std::vector<OrientationConstraint> orientations;

  bool empty() const { return positions.empty() && orientations.empty(); }

  // As if mark k had never been, or nothing were asked at rest.
  void forget_mark(std::size_t k);
  void forget_rest();
};

inline constexpr double kOrientationWeight = 140.0;  // c_o, 1/rad^2: f_o halves at 4 degrees
inline constexpr double kPositionWeight = 7000.0;    // c_p, 1/m^2: f_p halves at 1 cm
inline constexpr double kMetFactor = 0.5;            // a constraint whose factor is at least this is met

double orientation_constraint_factor(double angle_rad);  // f_o
double position_constraint_factor(double distance_m);    // f_p

// Of directions of any length, rad; good for small angles and for those near a half turn.
double angle_between_rad(const Vec3& a, const Vec3& b);

// Throws ArgumentError naming the mark unless every mark exists, numbers are finite (positions within
// 1000 km), directions are not 0, no mark has two positions, and what is asked at rest is asked of a motion
// that comes to rest.
void validate_constraints(const Marks& marks);

}  // namespace ifa
