#include "ifa/rigid/body.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "ifa/base/error.hpp"
#include "ifa/base/random.hpp"
#include "ifa/rigid/hull.hpp"

namespace ifa {
namespace {

Body::Definition brick() {
  Body::Definition d;
  for (int i = 0; i < 8; ++i)
    d.vertices_m.push_back({i & 1 ? 0.01 : -0.01, i & 2 ? 0.02 : -0.02, i & 4 ? 0.03 : -0.03});
  d.mass_kg = 0.06;
  const MassProperties m = rounded_hull_mass_properties(d.vertices_m, 0.0, 1250.0);
  d.inertia_kg_m2 = m.inertia_kg_m2;
  return d;
}

TEST(Body, EachInvalidFieldIsNamed) {
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  using Change = std::function<void(Body::Definition&)>;
  const auto moments = [](double x, double y, double z) {
    return [=](Body::Definition& d) { d.inertia_kg_m2 = Vec3(x, y, z).asDiagonal(); };
  };
  const std::vector<std::pair<std::string, Change>> cases{
      {"vertices_m", [](auto& d) { d.vertices_m.clear(); }},
      {"vertices_m", [&](auto& d) { d.vertices_m[3].y() = nan; }},
      {"vertices_m",
       [](auto& d) {
         for (Vec3& v : d.vertices_m) v.z() = 0.0;
       }},
      {"radius_m", [](auto& d) { d.radius_m = -1e-9; }},
      {"radius_m", [&](auto& d) { d.radius_m = infinite; }},
      {"mass_kg", [](auto& d) { d.mass_kg = 0.0; }},
      {"mass_kg", [&](auto& d) { d.mass_kg = nan; }},
      {"centre_of_mass_m", [&](auto& d) { d.centre_of_mass_m.x() = nan; }},
      {"inertia_kg_m2", [&](auto& d) { d.inertia_kg_m2(0, 1) = nan; }},
      {"inertia_kg_m2", [](auto& d) { d.inertia_kg_m2(0, 1) = 1e-6 * d.inertia_kg_m2(0, 0); }},
      {"inertia_kg_m2", moments(0, 0, 0)},
      {"inertia_kg_m2", moments(0, 1, 1)},
      {"inertia_kg_m2", moments(1e-24, 1, 1)},
      {"inertia_kg_m2", moments(-1, 1, 1)},
      {"inertia_kg_m2", moments(1, 1, 2.001)},
      {"restitution", [](auto& d) { d.material.restitution = 1.001; }},
      {"restitution", [&](auto& d) { d.material.restitution = nan; }},
      {"friction", [](auto& d) { d.material.friction = -0.1; }},
      {"rolling_friction_m", [&](auto& d) { d.material.rolling_friction_m = nan; }},
      {"spin_friction_m", [](auto& d) { d.material.spin_friction_m = -1.0; }},
  };
  EXPECT_NO_THROW(Body::make(brick()));
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Body::Definition d = brick();
    cases[i].second(d);
    try {
      Body::make(d);
      ADD_FAILURE() << "case " << i << " (" << cases[i].first << ") was accepted";
    } catch (const ArgumentError& e) {
      EXPECT_EQ(std::string(e.what()).rfind(cases[i].first + ":", 0), 0u) << "case " << i << ": " << e.what();
    }
  }
}

TEST(Body, AcceptsTheLimits) {
  for (const Vec3& moments :
       {Vec3(1, 1, 2), Vec3(1, 2, 3), Vec3(1e-12, 1, 1), Vec3(1, 1, 2.0 * (1 + 1e-12))}) {
    Body::Definition d = brick();
    d.inertia_kg_m2 = moments.asDiagonal();
    EXPECT_EQ(Body::make(d).principal_inertia(), moments);
  }
  Body::Definition d = brick();
  d.inertia_kg_m2(0, 1) += 1e-11 * d.inertia_kg_m2(0, 0);  // printed to few digits
  const Mat3 inertia = Body::make(d).inertia_kg_m2();
  EXPECT_EQ(inertia, inertia.transpose());
}

TEST(Body, DiagonalInertiaKeepsTheAxesAndTheirOrder) {
  const Body body = Body::make(brick());
  // m / 12 (b^2 + c^2) of the 2 x 4 x 6 cm brick
  const Vec3 expected = 0.06 / 12.0 * Vec3(16e-4 + 36e-4, 4e-4 + 36e-4, 4e-4 + 16e-4);
  EXPECT_LT((body.principal_inertia() - expected).norm(), 1e-14 * expected.norm());
  EXPECT_EQ(body.body_from_principal().coeffs(), Quat::Identity().coeffs());
  EXPECT_EQ(body.principal_vertices(), body.vertices());
  EXPECT_FALSE(body.isotropic());
  EXPECT_NEAR(body.bounding_radius_m(), std::sqrt(14e-4), 1e-16);
}

TEST(Body, RotatedBodyHasTheSamePrincipalBody) {
  RandomStream random(5, 0);
  const Vec3 moments(2.6e-5, 2e-5, 1e-5);
  for (int i = 0; i < 100; ++i) {
    const Mat3 turn = random.rotation().toRotationMatrix();
    Body::Definition d = brick();
    for (Vec3& v : d.vertices_m) v = turn * v;
    d.inertia_kg_m2 = turn * moments.asDiagonal() * turn.transpose();
    const Body body = Body::make(d);
    EXPECT_LT((body.principal_inertia() - moments.reverse()).norm(), 1e-14 * moments.norm());
    const Mat3 axes = body.body_from_principal().toRotationMatrix();
    EXPECT_NEAR(axes.determinant(), 1.0, 1e-14);
    const Mat3 rebuilt = axes * body.principal_inertia().asDiagonal() * axes.transpose();
    EXPECT_LT((rebuilt - body.inertia_kg_m2()).norm(), 1e-14 * moments.norm());
    for (std::size_t k = 0; k < body.vertices().size(); ++k) {
      EXPECT_LT((axes * body.principal_vertices()[k] - body.vertices()[k]).norm(), 1e-16);
      // the brick again, its shortest moment now first
      EXPECT_LT((body.principal_vertices()[k].cwiseAbs() - Vec3(0.03, 0.02, 0.01)).norm(), 1e-15);
    }
  }
}

TEST(Body, CentreOfMassIsTheOrigin) {
  Body::Definition d = brick();
  const Vec3 shift(1.0, -2.0, 3.0);
  for (Vec3& v : d.vertices_m) v += shift;
  d.centre_of_mass_m = shift;
  const Body shifted = Body::make(d), body = Body::make(brick());
  for (std::size_t k = 0; k < 8; ++k)
    EXPECT_LT((shifted.vertices()[k] - body.vertices()[k]).norm(), 1e-15);  // rounding at 3 m
}

TEST(Body, BallCapsuleAndPlateNeedARadius) {
  const std::vector<std::vector<Vec3>> flat{{{0, 0, 0}},
                                            {{0, 0, -1}, {0, 0, 1}, {0, 0, 0.5}},
                                            {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}, {0, 0, 0}}};
  const std::size_t kept[] = {1, 2, 4};
  for (int i = 0; i < 3; ++i) {
    Body::Definition d = brick();
    d.vertices_m = flat[i];
    EXPECT_THROW(Body::make(d), ArgumentError);
    d.radius_m = 1e-6;
    EXPECT_EQ(Body::make(d).vertices().size(), kept[i]);
  }
}

