// What `succeeded` and `plausible` mean (CONVENTIONS.md): one place for whoever searches, measures or
// explains.
#pragma once

namespace ifa {

// How far an impact may be changed (|C v_eval|^2) and an interval retimed (ratio - 1).
struct Tolerance {
  double excess, retime;
};
inline constexpr Tolerance kPlausible{1.0, 0.07};

// A motion that succeeded.
inline constexpr double kMostError_s = 1e-3, kMostRetime = 0.30, kMostPenetration_m = 1e-4, kLeastScore = 0.3;
inline constexpr double kStandardRounding = 1e-9;  // that these allow

// A mark whose factors multiply to less drags the Score (eq. 12) below kLeastScore: 6 log 0.3, rounded.
inline constexpr double kLeastLogFactors = -7.2;

// Takes differ by at least so much: Motion difference from the first to the last mark, in bounding radii.
inline constexpr double kClearlyDifferent = 1.0;

inline constexpr double kLongestRest_s = 60.0;  // a body that has not come to rest by then is given up
inline constexpr double kOpenTail_s = 0.5;      // how long a motion with an open ending goes on at most

}  // namespace ifa
