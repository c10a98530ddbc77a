#include "ifa/rigid/lanes/rare.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "ifa/base/linear_algebra.hpp"

namespace ifa::lanes {
namespace {

struct HardPoint {
  const double* k;
  const double* f;
  double target, friction;

  // See Slide in contacts.hpp.
  double residual(double c, double s) const {
    const double a = target - f[2];
    const double across = c * f[1] - s * f[0];
    const double k_across = c * k[4] - s * k[2], k_along = c * k[2] + s * k[4];
    const double twist = c * s * (k[3] - k[0]) + (c * c - s * s) * k[1];
    return across * (k[5] - friction * k_along) + a * (k_across - friction * twist);
  }

  // The impulse for a root; false if it would pull, or slip against its direction.
  bool impulse(double c, double s, double out[3], double& slip) const {
    const double open = k[5] - friction * (c * k[2] + s * k[4]);
    if (open <= 1e-9 * k[5]) return false;
    const double normal = (target - f[2]) / open;
    out[0] = -friction * normal * c, out[1] = -friction * normal * s, out[2] = normal;
    const double ux = f[0] + k[0] * out[0] + k[1] * out[1] + k[2] * out[2];
    const double uy = f[1] + k[1] * out[0] + k[3] * out[1] + k[4] * out[2];
    slip = ux * c + uy * s;
    return slip >= -1e-12 * std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
  }
};

}  // namespace

void solve_hard_point(const double response[6], const double free[3], double target, double friction,
                      double impulse[3]) {
  constexpr int kDirections = 32;
  static const auto circle = [] {
    std::array<std::array<double, 2>, kDirections + 1> points;
    for (int i = 0; i <= kDirections; ++i) {
      const double angle = 2 * std::numbers::pi * (i % kDirections) / kDirections;
      points[i] = {std::cos(angle), std::sin(angle)};
    }
    return points;
  }();
  const HardPoint point{response, free, target, friction};
  double best = -1.0;
  double at_low = point.residual(circle[0][0], circle[0][1]);
  for (int i = 0; i < kDirections; ++i) {
    const auto [c0, s0] = circle[i];
    const auto [c1, s1] = circle[i + 1];
    const double at_high = point.residual(c1, s1), at_here = std::exchange(at_low, at_high);
    if (at_here * at_high > 0.0) continue;
    // Regula falsi (Illinois) along the chord; the direction is its point, normalised.
    double low = 0.0, high = 1.0, f_low = at_here, f_high = at_high, c = c0, s = s0;
    for (int step = 0, moved = 0; step < 60 && high - low > 1e-16; ++step) {
      const double x =
          f_high == f_low ? low : std::clamp((low * f_high - high * f_low) / (f_high - f_low), low, high);
      c = c0 + x * (c1 - c0), s = s0 + x * (s1 - s0);
      const double scale = 1.0 / std::sqrt(c * c + s * s);
      c *= scale, s *= scale;
      const double f = point.residual(c, s);
      if (f == 0.0 || x == low || x == high) break;
      if (f * at_here > 0.0) {
        low = x, f_low = f;
        if (moved < 0) f_high *= 0.5;
        moved = -1;
      } else {
        high = x, f_high = f;
        if (moved > 0) f_low *= 0.5;
        moved = 1;
      }
    }
    double candidate[3], slip = 0.0;
    if (point.impulse(c, s, candidate, slip) && candidate[2] * slip > best) {
      best = candidate[2] * slip;
      std::copy_n(candidate, 3, impulse);
    }
  }
  if (best >= 0.0) return;
  const double normal = (target - free[2]) / response[5];
  const double slip = std::sqrt(free[0] * free[0] + free[1] * free[1]);
  const double share = std::min(friction, slip / (normal * (response[0] + response[3])));
  impulse[0] = slip > 0.0 ? -share * normal * free[0] / slip : 0.0;
  impulse[1] = slip > 0.0 ? -share * normal * free[1] / slip : 0.0;
  impulse[2] = normal;
}

bool supports(const double* xy, int points, double near, double rolling_m) {
  constexpr double kSlack = 1e-3;  // rad
  for (int i = 0; i < points; ++i)
    if (std::hypot(xy[2 * i], xy[2 * i + 1]) <= near) return true;
  for (int i = 0; i < points; ++i)
    for (int j = i + 1; j < points; ++j) {
      const double x = xy[2 * i], y = xy[2 * i + 1], dx = xy[2 * j] - x, dy = xy[2 * j + 1] - y;
      const double along = -(x * dx + y * dy), square = dx * dx + dy * dy;
      if (along > 0.0 && along < square && std::abs(x * dy - y * dx) <= rolling_m * std::sqrt(square))
        return true;
    }
  // No gap of more than half a turn: each point has another one at most that far on, counter-clockwise.
  for (int i = 0; i < points; ++i) {
    const double x = xy[2 * i], y = xy[2 * i + 1];
    bool followed = false;
    for (int j = 0; j < points && !followed; ++j) {
      const double u = xy[2 * j], v = xy[2 * j + 1];
      const double slack = kSlack * std::hypot(x, y) * std::hypot(u, v);
      const double across = x * v - y * u, along = x * u + y * v;
      followed = across > slack || (std::abs(across) <= slack && along < 0.0);
    }
    if (!followed) return false;
  }
  return points >= 2;
}

}  // namespace ifa::lanes
