#include "ifa/signature/constraints.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "ifa/base/error.hpp"
#include "ifa/base/random.hpp"
#include "ifa/signature/marks.hpp"

namespace ifa {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Marks marks_with(Constraints constraints, Ending ending = Ending::rest) {
  Marks marks;
  marks.times_s = {0.1, 0.2, 0.4};
  marks.durations_s.assign(3, 0.0);
  marks.centroids_s.assign(3, kNan);
  marks.ending = ending;
  marks.constraints = std::move(constraints);
  return marks;
}

std::string complaint(const Marks& marks) {
  try {
    validate(marks);
  } catch (const ArgumentError& error) {
    return error.what();
  }
  return "";
}

// The paper's halfwidths: 4 degrees and 1 cm, which it rounds.
TEST(Constraints, FactorsHalveWhereThePaperSays) {
  EXPECT_EQ(orientation_constraint_factor(0.0), 1.0);
  EXPECT_NEAR(orientation_constraint_factor(4.0 * std::numbers::pi / 180.0), 0.5, 0.01);
  EXPECT_EQ(position_constraint_factor(0.0), 1.0);
  EXPECT_NEAR(position_constraint_factor(0.01), 0.5, 0.01);
  for (const double x : {0.003, 0.02, 0.3}) {
    EXPECT_NEAR(std::log(orientation_constraint_factor(x)), -140.0 * x * x, 1e-12);  // rounding
    EXPECT_NEAR(std::log(position_constraint_factor(x)), -7000.0 * x * x, 1e-9);
  }
}

TEST(Constraints, AnglesAreExactNearZeroAndAHalfTurn) {
  RandomStream random(1, 0);
  for (const double angle : {0.0, 1e-9, 1e-3, 1.0, 3.0, std::numbers::pi - 1e-9}) {
    const Vec3 a = random.unit_vector(), axis = a.cross(random.unit_vector()).normalized();
    const Vec3 b = rotation_exp(angle * axis) * a;
    for (const double length : {1e-200, 1.0, 1e200})
      EXPECT_NEAR(angle_between_rad(length * a, 3.0 * b), angle, 1e-14);  // rounding of unit vectors
  }
}

TEST(Constraints, WhatCannotBeAskedIsRefused) {
  const Vec3 x = Vec3::UnitX();
  EXPECT_EQ(complaint(marks_with({{{0, {0, 0}}, {2, {1, 1}}}, {{1, x, kUp}, {1, kUp, x}, {kAtRest, x, x}}})),
            "");
  EXPECT_EQ(complaint(marks_with({{{3, {0, 0}}}, {}})), "constraints: there is no mark 4, only 3");
  EXPECT_EQ(complaint(marks_with({{}, {{7, x, x}}})), "constraints: there is no mark 8, only 3");
  EXPECT_EQ(complaint(marks_with({{{1, {0, kNan}}}, {}})), "mark 2 (0.20 s): its position is not finite");
  EXPECT_EQ(complaint(marks_with({{{1, {0, -1e7}}}, {}})),
            "mark 2 (0.20 s): its position is farther than 1000 km from the origin");
  EXPECT_EQ(complaint(marks_with({{{1, {0, 0}}, {1, {1, 0}}}, {}})), "mark 2 (0.20 s): has two positions");
  EXPECT_EQ(complaint(marks_with({{}, {{0, Vec3::Zero(), x}}})),
            "mark 1 (0.10 s): the body_direction of its orientation is 0 and points nowhere");
  EXPECT_EQ(complaint(marks_with({{}, {{kAtRest, x, {0, 0, kNan}}}})),
            "rest: the direction of its orientation is not finite");
  EXPECT_EQ(complaint(marks_with({{}, {{kAtRest, x, x}}}, Ending::open)),
            "constraints: an orientation at rest needs marks with the ending \"rest\"");
}

TEST(Constraints, AForgottenMarkTakesItsConstraintsAlong) {
  Constraints c{{{0, {0, 0}}, {1, {1, 1}}, {2, {2, 2}}}, {{1, kUp, kUp}, {2, kUp, kUp}, {kAtRest, kUp, kUp}}};
  c.forget_mark(1);
  ASSERT_EQ(c.positions.size(), 2u);
  EXPECT_EQ(c.positions[1].mark, 1u);
  EXPECT_EQ(c.positions[1].position_m, Vec2(2, 2));
  ASSERT_EQ(c.orientations.size(), 2u);
  EXPECT_EQ(c.orientations[0].mark, 1u);
  EXPECT_EQ(c.orientations[1].mark, kAtRest);
  c.forget_rest();
  EXPECT_EQ(c.orientations.size(), 1u);
}

}  // namespace
}  // namespace ifa
