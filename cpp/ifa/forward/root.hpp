// The root of a function that jumps, has gaps and is dear: a short simulation for each value.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace ifa {

struct RootPoint {
  double x, value;
};

// Closes in on the sign change between two points: regula falsi (Illinois), halving where an end is not
// finite. At most `refinements` values; stops at |f| <= tolerance, or where `f` is undefined. `f` may jump,
// and give +infinity.
template <class Function>
void close_in(RootPoint low, RootPoint high, Function&& f, double tolerance, int refinements) {
  int moved = 0;  // the end that the last value replaced
  for (int k = 0; k < refinements; ++k) {
    double x = 0.5 * (low.x + high.x);
    if (std::isfinite(low.value) && std::isfinite(high.value)) {
      const double secant = (low.x * high.value - high.x * low.value) / (high.value - low.value);
      const double edge = 1e-3 * (high.x - low.x);
      x = std::clamp(secant, low.x + edge, high.x - edge);
    }
    const std::optional<double> value = f(x);
    if (!value || std::abs(*value) <= tolerance) return;
    if ((*value > 0.0) == (low.value > 0.0)) {
      low = {x, *value};
      if (moved < 0) high.value *= 0.5;
      moved = -1;
    } else {
      high = {x, *value};
      if (moved > 0) low.value *= 0.5;
      moved = 1;
    }
  }
}

// Tries `trials` in turn until two neighbours differ in sign, then closes in between them. Returns all finite
// values seen, the best last. `f` gives nothing where it is undefined.
template <class Function>
std::vector<RootPoint> find_root(Function&& f, const std::vector<double>& trials, double tolerance,
                                 int refinements) {
  std::vector<RootPoint> seen;  // sorted by x
  std::vector<RootPoint> finite;
  const auto evaluate = [&](double x) -> std::optional<double> {
    const std::optional<double> value = f(x);
    if (value && std::isfinite(*value)) finite.push_back({x, *value});
    return value;
  };
  const auto bracketed = [&] {
    for (std::size_t i = 0; i + 1 < seen.size(); ++i) {
      if ((seen[i].value > 0.0) == (seen[i + 1].value > 0.0)) continue;
      close_in(seen[i], seen[i + 1], evaluate, tolerance, refinements);
      return true;
    }
    return false;
  };
  for (const double trial : trials) {
    const auto value = evaluate(trial);
    if (!value) continue;
    if (std::abs(*value) <= tolerance) break;
    const auto after = [](const RootPoint& p, double x) { return p.x < x; };
    seen.insert(std::lower_bound(seen.begin(), seen.end(), trial, after), {trial, *value});
    if (bracketed()) break;
  }
  std::stable_sort(finite.begin(), finite.end(), [](const RootPoint& a, const RootPoint& b) {
    return std::abs(a.value) > std::abs(b.value);
  });
  return finite;
}

}  // namespace ifa
