// When the body touches the ground.
#pragma once

#include <vector>

#include "ifa/verify/contacts.hpp"
#include "ifa/verify/physics.hpp"
#include "ifa/verify/track.hpp"

namespace ifa::verify {

// An impact, or a run of samples on the ground.
struct Touch {
  double begin_s, end_s;
  double latest_end_s;  // where it does not end with an impact, contact may last until the sample after it
  bool certain;         // not if it is within Track::touch() of the ground but falls freely
  int impact;           // its index, -1 for a run
};

// In order of their beginnings; those that begin after `rest_s` are left out, and the others end with it.
//
// A body that hovers within the touching height looks as one that stands; what tells them apart is the force
// on it. Where that is less than a twentieth of its weight, each may be the other.
std::vector<Touch> find_touches(const Track& track, const Impacts& impacts, const Options& options,
                                const RetimeAt& retime_at, double rest_s);

}  // namespace ifa::verify
