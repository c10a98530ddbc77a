// The kernels' parts for one simulation at a time, for the classes that show them one by one.
#pragma once

#define IFA_LANES_NAMESPACE lanes_scalar
#define IFA_LANES_WIDTH 1
#include "ifa/rigid/lanes/flight.hpp"
#include "ifa/rigid/lanes/step.hpp"

#include "ifa/base/linear_algebra.hpp"
#include "ifa/rigid/state.hpp"

namespace ifa::lanes_scalar {

inline Pack3 pack(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Quaternion pack(const Quat& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline Motion pack(const State& s) {
  return {pack(s.position), pack(s.orientation), pack(s.velocity), pack(s.angular_velocity)};
}
inline Vec3 unpack(const Pack3& p) { return {p.x, p.y, p.z}; }
inline Quat unpack(const Quaternion& q) { return {q.w, q.x, q.y, q.z}; }

}  // namespace ifa::lanes_scalar
