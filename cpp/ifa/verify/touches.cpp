#include "ifa/verify/touches.hpp"

#include <algorithm>

namespace ifa::verify {
namespace {

constexpr double kLeastForce = 0.05;  // of the weight; differences over 1 ms in single precision: 0.03

// Where the mass centre's acceleration is gravity's, as shown by the transition before or after an event that
// may be here.
bool falls_freely(const Track& track, int i, const Options& options, const RetimeAt& retime_at) {
  const double h1 = track.step(i - 1), h2 = track.step(i);
  const Vec3 change =
      (track.position(i + 1) - track.position(i)) / h2 - (track.position(i) - track.position(i - 1)) / h1;
  const Vec3 acceleration = 2.0 / (h1 + h2) * change;
  for (const double aside : {-options.time_tolerance_s, options.time_tolerance_s}) {
    const double retime = retime_at(track.time(i) + aside), shown = options.gravity_m_s2 / (retime * retime);
    if ((acceleration + shown * kUp).norm() < kLeastForce * shown) return true;
  }
  return false;
}

}  // namespace

std::vector<Touch> find_touches(const Track& track, const Impacts& impacts, const Options& options,
                                const RetimeAt& retime_at, double rest_s) {
  std::vector<Touch> touches;
  std::vector<char> impact_at(track.size(), 0);
  for (std::size_t k = 0; k < impacts.list.size(); ++k) {
    const double time_s = impacts.list[k].time_s;
    if (impacts.list[k].at_sample) impact_at[impacts.list[k].sample] = 1;
    touches.push_back({time_s, time_s, time_s, true, static_cast<int>(k)});
  }
  const int last = track.size() - 1;
  bool joins = false;  // the run that was added last
  for (int i = 0; i <= last; ++i) {
    if (track.lowest(i) > track.touch()) {
      joins = false;
      continue;
    }
    const bool inside = i > 0 && i < last;
    const bool certain = !inside || !(impacts.kinked[i - 1] || impacts.kinked[i] ||
                                      falls_freely(track, i, options, retime_at));
    if (!joins || touches.back().certain != certain)
      touches.push_back({track.time(i), 0.0, 0.0, certain, -1});
    joins = true;
    touches.back().end_s = track.time(i);
    touches.back().latest_end_s = track.time(impact_at[i] ? i : std::min(i + 1, last));
  }
  std::erase_if(touches, [&](const Touch& t) { return t.begin_s > rest_s; });
  for (Touch& t : touches) {
    t.end_s = std::min(t.end_s, rest_s);
    t.latest_end_s = std::min(t.latest_end_s, rest_s);
  }
  std::stable_sort(touches.begin(), touches.end(),
                   [](const Touch& a, const Touch& b) { return a.begin_s < b.begin_s; });
  return touches;
}

}  // namespace ifa::verify
