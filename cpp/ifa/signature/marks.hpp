// The contact-time signature of a sound (paper section 3): what the user marked.
#pragma once

#include <cstddef>
#include <vector>

#include "ifa/signature/constraints.hpp"

namespace ifa {

// What the body does after the last mark: `rest`, it comes to rest without a further hit; `open`, anything.
enum class Ending { rest, open };

struct Marks {
  std::vector<double> times_s;      // strictly increasing, from the sound's start, kept as given
  std::vector<double> durations_s;  // same length; 0 is a discrete contact
  std::vector<double> amplitudes;   // same length, or empty: unknown (no amplitude term); not normalised
  std::vector<double> centroids_s;  // same length, NaN where unknown; from the event's start
  Ending ending = Ending::rest;
  Constraints constraints = {};

  std::size_t size() const { return times_s.size(); }
};

inline constexpr double kMergeGap_s = 0.010;  // paper section 4: contacts closer than this are one event

// Throws ArgumentError naming the mark unless there is at least one mark; times are finite, not negative and
// at least `merge_gap_s` apart from start to start; no mark starts inside the span of the one before;
// durations and amplitudes are finite and not negative; the first amplitude, to which the others are
// relative, is not 0; and every known centroid lies in its mark's span; and unless its
// constraints are valid.
void validate(const Marks& marks, double merge_gap_s = kMergeGap_s);

}  // namespace ifa
