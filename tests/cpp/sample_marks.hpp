// What tests ask a solve for.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "ifa/signature/marks.hpp"
#include "sample_bodies.hpp"

namespace ifa::sample {

inline Body cube() { return box({0.016, 0.016, 0.016}, 0.005); }

inline Marks marks_at(std::vector<double> times_s, Ending ending = Ending::rest) {
  Marks marks;
  marks.durations_s.assign(times_s.size(), 0.0);
  marks.centroids_s.assign(times_s.size(), std::nan(""));
  marks.times_s = std::move(times_s);
  marks.ending = ending;
  return marks;
}

}  // namespace ifa::sample
