// Finds impacts in sampled poses.
#pragma once

#include <vector>

#include "ifa/verify/track.hpp"

namespace ifa::verify {

struct Impact {
  double time_s;
  double speed_m_s;  // of approach, the largest over the touching points
  Vec3 position_m;
  int sample;  // at it, or the last one before it
  bool at_sample;
};

struct Impacts {
  std::vector<Impact> list;
  std::vector<char> kinked;  // per interval: an impact lies inside it
  double deepest_m = 0.0;    // where the paths before and after an impact between samples meet
  double deepest_time_s = 0.0;
};

// An impact is where a touching point's material velocity turns: it approaches before, and does not go on
// approaching after. Sustained contact shows no such turn: its points move with the ground up to the
// error of stepping and interpolation (about g times half a step: 0.005 m/s), so nothing is invented there.
//
// At samples: a point within Track::touch() of the ground, its approach speed from the samples before. Where
// several come down, those that do so further are not yet there, only slowed by the others' impact. A point
// that touched at the sample before as well is no faster than its height tells: it may roll.
// Between samples: the motion extrapolated from the samples before runs into the ground before the next
// sample, which is not where the extrapolation leads; the instant is the extrapolation's root. No stencil
// reaches across an earlier impact.
Impacts find_impacts(const Track& track);

}  // namespace ifa::verify
