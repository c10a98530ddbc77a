// Which effects a body takes part in, and how often their code has run.
#pragma once

#include "ifa/base/effects.hpp"
#include "ifa/rigid/lanes/pack.hpp"
#include "ifa/rigid/lanes/sim.hpp"

namespace ifa::IFA_LANES_NAMESPACE {

using lanes::BodyView;

// Constant where the build leaves the effect out, so that its code is none.
inline bool couples_spin(const BodyView& body) {
  return compiled(Effect::spin_coupling) && body.couples_spin;
}
inline int rings(const BodyView& body) { return compiled(Effect::circular_edges) ? body.rings : 0; }

// Once for each simulation, so that the count does not depend on the width.
inline void count(Effect effect, Mask where) {
  for (unsigned b = bits(where); b; b &= b - 1) ++effect_counts.runs[static_cast<int>(effect)];
}

}  // namespace ifa::IFA_LANES_NAMESPACE
