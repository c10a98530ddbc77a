#include "ifa/graph/transplant.hpp"

#include <cmath>

namespace ifa {

State Transplant::of(const State& s) const {
  State out = image(element, s);
  out.position = shift + turn * out.position;
  out.orientation = turn * out.orientation;
  out.velocity = turn * out.velocity;
  out.angular_velocity = turn * out.angular_velocity;
  return out;
}

Transplant Transplant::after(const Transplant& inner) const {
  Transplant both;
  both.element = {element.map * inner.element.map, element.proper == inner.element.proper};
  Quat turned = inner.turn;
  Vec3 shifted = inner.shift;
  if (!element.proper) {  // seen in the mirror y -> -y
    turned = turned.conjugate();
    shifted.y() = -shifted.y();
  }
  both.turn = turn * turned;
  both.shift = shift + turn * shifted;
  return both;
}

Transplant registration(const State& from, const State& to) {
  Transplant p;
  // Of turns about z the nearest to R: that of the quaternion's w and z, alone (the trace of R Rz^-1 is
  // most).
  const Quat r = to.orientation * from.orientation.conjugate();
  const double size = std::hypot(r.w(), r.z());
  if (size > 0.0) p.turn = Quat(r.w() / size, 0.0, 0.0, r.z() / size);
  p.shift = to.position - p.turn * from.position;
  p.shift.z() = 0.0;
  return p;
}

}  // namespace ifa
