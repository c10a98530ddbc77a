#include "ifa/rigid/flight.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ifa/rigid/lanes/scalar.hpp"
#include "ifa/rigid/views.hpp"

namespace ifa {

namespace one = lanes_scalar;

struct Flight::Impl {
  lanes::BodyView body;
  State start;
  Vec3 gravity = Vec3::Zero(), body_spin = Vec3::Zero();
  std::vector<one::RotationSeries> ahead, behind;

  const one::RotationSeries& piece_at(double time_s) {
    const double direction = time_s >= 0.0 ? 1.0 : -1.0;
    auto& pieces = time_s >= 0.0 ? ahead : behind;
    if (pieces.empty())
      pieces.emplace_back().expand(body, 0.0, one::pack(start.orientation), one::pack(body_spin), true);
    constexpr std::size_t kMostPieces = 4096;
    while (std::abs(time_s) > std::abs(pieces.back().start_s) + pieces.back().length_s) {
      const one::RotationSeries& last = pieces.back();
      const double end = last.start_s + direction * last.length_s;
      const auto values = last.at(end);
      one::RotationSeries next;
      next.expand(body, end, last.orientation(values), last.spin(values), true);
      if (pieces.size() == kMostPieces) pieces.erase(pieces.begin() + 1, pieces.end());
      pieces.push_back(next);
    }
    std::size_t i = pieces.size() - 1;
    while (i > 0 && std::abs(time_s) < std::abs(pieces[i].start_s)) --i;
    if (std::abs(time_s) >
        std::abs(pieces[i].start_s) + pieces[i].length_s) {  // in a gap: pieces were let go
      pieces.resize(1);
      return piece_at(time_s);
    }
    return pieces[i];
  }
};

Flight::Flight(const Body& body) : impl_(std::make_unique<Impl>()) { impl_->body = view_of(body); }
Flight::~Flight() = default;
Flight::Flight(Flight&&) noexcept = default;
Flight& Flight::operator=(Flight&&) noexcept = default;

void Flight::start(const State& state, const Vec3& gravity_m_s2) {
  impl_->start = state;
  impl_->gravity = gravity_m_s2;
  impl_->body_spin = state.orientation.conjugate() * state.angular_velocity;
  impl_->ahead.clear();
  impl_->behind.clear();
}

State Flight::at(double time_s) const {
  const State& start = impl_->start;
  State s;
  s.position = start.position + time_s * (start.velocity + 0.5 * time_s * impl_->gravity);
  s.velocity = start.velocity + time_s * impl_->gravity;
  if (!one::couples_spin(impl_->body)) {
    s.orientation = (rotation_exp(start.angular_velocity * time_s) * start.orientation).normalized();
    s.angular_velocity = start.angular_velocity;
    return s;
  }
  const one::RotationSeries& piece = impl_->piece_at(time_s);
  const auto values = piece.at(time_s);
  s.orientation = one::unpack(piece.orientation(values));
  s.angular_velocity = s.orientation * one::unpack(piece.spin(values));
  return s;
}

double Flight::clearance(double time_s) const {
  const State s = at(time_s);
  const one::Pack3 up = one::rotation(one::pack(s.orientation)).up();
  const one::Points points(impl_->body, up);
  double lowest = kNever;
  for (int i = 0; i < points.count(); ++i) lowest = std::min(lowest, one::dot(up, points.at(i)));
  return lowest - impl_->body.rounding + s.position.z();
}

double Flight::next_contact(double until_s) const {
  State from = impl_->start;
  for (double begin = 0.0;;) {
    one::FlightPath path(impl_->body, one::pack(impl_->gravity), one::pack(from), true);
    const auto contact = path.next_contact(until_s - begin, true);
    if (contact.landed) return begin + contact.time_s;
    if (!(begin + contact.time_s <= until_s) || contact.time_s >= 1e100) return kNever;
    begin += contact.time_s;
    from = at(begin);
  }
}

}  // namespace ifa
