#include "ifa/rigid/hull.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "ifa/base/error.hpp"
#include "ifa/base/random.hpp"

namespace ifa {
namespace {

constexpr double kPi = std::numbers::pi;

std::vector<Vec3> box(const Vec3& size, const Vec3& centre = Vec3::Zero()) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back(centre + 0.5 * size.cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  return corners;
}

Vec3 box_inertia(const Vec3& s, double mass) {
  const Vec3 q = s.cwiseAbs2();
  return mass / 12.0 * Vec3(q.y() + q.z(), q.z() + q.x(), q.x() + q.y());
}

double support(const std::vector<Vec3>& points, const Vec3& direction) {
  double best = -std::numeric_limits<double>::infinity();
  for (const Vec3& p : points) best = std::max(best, p.dot(direction));
  return best;
}

// Integral of (e . x)^2 over the body, about the origin: it grows with the body.
double second_moment(const MassProperties& m, const Vec3& e) {
  const Mat3 spread = 0.5 * m.inertia_kg_m2.trace() * Mat3::Identity() - m.inertia_kg_m2;
  return e.dot(spread * e) + m.mass_kg * std::pow(e.dot(m.centre_of_mass_m), 2);
}

double relative(const Mat3& a, const Mat3& b) {
  return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

TEST(ConvexHull, RefusesNoPointsAndNonFinite) {
  EXPECT_THROW(convex_hull({}), ArgumentError);
  EXPECT_THROW(convex_hull({{0, 0, 0}, {0, std::nan(""), 0}}), ArgumentError);
  EXPECT_THROW(convex_hull({{0, 0, 0}, {std::numeric_limits<double>::infinity(), 0, 0}}), ArgumentError);
  EXPECT_THROW(convex_hull({{-1e300, 0, 0}, {1e300, 1, 0}, {0, 0, 1}, {1, 1, 1}}), ArgumentError);
}

TEST(ConvexHull, FlatSetsKeepTheirExtremes) {
  const Vec3 p(1, 2, 3), q(2, 2, 5);
  EXPECT_EQ(convex_hull({p, p, p}).vertices, std::vector<Vec3>{p});
  const Hull line = convex_hull({p, 0.5 * (p + q), q, 0.3 * p + 0.7 * q});
  EXPECT_TRUE(line.flat);
  EXPECT_EQ(line.vertices, (std::vector<Vec3>{p, q}));
  std::vector<Vec3> square;  // tilted, with points inside and along its sides
  for (int i = 0; i < 25; ++i) square.push_back(p + i % 5 * Vec3(1, 1, 0) + i / 5 * Vec3(0, 1, -2));
  const Hull plane = convex_hull(square);
  EXPECT_TRUE(plane.flat);
  EXPECT_TRUE(plane.triangles.empty());
  EXPECT_EQ(plane.vertices, (std::vector<Vec3>{square[0], square[4], square[20], square[24]}));
}

TEST(ConvexHull, GridOfACubeKeepsEightCorners) {
  std::vector<Vec3> grid;
  for (int i = 0; i < 125; ++i) grid.push_back(0.1 * Vec3(i % 5, i / 5 % 5, i / 25));
  const Hull hull = convex_hull(grid);
  EXPECT_EQ(hull.vertices.size(), 8u);
  EXPECT_EQ(hull.triangles.size(), 12u);
  EXPECT_FALSE(hull.flat);
}

TEST(ConvexHull, MergesNearDuplicates) {
  std::vector<Vec3> points = box(Vec3(1, 1, 1));
  for (int i = 0; i < 8; ++i) points.push_back(points[i] + 1e-11 * Vec3(1, -1, 1));
  const Hull hull = convex_hull(points);
  EXPECT_EQ(hull.vertices, box(Vec3(1, 1, 1)));
}

TEST(ConvexHull, ThinPlatesAndNeedlesHaveVolume) {
  for (const Vec3& size : {Vec3(0.0856, 0.054, 1e-5), Vec3(1.0, 1e-5, 1e-5), Vec3(1.0, 1.0, 1e-7)}) {
    const Hull hull = convex_hull(box(size));
    EXPECT_FALSE(hull.flat);
    EXPECT_EQ(hull.vertices.size(), 8u);
    // rounding of coordinates of 1 m against a thickness of 1e-7 m leaves about 1e-9
    EXPECT_NEAR(mass_properties(hull.vertices, hull.triangles, 1.0).volume_m3 / size.prod(), 1.0, 1e-8);
  }
}

// Brute force: support in random directions, every point behind every facet, a closed surface.
TEST(ConvexHull, AgreesWithBruteForce) {
  for (int shape = 0; shape < 4; ++shape) {
    RandomStream random(7, shape);
    std::vector<Vec3> points;
    for (int i = 0; i < 1000; ++i) {
      const Vec3 u = random.unit_vector();
      const Vec3 inside(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      const Vec3 grid = (3.0 * inside).array().round();  // many coplanar and repeated points
      const Vec3 flat = Vec3(u.x(), u.y(), 1e-4 * u.z());
      points.push_back(Vec3(30, -2, 5) + (shape == 0 ? u : shape == 1 ? inside : shape == 2 ? grid : flat));
    }
    const Hull hull = convex_hull(points);
    ASSERT_FALSE(hull.flat);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 d = random.unit_vector();
      // the hull may lose what merging loses: 1e-9 of the extent
      EXPECT_NEAR(support(hull.vertices, d), support(points, d), 1e-8);
    }
    std::map<std::pair<int, int>, int> edges;
    for (const Triangle& t : hull.triangles) {
      const Vec3 &a = hull.vertices[t[0]], &b = hull.vertices[t[1]], &c = hull.vertices[t[2]];
      const Vec3 normal = (b - a).cross(c - a);
      if (normal.norm() > 1e-6) {  // the plane of a sliver is not defined to more than its rounding
        for (const Vec3& p : points) EXPECT_LT(normal.normalized().dot(p - a), 1e-8);
      }
      for (int i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
    }
    for (const auto& [edge, count] : edges) {
      EXPECT_EQ(count, 1);
      EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
    }
    EXPECT_EQ(hull.triangles.size(), 2 * hull.vertices.size() - 4);  // Euler
  }
}

// Exact for boxes: the nearest face where the origin is inside, else the distance, which is that of the
// clamped coordinates.
TEST(LeastReach, OfABoxWhereverTheOriginIs) {
  RandomStream random(12, 0);
  int inside = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 half(random.uniform(0.1, 2.0), random.uniform(0.1, 2.0), random.uniform(0.1, 2.0));
    const Vec3 centre(random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0));
    const Vec3 beyond = centre.cwiseAbs() - half;  // per axis, how far the origin is outside
    const bool is_inside = beyond.maxCoeff() < 0.0;
    inside += is_inside;
    const double wanted = is_inside ? -beyond.maxCoeff() : -beyond.cwiseMax(0.0).norm();
    EXPECT_NEAR(least_reach_m(box(2.0 * half, centre)), wanted, 1e-13) << i;  // some roundings of 4
  }
  EXPECT_GT(inside, 20);
}

// No direction reaches less, and some direction comes near.
TEST(LeastReach, AgreesWithBruteForceOverDirections) {
  RandomStream random(13, 0);
  for (int shape = 0; shape < 20; ++shape) {
    const Vec3 shift = random.uniform(0.0, 1.5) * random.unit_vector();
    std::vector<Vec3> points;
    for (int i = 0; i < 12; ++i) points.push_back(shift + random.uniform(0.5, 1.0) * random.unit_vector());
    const double least = least_reach_m(points);
    double best = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 20000; ++i) best = std::min(best, support(points, random.unit_vector()));
    EXPECT_GE(best, least - 1e-14) << shape;
    // The nearest of 20,000 directions is 0.014 rad away on average, 0.05 almost always; no point is farther
    // than 2.5.
    EXPECT_LT(best, least + 0.05 * 2.5) << shape;
  }
}

TEST(LeastReach, OfFlatSets) {
  const Vec3 p(0.3, -0.4, 1.2), q(-0.6, 0.8, -2.4);  // on one line through the origin
  EXPECT_NEAR(least_reach_m({p}), -1.3, 1e-15);
  EXPECT_NEAR(least_reach_m({p, q}), 0.0, 1e-15);
  EXPECT_NEAR(least_reach_m({{1, -1, 0}, {1, 1, 0}}), -1.0, 1e-15);
  EXPECT_NEAR(least_reach_m({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}), 0.0, 1e-15);
  EXPECT_NEAR(least_reach_m({{-1, -1, 2}, {1, -1, 2}, {1, 1, 2}, {-1, 1, 2}}), -2.0, 1e-15);
  EXPECT_NEAR(least_reach_m({Vec3::Zero()}), 0.0, 0.0);
}

TEST(ConvexHull, ScalingByAPowerOfFourKeepsTheBits) {
  RandomStream random(3, 0);
  std::vector<Vec3> points, larger;
  for (int i = 0; i < 200; ++i) points.push_back(random.unit_vector() + Vec3(5, 0, 0));
  for (const Vec3& p : points) larger.push_back(p * std::pow(4.0, 9));
  const Hull a = convex_hull(points), b = convex_hull(larger);
  EXPECT_EQ(a.triangles, b.triangles);
}

TEST(MassProperties, BoxAndItsParallelAxes) {
  const Vec3 size(1.0, 2.0, 3.0);
  for (const Vec3& centre : {Vec3(0, 0, 0), Vec3(1000, -2000, 500)}) {
    const Hull hull = convex_hull(box(size, centre));
    const MassProperties m = mass_properties(hull.vertices, hull.triangles, 2.0);
    const double tolerance = 1e-15 * (10.0 + centre.norm());  // rounding of the coordinates
    EXPECT_NEAR(m.volume_m3, 6.0, 6.0 * tolerance);
    EXPECT_NEAR(m.mass_kg, 12.0, 12.0 * tolerance);
    EXPECT_LT((m.centre_of_mass_m - centre).norm(), 10.0 * tolerance);
    EXPECT_LT(relative(m.inertia_kg_m2, box_inertia(size, 12.0).asDiagonal()), 10.0 * tolerance);
  }
}

TEST(MassProperties, CornerTetrahedronAndInsideOut) {
  const double a = 1.0, b = 2.0, c = 4.0;
  const std::vector<Vec3> corners{{0, 0, 0}, {a, 0, 0}, {0, b, 0}, {0, 0, c}};
  std::vector<Triangle> faces{{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
  const MassProperties m = mass_properties(corners, faces, 6.0);
  const double mass = a * b * c;
  Mat3 expected;
  expected << 3 * (b * b + c * c), a * b, a * c, a * b, 3 * (a * a + c * c), b * c, a * c, b * c,
      3 * (a * a + b * b);
  EXPECT_NEAR(m.mass_kg, mass, 1e-14 * mass);
  EXPECT_LT((m.centre_of_mass_m - Vec3(a, b, c) / 4.0).norm(), 1e-14);
  EXPECT_LT(relative(m.inertia_kg_m2, mass / 80.0 * expected), 1e-14);
  for (Triangle& t : faces) std::swap(t[0], t[1]);
  EXPECT_NEAR(mass_properties(corners, faces, 6.0).mass_kg, -mass, 1e-14 * mass);
  EXPECT_THROW(mass_properties(corners, {{0, 1, 4}}, 1.0), ArgumentError);
}

TEST(RoundedHull, BallAndCapsule) {
  const double r = 0.3, length = 2.0, density = 5.0;
  const MassProperties ball = rounded_hull_mass_properties({{1, 2, 3}}, r, density);
  const double ball_mass = density * 4.0 / 3.0 * kPi * r * r * r;
  EXPECT_NEAR(ball.mass_kg, ball_mass, 1e-14 * ball_mass);
  EXPECT_EQ(ball.centre_of_mass_m, Vec3(1, 2, 3));
  EXPECT_LT(relative(ball.inertia_kg_m2, 0.4 * ball_mass * r * r * Mat3::Identity()), 1e-14);

  const MassProperties rod = rounded_hull_mass_properties({{0, 0, 0}, {0, length, 0}}, r, density);
  const double cylinder = density * kPi * r * r * length;
  const double along = cylinder * r * r / 2.0 + ball_mass * 0.4 * r * r;
  // each half ball: 83/320 of its m r^2 about its own centroid, 3/8 r beyond the cylinder's end
  const double offset = length / 2.0 + 0.375 * r;
  const double across = cylinder * (length * length / 12.0 + r * r / 4.0) +
                        ball_mass * (83.0 / 320.0 * r * r + offset * offset);
  EXPECT_NEAR(rod.mass_kg, cylinder + ball_mass, 1e-14 * rod.mass_kg);
  EXPECT_LT(relative(rod.inertia_kg_m2, Vec3(across, along, across).asDiagonal()), 1e-14);
  EXPECT_EQ(rounded_hull_mass_properties({{0, 0, 0}, {0, 1, 0}}, 0.0, 1.0).mass_kg, 0.0);
  EXPECT_THROW(rounded_hull_mass_properties({{0, 0, 0}}, -1.0, 1.0), ArgumentError);
}

// Steiner's formula for the volume of a convex body and its parallel bodies.
TEST(RoundedHull, VolumeOfBoxAndPlate) {
  const double r = 0.25, a = 1.0, b = 2.0;
  for (const double c : {3.0, 0.0}) {
    const double steiner = a * b * c + 2.0 * (a * b + b * c + c * a) * r + kPi * (a + b + c) * r * r +
                           4.0 / 3.0 * kPi * r * r * r;
    EXPECT_NEAR(rounded_hull_mass_properties(box(Vec3(a, b, c)), r, 1.0).volume_m3, steiner, 1e-14 * steiner);
  }
}

// With directions no farther than delta from any other, hull(v + r d) lies inside the rounded body, and the
// rounded body inside hull(v + r / cos(delta) d). Volume and second moments grow with the body: both
// bounds are exact and need no tolerance but rounding.
TEST(RoundedHull, MomentsLieBetweenPolyhedralBounds) {
  std::vector<Vec3> directions;
  const int n = 12;
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j)
      for (const double side : {-1.0, 1.0}) {
        const Vec3 on_face(double(i) / n, double(j) / n, side);
        for (int axis = 0; axis < 3; ++axis)
          directions.push_back(
              Vec3(on_face[axis], on_face[(axis + 1) % 3], on_face[(axis + 2) % 3]).normalized());
      }
  const double delta = std::atan(std::sqrt(0.5) / n);  // half a cell's diagonal, at the middle of a face
  RandomStream random(11, 0);
  for (int shape = 0; shape < 6; ++shape) {
    std::vector<Vec3> vertices;
    const int corners = shape < 2 ? 3 + shape : 4 + 3 * shape;
    for (int i = 0; i < corners; ++i) {
      Vec3 p = random.unit_vector() + Vec3(0.3, 0.1, -0.2);
      if (shape < 2) p.z() = 0.2;  // a triangle and a quadrilateral without thickness
      vertices.push_back(p);
    }
    const double r = 0.1 + 0.2 * shape;
    const auto inflated = [&](double radius) {
      std::vector<Vec3> points;
      for (const Vec3& v : vertices)
        for (const Vec3& d : directions) points.push_back(v + radius * d);
      const Hull hull = convex_hull(points);
      return mass_properties(hull.vertices, hull.triangles, 1.0);
    };
    const MassProperties inner = inflated(r), exact = rounded_hull_mass_properties(vertices, r, 1.0),
                         outer = inflated(r / std::cos(delta));
    EXPECT_LT(inner.volume_m3, exact.volume_m3);
    EXPECT_LT(exact.volume_m3, outer.volume_m3);
    for (int i = 0; i < 20; ++i) {
      const Vec3 e = random.unit_vector();
      EXPECT_LT(second_moment(inner, e), second_moment(exact, e));
      EXPECT_LT(second_moment(exact, e), second_moment(outer, e));
    }
  }
}

}  // namespace
}  // namespace ifa
