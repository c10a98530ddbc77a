#include "ifa/rigid/body.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <utility>

#include "ifa/base/error.hpp"
#include "ifa/rigid/hull.hpp"

namespace ifa {
namespace {

constexpr double kEqualMoments = 1e-12;    // above rounding in the inertia of a regular solid
constexpr double kInertiaSlack = 1e-9;     // for measured or printed inertias
constexpr double kSmallestMoment = 1e-13;  // of the largest; a smaller one cannot be told from zero

void need(bool condition, const char* message) {
  if (!condition) throw ArgumentError(message);
}

bool is_non_negative(double x) { return std::isfinite(x) && x >= 0.0; }

void check_scalars(const Body::Definition& d) {
  need(is_non_negative(d.radius_m), "radius_m: must be finite and not negative");
  need(std::isfinite(d.mass_kg) && d.mass_kg > 0.0, "mass_kg: must be finite and above 0");
  need(d.centre_of_mass_m.allFinite(), "centre_of_mass_m: must be finite");
  need(d.inertia_kg_m2.allFinite(), "inertia_kg_m2: must be finite");
  const Material& m = d.material;
  need(m.restitution >= 0.0 && m.restitution <= 1.0, "restitution: must lie between 0 and 1");
  need(is_non_negative(m.friction), "friction: must be finite and not negative");
  need(is_non_negative(m.rolling_friction_m), "rolling_friction_m: must be finite and not negative");
  need(is_non_negative(m.spin_friction_m), "spin_friction_m: must be finite and not negative");
}

Mat3 symmetrised(const Mat3& inertia) {
  const double scale = inertia.cwiseAbs().maxCoeff();
  need((inertia - inertia.transpose()).cwiseAbs().maxCoeff() <= kInertiaSlack * scale,
       "inertia_kg_m2: must be symmetric");
  return 0.5 * (inertia + inertia.transpose());
}

struct PrincipalAxes {
  Vec3 moments;
  Quat body_from_principal = Quat::Identity();
};

PrincipalAxes principal_axes(const Mat3& inertia) {
  PrincipalAxes axes{inertia.diagonal()};
  const double off_diagonal =
      std::max({std::abs(inertia(0, 1)), std::abs(inertia(0, 2)), std::abs(inertia(1, 2))});
  // already diagonal: keep the order of the axes
  if (off_diagonal <= kEqualMoments * inertia.diagonal().cwiseAbs().maxCoeff()) return axes;
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia);
  need(solver.info() == Eigen::Success, "inertia_kg_m2: its principal axes cannot be found");
  Mat3 rotation = solver.eigenvectors();
  if (rotation.determinant() < 0.0) rotation.col(2) *= -1.0;
  return {solver.eigenvalues(), Quat(rotation).normalized()};
}

void check_moments(const Vec3& moments) {
  const double largest = moments.maxCoeff();
  need(moments.minCoeff() > kSmallestMoment * largest && largest > 0.0,
       "inertia_kg_m2: every principal moment must be above 0 (and above 1e-13 of the largest)");
  need(moments.sum() - 2.0 * largest >= -kInertiaSlack * largest,
       "inertia_kg_m2: the largest principal moment exceeds the sum of the others, "
       "which no body can have");
}

// The extreme points of the vertices that are not within the hull of the rings. Those on a ring's disc are
// known exactly, those between rings from polygons within these; what stays by mistake is inside, harmless.
std::vector<Vec3> beside_rings(const std::vector<Vec3>& vertices, const std::vector<Ring>& rings) {
  constexpr int kCorners = 180;
  constexpr double kOnDisc = 1e-9;  // of the ring's radius
  std::vector<Vec3> points = ring_points(rings, kCorners);
  const std::size_t first = points.size();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (!vertices[i].allFinite())
      throw ArgumentError("vertices_m: point " + std::to_string(i) + " has a coordinate that is not finite");
    const bool on_disc = std::any_of(rings.begin(), rings.end(), [&](const Ring& ring) {
      const Vec3 arm = vertices[i] - ring.centre_m;
      return std::abs(arm.dot(ring.axis)) <= kOnDisc * ring.radius_m &&
             arm.norm() <= (1.0 + kOnDisc) * ring.radius_m;
    });
    if (!on_disc) points.push_back(vertices[i]);
  }
  if (points.size() == first) return {};
  std::vector<Vec3> kept;
  for (const Vec3& p : convex_hull(points).vertices)
    if (std::find(points.begin() + static_cast<std::ptrdiff_t>(first), points.end(), p) != points.end())
      kept.push_back(p);
  return kept;
}

}  // namespace

Body Body::make(Definition definition) {
  check_scalars(definition);
  definition.inertia_kg_m2 = symmetrised(definition.inertia_kg_m2);
  const auto [moments, body_from_principal] = principal_axes(definition.inertia_kg_m2);
  check_moments(moments);

  if (definition.rings_m.empty()) {
    Hull hull = convex_hull(definition.vertices_m);
    need(!hull.flat || definition.radius_m > 0.0,
         "vertices_m: their hull has no volume, which needs a radius_m above 0");
    definition.vertices_m = std::move(hull.vertices);
  } else {
    check_rings(definition.rings_m);
    definition.vertices_m = beside_rings(definition.vertices_m, definition.rings_m);
  }

  Body body;
  body.principal_inertia_ = moments;
  body.body_from_principal_ = body_from_principal;
  body.isotropic_ = moments.maxCoeff() - moments.minCoeff() <= kEqualMoments * moments.maxCoeff();
  const Mat3 principal_from_body = body_from_principal.conjugate().toRotationMatrix();
  for (const Vec3& vertex : definition.vertices_m) {
    const Vec3 v = vertex - definition.centre_of_mass_m;
    body.vertices_.push_back(v);
    body.principal_vertices_.push_back(principal_from_body * v);
    body.bounding_radius_m_ = std::max(body.bounding_radius_m_, v.norm() + definition.radius_m);
  }
  for (Ring ring : definition.rings_m) {
    ring.centre_m -= definition.centre_of_mass_m;
    body.rings_.push_back(ring);
    const double along = ring.axis.dot(ring.centre_m);
    const double across = (ring.centre_m - along * ring.axis).norm() + ring.radius_m;
    body.bounding_radius_m_ =
        std::max(body.bounding_radius_m_, std::hypot(along, across) + definition.radius_m);
    body.principal_rings_.push_back(
        {principal_from_body * ring.centre_m, principal_from_body * ring.axis, ring.radius_m});
  }
  body.definition_ = std::move(definition);
  return body;
}

Material Body::contact_material() const {
  Material material = definition_.material;
  if (definition_.friction == false)
    material.friction = material.rolling_friction_m = material.spin_friction_m = 0.0;
  return material;
}

Body Body::with_material(const Material& material) const {
  Definition definition = definition_;
  definition.material = material;
  return make(std::move(definition));
}

Body Body::with_switches(std::optional<bool> spin_coupling, std::optional<bool> friction) const {
  Body body = *this;
  body.definition_.spin_coupling = spin_coupling;
  body.definition_.friction = friction;
  return body;
}

}  // namespace ifa
