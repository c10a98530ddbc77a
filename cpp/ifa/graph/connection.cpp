#include "ifa/graph/connection.hpp"

#include "ifa/rigid/lanes/scalar.hpp"
#include "ifa/rigid/views.hpp"

namespace ifa {

namespace one = lanes_scalar;

const char* why(Shot outcome) {
  switch (outcome) {
    case Shot::converged:
      return "the flight ends at the target";
    case Shot::fold:
      return "the flight's spin cannot be continued to the target: there is a fold before it";
    case Shot::too_fast:
      return "the flight would turn by more than 1,000 rad";
    case Shot::stalled:
      return "the flight's spin could not be followed to the target";
  }
  return "";
}

Connector::Connector(const Body& body) : body_(body), view_(view_of(body)) {}

Connection Connector::connect(const State& from, const State& like, const State& to, double duration_s,
                              const Vec3& gravity, double tolerance_rad) const {
  Connection c;
  c.start = from;
  c.start.velocity = (to.position - from.position) / duration_s - (0.5 * duration_s) * gravity;
  const Vec3 own = duration_s * (from.orientation.conjugate() * from.angular_velocity);
  const Vec3 other = duration_s * (like.orientation.conjugate() * like.angular_velocity);
  c.shooting =
      shoot(view_, from.orientation.conjugate() * to.orientation, 0.5 * (own + other), other, tolerance_rad);
  c.start.angular_velocity = from.orientation * (c.shooting.spin_rad / duration_s);
  return c;
}

bool Connector::penetrates(const State& start, double duration_s, const Vec3& gravity,
                           double tolerance_m) const {
  if (lowest_gap_m(body_, start) < -tolerance_m) return true;
  // Raised by the tolerance, a flight that is clear never comes down to the ground.
  State from = start;
  from.position.z() += tolerance_m;
  for (double left = duration_s;;) {
    one::FlightPath path(view_, one::pack(gravity), one::pack(from), true);
    const auto contact = path.next_contact(left, true);
    if (contact.landed) return true;
    if (contact.time_s > left) return false;
    const one::Motion reached = path.at(contact.time_s, true);  // it went as far as it goes at once
    from = {one::unpack(reached.position), one::unpack(reached.orientation), one::unpack(reached.velocity),
            one::unpack(reached.spin)};
    left -= contact.time_s;
  }
}

}  // namespace ifa
