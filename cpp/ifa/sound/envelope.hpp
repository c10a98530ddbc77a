// How loud a sound is at its marks (paper section 3, "Contact event amplitudes").
#pragma once

#include <vector>

#include "ifa/sound/file.hpp"

namespace ifa {

struct MarkAmplitudes {
  std::vector<double> amplitudes;   // full scale is 1, not normalised to the first mark
  std::vector<double> centroids_s;  // from the mark's start; NaN for discrete marks and silent spans
};

inline constexpr double kPeakWindow_s = 0.020;  // paper section 3
inline constexpr double kEnvelopeBin_s = 0.001;

// `times_s` and `durations_s` as in Marks, of the same length.
//
// A discrete mark (duration 0) has the largest |sample| in the kPeakWindow_s after it; the window is cut at
// half the gap to the next mark, so that a loud successor does not count for a quiet hit. A mark with a
// duration has the largest |sample| of its span, and the centroid tau of paper eq. 8: the mean time of the
// span weighted by its amplitude envelope, here the root mean square in bins of kEnvelopeBin_s, which changes
// little with the sample rate. A constant background draws the centroid towards the middle of the span.
//
// Throws ArgumentError naming the mark if it lies outside the sound, if its span ends more than kPeakWindow_s
// after the sound does (a shorter excess is cut), or if the sound is silent at the first mark, to which the
// other amplitudes are relative.
MarkAmplitudes mark_amplitudes(const Sound& sound, const std::vector<double>& times_s,
                               const std::vector<double>& durations_s);

}  // namespace ifa
