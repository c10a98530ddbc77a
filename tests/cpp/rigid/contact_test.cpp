#include "ifa/rigid/contact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

// The matrix that maps an impulse at `arm` to the change of the point's velocity.
Mat3 point_matrix(const ContactBody& body, const Vec3& arm) {
  Mat3 k;
  for (int i = 0; i < 3; ++i) {
    const Vec3 impulse = Mat3::Identity().col(i);
    k.col(i) = impulse / body.mass_kg + Vec3(body.inverse_inertia * arm.cross(impulse)).cross(arm);
  }
  return k;
}

struct Problem {
  ContactBody body;
  std::vector<ContactPoint> points;
  Vec3 velocity, spin;

  Vec3 speed_at(std::size_t i) const { return velocity + spin.cross(points[i].arm); }
};

// Any body and motion, `n` points below the centre of mass, targets a Newton restitution of `restitution`.
Problem random_problem(RandomStream& random, int n, double friction, double restitution) {
  Problem p;
  const double mass = std::pow(10.0, random.uniform(-2.0, 0.0));
  Vec3 axes(random.uniform(0.2, 1.0), random.uniform(0.2, 1.0), random.uniform(0.2, 1.0));
  const Vec3 moments =
      0.2 * mass * (Vec3::Constant(axes.squaredNorm()) - axes.cwiseAbs2());  // an ellipsoid's
  const Mat3 r = random.rotation().toRotationMatrix();
  p.body = {mass, r * moments.cwiseInverse().asDiagonal() * r.transpose(), friction};
  p.velocity = random.uniform(0.0, 3.0) * random.unit_vector() - Vec3(0, 0, random.uniform(0.0, 3.0));
  p.spin = random.uniform(0.0, 5.0) * random.unit_vector();
  const double height = random.uniform(0.2, 1.0);
  for (int i = 0; i < n; ++i) {
    ContactPoint point;
    point.arm = {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), -height};
    p.points.push_back(point);
  }
  for (std::size_t i = 0; i < p.points.size(); ++i)
    p.points[i].target_speed = std::max(0.0, -restitution * p.speed_at(i).z());
  return p;
}

// Coulomb's law and the targets, each point by its definition. `slack` is in m/s.
void expect_lawful(const Problem& p, double slack, const std::string& what) {
  for (std::size_t i = 0; i < p.points.size(); ++i) {
    const ContactPoint& point = p.points[i];
    const Vec3 v = p.speed_at(i);
    const double normal = point.impulse.z(), friction = p.body.friction;
    const double total = std::max(1e-300, p.body.mass_kg * 3.0);  // about the momentum
    const Vec2 tangential = point.impulse.head<2>(), slip = v.head<2>();
    EXPECT_GE(normal, 0.0) << what;
    EXPECT_GE(v.z() - point.target_speed, -slack) << what;
    if (normal > 1e-9 * total) {
      EXPECT_LE(v.z() - point.target_speed, slack) << what;
    }
    EXPECT_LE(tangential.norm(), friction * normal + 1e-12 * total) << what;
    // Where it slips, friction is at its limit and against the slip.
    if (slip.norm() > 1e3 * slack) {
      EXPECT_LT((tangential + friction * normal * slip.normalized()).norm(),
                2.0 * friction * normal * slack / slip.norm() + 1e-12 * total)
          << what << ", slip " << slip.norm();
    }
  }
}

TEST(Contacts, SinglePointSticks) {
  RandomStream random(1, 0);
  for (int i = 0; i < 200; ++i) {
    Problem p = random_problem(random, 1, 1e6, 0.5);
    const Vec3 before = p.speed_at(0);
    if (before.z() >= 0.0) continue;
    const Vec3 wanted = Vec3(0, 0, p.points[0].target_speed) - before;
    const Vec3 expected = point_matrix(p.body, p.points[0].arm).fullPivLu().solve(wanted);
    if (expected.z() <= 0.0) continue;
    const Vec3 v0 = p.velocity, w0 = p.spin;
    solve_contacts(p.body, p.points, p.velocity, p.spin, 1e-12, 100);
    const Vec3 impulse = p.points[0].impulse;
    EXPECT_LT((impulse - expected).norm(), 1e-12 * expected.norm());
    EXPECT_LT((p.velocity - v0 - impulse / p.body.mass_kg).norm(), 1e-13 * before.norm());
    EXPECT_LT((p.spin - w0 - p.body.inverse_inertia * p.points[0].arm.cross(impulse)).norm(),
              1e-12 * (p.spin - w0).norm());
  }
}

// A ball: K is diagonal, so the slip keeps its direction and J_t = mu J_n against it.
TEST(Contacts, SlidingBall) {
  const double radius = 0.1, mass = 2.0;
  ContactBody body{mass, Mat3::Identity() / (0.4 * mass * radius * radius), 0.2};
  for (int heading = 0; heading < 8; ++heading) {
    const Vec3 along(std::cos(0.8 * heading), std::sin(0.8 * heading), 0.0);
    std::vector<ContactPoint> points(1);
    points[0].arm = {0, 0, -radius};
    points[0].target_speed = 1.2;
    Vec3 v = 10.0 * along - Vec3(0, 0, 3.0), w = Vec3::Zero();
    solve_contacts(body, points, v, w, 1e-12, 10);
    const double normal = mass * 4.2;
    EXPECT_LT((points[0].impulse - normal * (Vec3(0, 0, 1) - 0.2 * along)).norm(), 1e-14 * normal);
    // 2 m/s of the slip's 10 go by K_t = 3.5 / m
    EXPECT_NEAR((v + w.cross(points[0].arm)).dot(along), 10.0 - 3.5 * 0.2 * 4.2, 1e-13);
  }
}

