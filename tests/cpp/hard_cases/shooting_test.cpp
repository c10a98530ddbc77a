// Hard case 23: angular shooting at its limits.
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "held.hpp"
#include "ifa/graph/connection.hpp"
#include "sample_bodies.hpp"
#include "torque_free.hpp"

namespace ifa {
namespace {

Body of_moments(const Vec3& moments) {
  Body::Definition d;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) d.vertices_m.push_back(0.01 * Vec3(x, y, z));
  d.mass_kg = 0.01;
  d.inertia_kg_m2 = 1e-6 * Mat3(moments.asDiagonal());
  return Body::make(d);
}

// Every error from 0 to pi, in every direction, at every duration: converged, and then an integration in long
// double ends there too, or it says why.
TEST(HardCase23, ShootingConvergesOrSaysWhy) {
  Held end("orientation at the end, rad", 1.0e-10), unsure("neither converged nor a fold, share", 0.02);
  const std::pair<const char*, Vec3> bodies[] = {
      {"card", {1.0, 2.5, 3.5}},
      {"thin card", {1.0, 1.0 + 1e-6, 2.0}},
      {"needle", {1e-4, 1.0, 1.0}},
      {"needle 1e-6", {1e-6, 1.0, 1.0}},
      {"needle 1e-8", {1e-8, 1.0, 1.0}},
      {"needle 1e-4, not round", {1e-4, 1.0, 1.0 + 3e-5}},
      {"needle 1e-8, not round", {1e-8, 1.0, 1.0 + 3e-9}},
      {"near sphere", {1.0, 1.0 + 1e-9, 1.0 + 2e-9}},
      {"sphere", {1.0, 1.0, 1.0}},
  };
  const double pi = std::numbers::pi;
  int all = 0, other = 0;
  for (const auto& [name, moments] : bodies) {
    const Body body = of_moments(moments);
    const Connector connector(body);
    RandomStream random(23, 0);
    for (const double duration_s : {1e-3, 0.02, 0.5})
      for (const double spin_rad_s : {0.0, 1e-9, 1.0, 20.0, 100.0, 1e7})
        for (const double error_rad : {0.0, 1e-15, 1e-9, 0.1, 1.0, pi - 1e-3, pi - 1e-9, pi}) {
          State from;
          from.orientation = random.rotation();
          // Also about principal axes, where two flights beside one another are alike.
          const int which = static_cast<int>(6.0 * random.uniform());
          const Vec3 axis = which < 3 ? Vec3(Vec3::Unit(which)) : random.unit_vector();
          from.angular_velocity = from.orientation * (spin_rad_s * axis);
          Vec3l w = (spin_rad_s * axis).cast<Real>();
          Quatl q = from.orientation.cast<Real>();
          const bool fast = spin_rad_s > 1e6;
          if (!fast) integrate_torque_free(body.principal_inertia().cast<Real>(), duration_s, q, w);
          State to;
          to.position = Vec3(0.01, 0.0, 0.0);
          to.orientation = q.cast<double>() * rotation_exp(error_rad * random.unit_vector());
          const Connection c = connector.connect(from, from, to, duration_s, sample::downwards());
          const std::string where = std::string(name) + " T " + std::to_string(duration_s) + " spin " +
                                    std::to_string(spin_rad_s) + " error " + std::to_string(error_rad);
          ASSERT_TRUE(is_finite(c.start)) << where;
          ASSERT_TRUE(std::isfinite(c.shooting.error_rad) && std::isfinite(c.shooting.fold_at)) << where;
          EXPECT_STRNE(why(c.shooting.outcome), "");
          if (fast) {  // refused, but for a sphere's, which is a closed form
            EXPECT_EQ(c.shooting.outcome, body.isotropic() ? Shot::converged : Shot::too_fast) << where;
            continue;
          }
          ++all;
          other += c.shooting.outcome != Shot::converged && c.shooting.outcome != Shot::fold;
          if (!c.converged()) continue;
          w = (from.orientation.conjugate() * c.start.angular_velocity).cast<Real>();
          q = from.orientation.cast<Real>();
          integrate_torque_free(body.principal_inertia().cast<Real>(), duration_s, q, w);
          end.see(static_cast<double>(angle_between(to_matrix(q.cast<double>()), to_matrix(to.orientation))),
                  where);
        }
  }
  unsure.see(static_cast<double>(other) / all);
}

}  // namespace
}  // namespace ifa
