// Where on the plane, in which heading, and as which image of itself a body does what it did in a simulation.
#pragma once

#include "ifa/rigid/symmetry.hpp"

namespace ifa {

// s -> shift + turn about z of the image of s under a symmetry element: another motion of the same body.
struct Transplant {
  SymmetryElement element{Mat3::Identity(), true};
  Quat turn = Quat::Identity();
  Vec3 shift = Vec3::Zero();

  State of(const State& s) const;

  // First `inner`, then this.
  Transplant after(const Transplant& inner) const;
};

// The turn and shift that bring `from`'s pose nearest to that of `to` (paper section 5.3.1): the mass centres
// above each other, the orientations as near as a turn about the vertical brings them.
Transplant registration(const State& from, const State& to);

}  // namespace ifa
