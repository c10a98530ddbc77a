// The root of a function that jumps, has gaps and is dear: a short simulation for each value.
#pragma once

#include <algorithm>
#include <cmath>

namespace ifa {

struct RootPoint {
  double x, value;
};

// Closes in on the sign change between two points, one value at a time, so that many brackets can be advanced
// side by side: regula falsi (Illinois), halving where an end is not finite. The function may jump, and give
// +infinity.
class Bracket {
 public:
  Bracket(RootPoint low, RootPoint high) : low_(low), high_(high) {}

  // Where the function is to be looked at next.
  double next() const {
    if (!std::isfinite(low_.value) || !std::isfinite(high_.value)) return 0.5 * (low_.x + high_.x);
    const double secant = (low_.x * high_.value - high_.x * low_.value) / (high_.value - low_.value);
    const double edge = 1e-3 * (high_.x - low_.x);
    return std::clamp(secant, low_.x + edge, high_.x - edge);
  }

  // Takes its value there, not NaN.
  void add(RootPoint p) {
    if ((p.value > 0.0) == (low_.value > 0.0)) {
      low_ = p;
      if (moved_ < 0) high_.value *= 0.5;
      moved_ = -1;
    } else {
      high_ = p;
      if (moved_ > 0) low_.value *= 0.5;
      moved_ = 1;
    }
  }

  double width() const { return high_.x - low_.x; }

 private:
  RootPoint low_, high_;
  int moved_ = 0;  // the end that the last value replaced
};

}  // namespace ifa