// In the plane of a rod the slip has no choice: J_n = (target - v_n) / (K_nn - mu K_tn s), s the sign of the
// slip after.
TEST(Contacts, SlidingRodInItsPlane) {
  const double length = 1.0, mass = 1.0, moment = mass * length * length / 12.0;
  ContactBody body{mass, Mat3::Identity() / moment, 0.1};
  for (const double angle : {0.3, 0.8, 1.2}) {
    const Vec3 arm = 0.5 * length * Vec3(std::cos(angle), 0.0, -std::sin(angle));
    const Mat3 k = point_matrix(body, arm);
    for (const double slip : {-6.0, 6.0}) {
      std::vector<ContactPoint> points(1);
      points[0].arm = arm;
      points[0].target_speed = 0.5;
      Vec3 v(slip, 0.0, -1.0), w = Vec3::Zero();
      solve_contacts(body, points, v, w, 1e-12, 10);
      const double sign = slip > 0 ? 1.0 : -1.0;
      const double normal = 1.5 / (k(2, 2) - body.friction * k(0, 2) * sign);
      ASSERT_GT(slip * (slip + normal * (k(0, 2) - sign * body.friction * k(0, 0))),
                0.0);  // it goes on to slide
      EXPECT_NEAR(points[0].impulse.z(), normal, 1e-13 * normal);
      EXPECT_NEAR(points[0].impulse.x(), -sign * body.friction * normal, 1e-13 * normal);
      EXPECT_NEAR(points[0].impulse.y(), 0.0, 1e-14);
    }
  }
}

// One point is solved to rounding: tolerance for 3-vectors and a Newton iteration on an angle.
TEST(Contacts, SinglePointObeysCoulomb) {
  RandomStream random(2, 0);
  int slipped = 0;
  for (int i = 0; i < 20000; ++i) {
    Problem p = random_problem(random, 1, random.uniform(0.0, 1.0), random.uniform());
    solve_contacts(p.body, p.points, p.velocity, p.spin, 1e-13, 100);
    slipped += p.points[0].impulse.z() > 0.0 && p.speed_at(0).head<2>().norm() > 1e-6;
    expect_lawful(p, 1e-10, "case " + std::to_string(i));
    if (HasFailure()) return;
  }
  EXPECT_GT(slipped, 5000);
}

// Two points: the sweeps end once nothing changes by more than 1e-13 m/s, and converge linearly, so that more
// is left. Of three they may also end once they stall below 3e-6 of the speed (3 m/s here), ten times which
// may then be left.
TEST(Contacts, FewPointsObeyCoulomb) {
  RandomStream random(3, 0);
  for (const int n : {2, 3})
    for (int i = 0; i < 2000; ++i) {
      Problem p = random_problem(random, n, random.uniform(0.0, 0.4), 0.0);
      solve_contacts(p.body, p.points, p.velocity, p.spin, 1e-13, 100000);
      expect_lawful(p, n == 2 ? 1e-9 : 1e-4, std::to_string(n) + " points, case " + std::to_string(i));
      if (HasFailure()) return;
    }
}

TEST(Contacts, SeparatingPointsAreLeftAlone) {
  RandomStream random(4, 0);
  Problem p = random_problem(random, 4, 0.5, 0.0);
  p.velocity = {1.0, 2.0, 100.0};
  const Vec3 v = p.velocity, w = p.spin;
  solve_contacts(p.body, p.points, p.velocity, p.spin, 1e-12, 100);
  EXPECT_EQ(p.velocity, v);
  EXPECT_EQ(p.spin, w);
  for (const ContactPoint& point : p.points) EXPECT_EQ(point.impulse, Vec3(0, 0, 0));
}

// A block that lands flat on four corners: the plane's reaction is unique in sum, m (1 + e) v, and by
// symmetry equal.
TEST(Contacts, FlatLandingLoadsTheCornersAlike) {
  const double mass = 0.4;
  ContactBody body{mass, Vec3(3000, 2000, 1000).asDiagonal(), 0.3};
  std::vector<ContactPoint> points;
  for (int i = 0; i < 4; ++i) {
    ContactPoint p;
    p.arm = {i & 1 ? 0.02 : -0.02, i & 2 ? 0.01 : -0.01, -0.005};
    p.target_speed = 0.6;
    points.push_back(p);
  }
  Vec3 v(0, 0, -1.2), w = Vec3::Zero();
  solve_contacts(body, points, v, w, 1e-14, 200);
  EXPECT_LT((v - Vec3(0, 0, 0.6)).norm(), 1e-14);
  EXPECT_LT(w.norm(), 1e-12);
  for (const ContactPoint& p : points)
    EXPECT_LT((p.impulse - Vec3(0, 0, 0.25 * mass * 1.8)).norm(), 1e-13 * mass);
}

TEST(Contacts, SpinFrictionIsCappedByItsLength) {
  const double mass = 2.0, radius = 0.1, moment = 0.4 * mass * radius * radius;
  ContactBody body{mass, Mat3::Identity() / moment, 0.5, 1e-3, 2e-3};
  std::vector<ContactPoint> points(1);
  points[0].arm = {0, 0, -radius};
  Vec3 v(0, 0, -0.1), w(0, 0, 5.0);
  solve_contacts(body, points, v, w, 1e-13, 100);
  EXPECT_NEAR(w.z(), 5.0 - 2e-3 * mass * 0.1 / moment, 1e-12);
  points[0].impulse.setZero();
  v = {0, 0, -10.0};
  w = {0, 0, 0.5};  // little enough to be stopped: 2e-3 m v / I = 5 rad/s
  solve_contacts(body, points, v, w, 1e-13, 100);
  EXPECT_NEAR(w.z(), 0.0, 1e-12);
}

}  // namespace
}  // namespace ifa