// The five regular solids: one edge length, isotropic, no principal axes to choose.
TEST(Body, RegularSolidsAreIsotropic) {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  const auto cyclic = [](double x, double y, double z, std::vector<Vec3>& out) {
    for (int signs = 0; signs < 8; ++signs) {
      const Vec3 p(signs & 1 ? -x : x, signs & 2 ? -y : y, signs & 4 ? -z : z);
      for (int k = 0; k < 3; ++k) out.emplace_back(p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
    }
  };
  std::vector<std::vector<Vec3>> solids(5);
  solids[0] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  cyclic(1, 1, 1, solids[1]);
  cyclic(1, 0, 0, solids[2]);
  cyclic(0, 1 / g, g, solids[3]);
  cyclic(1, 1, 1, solids[3]);
  cyclic(0, 1, g, solids[4]);
  const std::size_t corners[] = {4, 8, 6, 20, 12};
  for (int i = 0; i < 5; ++i) {
    Body::Definition d;
    d.vertices_m = solids[i];
    d.radius_m = 0.1;
    const MassProperties m = rounded_hull_mass_properties(d.vertices_m, d.radius_m, 1.0);
    d.mass_kg = m.mass_kg;
    d.inertia_kg_m2 = m.inertia_kg_m2;
    const Body body = Body::make(d);
    EXPECT_EQ(body.vertices().size(), corners[i]);
    EXPECT_TRUE(body.isotropic());
    EXPECT_EQ(body.body_from_principal().coeffs(), Quat::Identity().coeffs());
    EXPECT_NEAR(body.bounding_radius_m(), body.vertices()[0].norm() + 0.1, 1e-14);
  }
}

TEST(Body, ScalingByPowersOfTwoKeepsTheBits) {
  RandomStream random(9, 0);
  Body::Definition d, scaled;
  for (int i = 0; i < 50; ++i) d.vertices_m.push_back(random.unit_vector());
  d.mass_kg = 1.0;
  d.inertia_kg_m2 << 1.0, 0.1, 0.2, 0.1, 1.1, 0.3, 0.2, 0.3, 0.9;
  scaled = d;
  const double length = std::pow(4.0, 5), mass = 32.0;
  for (Vec3& v : scaled.vertices_m) v *= length;
  scaled.mass_kg *= mass;
  scaled.inertia_kg_m2 *= mass * length * length;
  const Body a = Body::make(d), b = Body::make(scaled);
  EXPECT_EQ(b.body_from_principal().coeffs(), a.body_from_principal().coeffs());
  EXPECT_EQ(b.principal_inertia(), a.principal_inertia() * (mass * length * length));
  ASSERT_EQ(b.principal_vertices().size(), a.principal_vertices().size());
  for (std::size_t k = 0; k < a.principal_vertices().size(); ++k)
    EXPECT_EQ(b.principal_vertices()[k], a.principal_vertices()[k] * length);
}

}  // namespace
}  // namespace ifa
