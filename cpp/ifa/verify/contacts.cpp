#include "ifa/verify/contacts.hpp"

#include <algorithm>
#include <utility>

namespace ifa::verify {
namespace {

constexpr double kSlowestAtSample = 0.02;  // m/s; above the noise of sustained contact
constexpr double kSlowestInFlight =
    0.005;  // m/s; between samples, coming from flight: extrapolation is exact there
constexpr double kSlowestInContact = 0.03;  // m/s; between samples, coming from sustained contact
constexpr double kFlightError = 2e-6;       // m, of an extrapolation over one step; single precision included
constexpr double kHeightError = 2e-7;  // m, of one height against another; twice that of single precision
// m/s^2: contact forces unknown to the extrapolation (up to about 10 g at a corner).
constexpr double kContactAcceleration = 100.0;

class Finder {
 public:
  explicit Finder(const Track& track) : track_(track) { impacts_.kinked.assign(track.size(), 0); }

  Impacts run() {
    for (int i = 1; i < track_.size(); ++i) {
      if (i - 1 > first_ && between(i - 1)) {
        impacts_.kinked[i - 1] = 1;
        first_ = i;
      } else if (at(i)) {
        first_ = i;
      }
    }
    for (const Meeting& m : meetings_) {
      const bool is_last = m.impact + 1 == impacts_.list.size();
      meet(m, is_last ? track_.size() - 1 : impacts_.list[m.impact + 1].sample);
    }
    return std::move(impacts_);
  }

 private:
  struct Meeting {
    int interval;
    Velocity before;
    int point;
    std::size_t impact;
  };

  bool at(int i) {
    if (i <= first_ || track_.lowest(i) > track_.touch()) return false;
    const bool last = i + 1 == track_.size();
    const Pose pose{track_.position(i), track_.orientation(i)};
    const Velocity velocity = track_.before(i, first_);
    double speed = kSlowestAtSample, later_speed = kSlowestAtSample;
    int hitting = -1, hitting_later = -1;
    for (int k = 0; k < track_.points(); ++k) {
      if (track_.height(k, i) > track_.touch()) continue;
      double approach = -track_.vertical_speed(k, pose, velocity, 0.0);
      if (approach <= speed) continue;
      // One that touched at the last sample too may roll, which turns the momentum faster than means over
      // intervals tell; its height then tells more.
      if (!track_.beside_lowest(k) && stays(k, i)) approach = std::min(approach, sinking(k, i));
      if (approach <= speed) continue;
      // still moving down as before: the impact comes later
      if (!last && track_.height(k, i, i + 1) - track_.height(k, i) < -0.5 * approach * track_.step(i))
        continue;
      if (lands_later(k, i)) {
        if (approach <= later_speed) continue;
        later_speed = approach;
        hitting_later = k;
        continue;
      }
      speed = approach;
      hitting = k;
    }
    if (hitting < 0) {
      hitting = hitting_later;
      speed = later_speed;
    }
    if (hitting < 0) return false;
    push(track_.time(i), speed, pose, hitting, i, true);
    return true;
  }

  // Whether the point touches at sample i and at the one before.
  bool stays(int k, int i) const {
    return track_.height(k, i) <= track_.touch() && track_.height(k, i - 1) <= track_.touch();
  }

  // How fast the point comes down just before sample i, by a parabola through its heights.
  double sinking(int k, int i) const {
    const double h1 = track_.step(i - 1), d1 = (track_.height(k, i - 1) - track_.height(k, i)) / h1;
    if (i - 2 < first_) return d1;
    const double h2 = track_.step(i - 2), d2 = (track_.height(k, i - 2) - track_.height(k, i - 1)) / h2;
    return d1 + (d1 - d2) * h1 / (h1 + h2);
  }

  // Above the lowest point and on its way down to the ground: the impact of another point only slowed it.
  bool lands_later(int k, int i) const {
    const double height = track_.height(k, i);
    if (height - track_.lowest(i) <= kHeightError) return false;
    for (int j = i + 1; j < track_.size(); ++j) {
      const double change = track_.height(k, i, j) - height;
      if (std::abs(change) > kHeightError) return change < 0.0;
    }
    return false;
  }

