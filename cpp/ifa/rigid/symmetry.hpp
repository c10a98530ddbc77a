// The symmetry group of a body: the orthogonal maps, turns and reflections, that carry its rounded hull and
// its mass properties onto themselves. Each makes another physical motion out of a motion, so that one stands
// for all: a state is folded (replaced by the image whose `up` lies in one fixed part of the sphere), and who
// looks for neighbours of a state asks from a few of its images.
//
// Principal axes throughout. Features of a state modulo where it is and how it is turned about the vertical:
// the world's up u and the velocities v and omega, all in principal axes, and the height. Under g
//     u' = g u      v' = g v      omega' = det(g) g omega      height' = height
// so any distance that sums |difference|^2 over these vectors is the same for two states and for their
// images.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "ifa/rigid/state.hpp"

namespace ifa {

struct SymmetryElement {
  Mat3 map = Mat3::Identity();  // orthogonal
  bool proper = true;           // a turn, det +1; else det -1: a mirror, the inversion, a turn with a mirror
};

class Symmetry {
 public:
  // axial: any turn about one axis through the centre of mass (a coin, a capsule). ball: any turn.
  enum class Kind { finite, axial, ball };

  static constexpr int kMostElements = 255;

  // `tolerance` is the largest distance, in bounding radii, by which a map may miss the hull, and the largest
  // misfit of the inertia, of its largest moment. What is returned is a group always: where maps that fit do
  // not form one, for the body is off by just about the tolerance, a smaller tolerance is taken. A finite
  // group of more than kMostElements (a prism of 64 sides or more) is replaced by a subgroup.
  static Symmetry of(const Body& body, double tolerance = 1e-6);

  Kind kind() const { return kind_; }

  // The identity first, then the other turns, then the improper ones. For axial and ball what is left with
  // the turns taken out: the maps that carry a fixed half plane, bounded by axis(), onto itself. These are
  // {1, the mirror m through that half plane}, and where the axis can be flipped also the half turn that does
  // it and the mirror across the axis. For a ball {1, m}.
  const std::vector<SymmetryElement>& elements() const& { return elements_; }
  std::vector<SymmetryElement> elements() && { return std::move(elements_); }

  // Of the turns: for axial the body's, for ball the one to which `up` is folded. Finite: no meaning.
  const Vec3& axis() const { return axis_; }

  // Schoenflies: C1, D2h (box), Oh (cube), Td, D5d (d10), Ih; Cinfv and Dinfh for axial, Kh for ball.
  std::string name() const;

  // The map that brings `up` (a unit vector) into the domain. Finite: the element g with the largest d . (g
  // u), d a fixed direction that no element leaves in place; of equals the first. The domain is then the
  // Dirichlet cell of d, a convex part of the sphere of 1 / elements().size() of its area. Axial: the turn
  // into the half plane, and where the axis can be flipped the flip into its quarter u . axis >= 0. Ball: the
  // shortest turn to axis(). fold() is never improper for axial and ball.
  SymmetryElement fold(const Vec3& up) const;
  int fold_element(const Vec3& up) const;  // the index in elements() of the part of fold() that is no turn

  // The images that a search has to ask from to miss none. Let b be a folded state, and a any state of which
  // some image is near b: for a g of the group, g(a) is within a distance delta of b, and with it g u_a
  // within `max_angle_rad` of u_b. Then one s of images_near(u_a, max_angle_rad, max_turn_rad)
  // - finite: is that g;
  // - axial: is that g but for a turn about axis() of max_turn_rad / 2 at most;
  // - ball: is that g but for a turn of max_angle_rad + max_turn_rad / 2 at most, about any axis.
  // A turn by t moves a vector w by t |w| at most (about an axis: its part across it). So every such b lies
  // within delta + t |(u, v, omega)| of s(a), its components weighted as in the distance.
  //
  // Why turns are needed at all: near the axis a small change of `up` is any turn, so that folding tears
  // apart what is close (a coin that lies nearly flat). Away from it the range of turns is
  // asin(sin(max_angle) / sin(angle from the axis)) to either side. The mirror m through the half plane
  // leaves `up` where it is, not so v and omega: it doubles the images. Likewise a finite group gives both
  // images of an `up` on a mirror plane.
  //
  // Conservative: some images may be further off than max_angle_rad. That of fold() is always among them.
  std::vector<SymmetryElement> images_near(const Vec3& up, double max_angle_rad, double max_turn_rad) const;

 private:
  Symmetry(Kind kind, const Vec3& axis, std::vector<SymmetryElement> elements, double tolerance);

  Mat3 turn_away(const Vec3& up) const;  // axial: into the half plane. ball: to the axis

  Kind kind_;
  Vec3 axis_, side_;  // side_: across the axis, in the half plane
  bool flips_ = false;
  std::vector<SymmetryElement> elements_;
  double slack_;              // what the elements may be off by
  std::vector<Vec3> pulled_;  // finite: g^T d for each element
  std::vector<Vec3> walls_;  // finite: unit normals of the domain's great circles, inwards; the nearest first
};

// The mirror that goes with an improper element in world axes, y to -y. It leaves up, and any gravity in the
// x-z plane.
inline const Mat3 kWorldMirror = Vec3(1.0, -1.0, 1.0).asDiagonal();

// The state that the body is in when it moves as `s` does but with its points relabelled by g. Proper: only
// the orientation differs, R' = R g^-1. Improper: with M = kWorldMirror
//     R' = M R g^-1      x' = M x      v' = M v      omega' = -M omega (an axial vector)
// Simulating the image is the image of the simulation; impulses and points of contact go by M. (But for
// slides on four points or more, whose loads the engine finds by the order of the points; see CONVENTIONS.)
State image(const SymmetryElement& g, const State& s);

}  // namespace ifa
