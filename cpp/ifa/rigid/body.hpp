// A rigid body: a convex hull of vertices with a rounding radius (Minkowski sum with a ball), mass,
// centre of mass, inertia and material.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ifa/base/linear_algebra.hpp"
#include "ifa/rigid/hull.hpp"

namespace ifa {

struct Material {
  double restitution = 0.5;          // Newton's e, in [0, 1]
  double friction = 0.3;             // Coulomb's mu, >= 0
  double rolling_friction_m = 5e-5;  // largest rolling resistance torque over normal force
  double spin_friction_m = 5e-5;     // largest torque about the normal over normal force
};

// Immutable after make(). Two sets of axes: "body" axes are the user's (the mesh's), "principal" axes
// diagonalise the inertia; both have the centre of mass as their origin. The engines work in
// principal axes, everything at the boundary in body axes.
class Body {
 public:
  struct Definition {
    std::string name = "body";
    std::vector<Vec3> vertices_m;  // any points whose convex hull is the contact shape
    std::vector<Ring> rings_m;     // circular edges of that hull, at most kMostRings; any length of axis
    double radius_m = 0.0;         // rounding radius
    double mass_kg = 0.0;
    Vec3 centre_of_mass_m = Vec3::Zero();  // in the axes of vertices_m
    Mat3 inertia_kg_m2 = Mat3::Zero();     // about the centre of mass, in the axes of vertices_m
    Material material;
    // Effects forced on or off; without a value as the body calls for (rigid/effects.hpp).
    std::optional<bool> spin_coupling, friction;
  };

  // The contact shape is the hull of the vertices and the rings, rounded. Vertices are needed only where
  // there is no ring; those that lie within the hull of the rings are dropped, and so never touch beside it.
  // Throws ArgumentError naming the field: no or non-finite vertices, rings without axis or radius or too
  // many of them, negative radius, mass <= 0, an inertia that is not symmetric positive definite or violates
  // the triangle inequality, a degenerate hull with radius 0 (a ring may have it: a thin disk), restitution
  // outside [0, 1], negative friction.
  static Body make(Definition definition);

  // The same body of another material. Throws as make() does.
  Body with_material(const Material& material) const;
  // The same body with effects forced on or off (rigid/effects.hpp chooses which).
  Body with_switches(std::optional<bool> spin_coupling, std::optional<bool> friction) const;

  const std::string& name() const { return definition_.name; }
  const Definition& definition() const { return definition_; }
  const Material& material() const { return definition_.material; }
  double mass_kg() const { return definition_.mass_kg; }
  double radius_m() const { return definition_.radius_m; }
  const Mat3& inertia_kg_m2() const { return definition_.inertia_kg_m2; }

  // Extreme points of the hull relative to the centre of mass, in body axes and in principal axes.
  const std::vector<Vec3>& vertices() const { return vertices_; }
  const std::vector<Vec3>& principal_vertices() const { return principal_vertices_; }
  // Likewise the circular edges, their axes unit vectors.
  const std::vector<Ring>& rings() const { return rings_; }
  const std::vector<Ring>& principal_rings() const { return principal_rings_; }
  const Vec3& principal_inertia() const { return principal_inertia_; }
  // Maps principal axes to body axes. The identity where the given inertia is already diagonal.
  const Quat& body_from_principal() const { return body_from_principal_; }
  double bounding_radius_m() const { return bounding_radius_m_; }  // of the ball about the centre of mass
  bool isotropic() const { return isotropic_; }  // all moments equal to 1e-12: spins about any axis

  // Whether its rotation has the gyroscopic term. Without it flight turns with a constant spin, exact for an
  // isotropic body; impacts know the true inertia all the same.
  bool couples_spin() const { return definition_.spin_coupling.value_or(!isotropic_); }
  // The material that contacts have: without friction where that is forced off.
  Material contact_material() const;
  // Whether contacts solve Coulomb's cone: where there is friction, or it is forced on.
  bool has_cone() const { return definition_.friction.value_or(material().friction > 0.0); }

 private:
  Definition definition_;
  std::vector<Vec3> vertices_, principal_vertices_;
  std::vector<Ring> rings_, principal_rings_;
  Vec3 principal_inertia_ = Vec3::Ones();
  Quat body_from_principal_ = Quat::Identity();
  double bounding_radius_m_ = 0.0;
  bool isotropic_ = false;
};

}  // namespace ifa
