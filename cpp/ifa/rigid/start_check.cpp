#include "ifa/rigid/start_check.hpp"

#include "ifa/base/message.hpp"

namespace ifa {

std::string unfit_start(const Body& body, const State& state) {
  constexpr double kRoom = 2e-6;  // of the body's size
  if (!(state.velocity.norm() <= kFastest_m_s))
    return "velocity_m_s: must not be faster than " + number(kFastest_m_s) + " m/s";
  if (!(state.angular_velocity.norm() <= kFastestSpin_rad_s))
    return "angular_velocity_rad_s: must not be faster than " + number(kFastestSpin_rad_s) + " rad/s";
  const double gap = lowest_gap_m(body, state);
  if (!(gap >= -kRoom * body.bounding_radius_m())) {
    char depth[32];
    std::snprintf(depth, sizeof depth, "%.3g", -gap);
    return std::string("position_m: the body begins ") + depth + " m below the ground";
  }
  return {};
}

}  // namespace ifa
