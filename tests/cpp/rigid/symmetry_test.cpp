#include "ifa/rigid/symmetry.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "symmetric_bodies.hpp"

namespace ifa {
namespace {

using sample::Symmetric;

std::vector<Symmetric> all_bodies() {
  std::vector<Symmetric> all = sample::finite_bodies();
  for (Symmetric& body : sample::round_bodies()) all.push_back(body);
  return all;
}

// The largest entry by which the product of two elements or an inverse is none of them.
double off_a_group(const std::vector<SymmetryElement>& elements) {
  double worst = 0.0;
  const auto nearest = [&](const Mat3& m) {
    double least = 1e300;
    for (const SymmetryElement& g : elements) least = std::min(least, (g.map - m).cwiseAbs().maxCoeff());
    return least;
  };
  for (const SymmetryElement& g : elements) {
    worst = std::max(worst, nearest(g.map.transpose()));
    for (const SymmetryElement& h : elements) worst = std::max(worst, nearest(g.map * h.map));
  }
  return worst;
}

// The farthest that the image of a vertex is from all vertices, in bounding radii; each against each.
double off_the_vertices(const Body& body, const Mat3& g) {
  double worst = 0.0;
  for (const Vec3& p : body.principal_vertices()) {
    double least = 1e300;
    for (const Vec3& q : body.principal_vertices()) least = std::min(least, (g * p - q).norm());
    worst = std::max(worst, least);
  }
  return worst / body.bounding_radius_m();
}

Body changed(const Body& body, const std::vector<Vec3>& vertices) {
  Body::Definition d = body.definition();
  d.vertices_m = vertices;
  return Body::make(d);
}

// The same body, turned, moved, and with noise of its size times `noise` on vertices and inertia.
Body in_other_axes(const Body& body, RandomStream& random, double noise) {
  Body::Definition d = body.definition();
  const Mat3 turn = random.rotation().toRotationMatrix();
  const double size = body.bounding_radius_m();
  const Vec3 shift = 3.0 * size * random.unit_vector();
  for (Vec3& v : d.vertices_m) v = turn * v + shift + noise * size * random.unit_vector();
  for (Ring& ring : d.rings_m) {
    ring.centre_m = turn * ring.centre_m + shift + noise * size * random.unit_vector();
    ring.axis = turn * ring.axis + noise * random.unit_vector();
  }
  d.centre_of_mass_m = turn * d.centre_of_mass_m + shift;
  Mat3 error;
  for (int i = 0; i < 9; ++i) error(i / 3, i % 3) = random.uniform(-1.0, 1.0);
  d.inertia_kg_m2 = turn * d.inertia_kg_m2 * turn.transpose() +
                    0.5 * noise * d.inertia_kg_m2.norm() * (error + error.transpose());
  return Body::make(d);
}

TEST(Symmetry, IsTheGroupOfTheTextbook) {
  for (const Symmetric& s : all_bodies()) {
    const Symmetry symmetry = Symmetry::of(s.body);
    EXPECT_EQ(symmetry.name(), s.name);
    EXPECT_EQ(symmetry.elements().size(), s.order) << s.name;
    EXPECT_TRUE(symmetry.elements()[0].map.isIdentity(0.0)) << s.name;
    // rounding of corners, and of the axes of a frame made from two of them
    EXPECT_LT(off_a_group(symmetry.elements()), 1e-12) << s.name;
    for (const SymmetryElement& g : symmetry.elements()) {
      EXPECT_LT((g.map * g.map.transpose() - Mat3::Identity()).norm(), 1e-14) << s.name;
      EXPECT_NEAR(g.map.determinant(), g.proper ? 1.0 : -1.0, 1e-14) << s.name;
      EXPECT_LT(off_the_vertices(s.body, g.map), 1e-12) << s.name;
    }
  }
}

TEST(Symmetry, IsFoundInAnyAxesAndUnderNoise) {
  RandomStream random(811, 0);
  for (const double noise : {0.0, 1e-12, 1e-9})
    for (const Symmetric& s : all_bodies())
      for (int i = 0; i < 10; ++i) {
        const Symmetry symmetry = Symmetry::of(in_other_axes(s.body, random, noise));
        EXPECT_EQ(symmetry.name(), s.name) << noise;
        EXPECT_EQ(symmetry.elements().size(), s.order) << s.name << noise;
        // corners are off by the noise, maps by what frames make of it: the card's second corner counts
        // a third of its size, and a product of two is off by twice that
        EXPECT_LT(off_a_group(symmetry.elements()), 1e-11 + 30.0 * noise) << s.name;
      }
}

// Around the tolerance, where some maps fit and others do not, the answer is still a group.
TEST(Symmetry, IsAGroupWhateverTheNoise) {
  RandomStream random(812, 0);
  int partly = 0;
  for (const Symmetric& s : sample::finite_bodies())
    for (int i = 0; i < 40; ++i) {
      const Body body = in_other_axes(s.body, random, std::pow(10.0, random.uniform(-7.0, -5.0)));
      const Symmetry symmetry = Symmetry::of(body);
      EXPECT_LT(off_a_group(symmetry.elements()), 1e-4) << s.name;    // maps fit to 1e-6; as above
      EXPECT_EQ(s.order % symmetry.elements().size(), 0U) << s.name;  // Lagrange: a subgroup
      partly += symmetry.elements().size() < s.order;
    }
  EXPECT_GT(partly, 100) << "too little noise to test it";
}

TEST(Symmetry, KnowsWhatIsOnlyNearlySymmetric) {
  for (const double off : {1e-3, 1e-5}) {
    const double a = 0.01, b = a * (1.0 + off);
    EXPECT_EQ(Symmetry::of(sample::solid(sample::signed_points({a, a, b}, false), 1e-3)).name(), "D4h");
    EXPECT_EQ(Symmetry::of(sample::solid(sample::signed_points({a, b, b * (1.0 + off)}, false), 1e-3)).name(),
              "D2h");
    std::vector<Vec3> corners = sample::signed_points({a, a, a}, false);
    corners[0] *= 1.0 + off;  // one corner pulled out
    EXPECT_EQ(Symmetry::of(sample::solid(corners, 1e-3)).name(), "C3v");
    // the hull of a cube with mass that is not spread as in a cube
    Body::Definition d = sample::box({a, a, a}, 0.01).definition();
    d.inertia_kg_m2(2, 2) *= 1.0 + off;
    EXPECT_EQ(Symmetry::of(Body::make(d)).name(), "D4h");
    d.centre_of_mass_m = {0, 0, off * a};
    EXPECT_EQ(Symmetry::of(Body::make(d)).name(), "C4v");
  }
}

// Where the hull could turn freely, the inertia decides.
TEST(Symmetry, OfRoundHullsIsThatOfTheInertia) {
  Body::Definition ball = sample::ball(0.02, 0.03).definition();
  const auto with_inertia = [](Body::Definition d, const Vec3& moments, const Mat3& axes) {
    d.inertia_kg_m2 = 1e-6 * axes * moments.asDiagonal() * axes.transpose();
    return Symmetry::of(Body::make(d));
  };
  const Mat3 oblique = rotation_exp({0.3, -0.5, 0.7}).toRotationMatrix(), straight = Mat3::Identity();
  EXPECT_EQ(with_inertia(ball, {1, 1, 1}, oblique).name(), "Kh");
  EXPECT_EQ(with_inertia(ball, {1, 1, 1.5}, oblique).name(), "Dinfh");
  EXPECT_EQ(with_inertia(ball, {1, 1.2, 1.5}, oblique).name(), "D2h");
  ball.centre_of_mass_m = {0, 0, 0.005};
  EXPECT_EQ(with_inertia(ball, {1, 1, 1.5}, straight).name(), "Cinfv");
  EXPECT_EQ(with_inertia(ball, {1, 1.2, 1.5}, straight).name(), "C2v");
  EXPECT_EQ(with_inertia(ball, {1, 1.2, 1.5}, oblique).name(), "C1");
  const Body::Definition coin = sample::coin().definition();
  EXPECT_EQ(with_inertia(coin, {1, 1.2, 1.5}, straight).name(), "D2h");
  EXPECT_EQ(with_inertia(coin, {1, 1, 1.5}, oblique).name(), "C2h");  // both axes span its mirror
  EXPECT_EQ(with_inertia(coin, {1, 1.2, 1.5}, oblique).name(), "Ci");
  Body::Definition rings = coin;  // two circles at right angles
  rings.rings_m[0] = {Vec3::Zero(), Vec3::UnitX(), 0.01};
  rings.rings_m[1] = {Vec3::Zero(), Vec3::UnitY(), 0.01};
  EXPECT_EQ(with_inertia(rings, {1, 1, 1.5}, straight).name(), "D4h");
  rings.rings_m[1].radius_m = 0.011;
  EXPECT_EQ(with_inertia(rings, {1, 1, 1.5}, straight).name(), "D2h");
}

// A mesh's faces are full of vertices, of which noise puts some on the hull and others not.
TEST(Symmetry, DoesNotMindNoiseOnFaces) {
  RandomStream random(813, 0);
  constexpr int kGrid = 12;
  std::vector<Vec3> points;
  for (int i = 0; i <= kGrid; ++i)
    for (int j = 0; j <= kGrid; ++j)
      for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-0.5, 0.5}) {
          Vec3 p;
          p[axis] = side;
          p[(axis + 1) % 3] = static_cast<double>(i) / kGrid - 0.5;
          p[(axis + 2) % 3] = static_cast<double>(j) / kGrid - 0.5;
          points.push_back(p);
        }
  const Mat3 turn = random.rotation().toRotationMatrix();
  for (Vec3& p : points) p = turn * p + 1e-9 * random.unit_vector();
  const Body body = changed(sample::box({1, 1, 1}, 1.0), points);
  EXPECT_GT(body.vertices().size(), 50U) << "no noise on the hull";
  EXPECT_EQ(Symmetry::of(body).name(), "Oh");
}

TEST(Symmetry, OfManySidesIsASubgroup) {
  for (const auto& [sides, twist, name] :
       {std::tuple(63, 0.0, "D63h"), std::tuple(100, 0.0, "D50h"), std::tuple(360, 0.0, "D60h"),
        std::tuple(66, 0.5, "D66"), std::tuple(100, 0.3, "D100"), std::tuple(257, 0.0, "C2v")}) {
    const Body body = sample::solid(sample::scaled(0.01, sample::prism(sides, 0.5, twist)), 0.0);
    const Symmetry symmetry = Symmetry::of(body);
    EXPECT_EQ(symmetry.name(), name) << sides;
    EXPECT_LE(symmetry.elements().size(), static_cast<std::size_t>(Symmetry::kMostElements));
    EXPECT_LT(off_a_group(symmetry.elements()), 1e-12) << sides;  // rounding
    for (const SymmetryElement& g : symmetry.elements()) EXPECT_LT(off_the_vertices(body, g.map), 1e-12);
  }
}

}  // namespace
}  // namespace ifa