  // In interval i, from i to i + 1.
  bool between(int i) {
    const double step = track_.step(i);
    const double reach =
        1.5 * track_.speed_bound(i - 1) * step + kContactAcceleration * step * step + track_.touch();
    if (track_.lowest(i) > reach) return false;
    const Velocity velocity = track_.before(i, first_);
    const Pose next = track_.extrapolate(i, velocity, step);
    const bool flying = track_.lowest(i) > track_.touch() && track_.lowest(i - 1) > track_.touch() &&
                        (i - 2 <= first_ || track_.lowest(i - 2) > track_.touch());
    const double error = kFlightError + (flying ? 0.0 : kContactAcceleration * step * step);
    std::vector<int> through;
    for (int k = 0; k < track_.points(); ++k) {
      if (stays(k, i) && sinking(k, i) < kSlowestInContact) continue;
      const double expected = track_.height(k, next);
      if (expected < -error && track_.height(k, i + 1) > expected + error && track_.height(k, i) > -error)
        through.push_back(k);
    }
    if (through.empty()) return false;
    const auto clearance = [&](double s) {
      const Pose pose = track_.extrapolate(i, velocity, s);
      double lowest = track_.height(through.front(), pose);
      for (const int k : through) lowest = std::min(lowest, track_.height(k, pose));
      return lowest;
    };
    const double root = clearance(0.0) > 0.0 ? bisect(clearance, step) : 0.0;
    const Pose pose = track_.extrapolate(i, velocity, root);
    double speed = flying ? kSlowestInFlight : kSlowestInContact;
    int hitting = -1;
    for (const int k : through) {
      if (track_.height(k, pose) > track_.touch()) continue;
      const double approach = -track_.vertical_speed(k, pose, velocity, root);
      if (approach > speed) {
        speed = approach;
        hitting = k;
      }
    }
    if (hitting < 0) return false;
    push(track_.time(i) + root, speed, pose, hitting, i, false);
    meetings_.push_back({i, velocity, hitting, impacts_.list.size() - 1});
    return true;
  }

  // How deep the point is where the paths before and after meet; `last` is the last sample after it that no
  // further impact separates from it.
  void meet(const Meeting& m, int last) {
    if (m.interval + 1 >= last) return;
    const double step = track_.step(m.interval);
    const Velocity after = track_.after(m.interval + 1, last);
    const auto gap = [&](double s) {
      return track_.height(m.point, track_.extrapolate(m.interval, m.before, s)) -
             track_.height(m.point, track_.extrapolate(m.interval + 1, after, s - step));
    };
    if (gap(0.0) <= 0.0 || gap(step) >= 0.0) return;
    const double s = bisect(gap, step);
    const double depth = -track_.height(m.point, track_.extrapolate(m.interval, m.before, s));
    if (depth > impacts_.deepest_m) {
      impacts_.deepest_m = depth;
      impacts_.deepest_time_s = track_.time(m.interval) + s;
    }
  }

  // The root of a function that is positive at 0 and negative at `high`.
  template <class Function>
  static double bisect(const Function& f, double high) {
    double low = 0.0;
    for (int n = 0; n < 45; ++n) {
      const double middle = 0.5 * (low + high);
      (f(middle) > 0.0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  void push(double time_s, double speed, const Pose& pose, int point, int sample, bool at_sample) {
    const Vec3 position = pose.position + track_.arm(point, pose.orientation);
    impacts_.list.push_back({time_s, speed, position, sample, at_sample});
  }

  const Track& track_;
  Impacts impacts_;
  std::vector<Meeting> meetings_;
  int first_ = 0;  // stencils reach no further back
};

}  // namespace

Impacts find_impacts(const Track& track) { return Finder(track).run(); }

}  // namespace ifa::verify
