// Flight of a pack of simulations of one body, and the instants at which it ends at the ground.
#pragma once

#include "ifa/rigid/lanes/points.hpp"
#include "ifa/rigid/lanes/rotation.hpp"

namespace ifa::IFA_LANES_NAMESPACE {

// From `start` on, time 0. The position is a parabola; the rotation a constant spin for a body that does not
// couple its spin (an isotropic one need not), else pieces of a series. Times may only be asked for in
// ascending order. `where`: those that are simulated.
class FlightPath {
 public:
  FlightPath(const BodyView& body, const Pack3& gravity, const Motion& start, Mask where);

  struct Up {
    Pack3 up, rate;
  };
  Up up_at(Pack time_s, Mask where);
  Motion at(Pack time_s, Mask where);

  Pack height(Pack t) const { return start_.position.z + t * (start_.velocity.z + 0.5 * t * gravity_.z); }
  Pack climb(Pack t) const { return start_.velocity.z + t * gravity_.z; }

  // An upper bound of |h''| of any point of the body over the whole flight.
  Pack curvature_bound() const;

  // The first instant in (0, limit] at which a point reaches the ground from above. `landed` is false where
  // there is none (the time is then beyond the limit) and where the search has gone as far as it goes at
  // once.
  struct Contact {
    Pack time_s;
    Mask landed;
  };
  Contact next_contact(Pack limit_s, Mask where);

 private:
  void reach(Pack time_s, Mask where);

  const BodyView& body_;
  Pack3 gravity_;
  Motion start_;
  Pack3 spin_;  // principal axes
  Pack speed_;
  Pack3 along_, across_, turned_, axis_;  // of the up vector, about a constant spin
  RotationSeries series_;
};

inline FlightPath::FlightPath(const BodyView& body, const Pack3& gravity, const Motion& start, Mask where)
    : body_(body), gravity_(gravity), start_(start) {
  const Rotation r = rotation(start.orientation);
  spin_ = r.inverse(start.spin);
  speed_ = norm(spin_);
  const Pack zero = broadcast(0.0);
  if (!couples_spin(body)) {
    axis_ = select(speed_ > zero, broadcast(1.0) / speed_, zero) * spin_;
    along_ = dot(axis_, r.up()) * axis_;
    across_ = r.up() - along_;
    turned_ = cross(r.up(), axis_);
  } else {
    series_.expand(body, zero, start.orientation, spin_, where);
  }
}

inline void FlightPath::reach(Pack time_s, Mask where) {
  for (;;) {
    const Mask beyond = where & (time_s > series_.start_s + series_.length_s);
    if (!any(beyond)) return;
    const Pack end = series_.start_s + series_.length_s;
    const RotationSeries::Values v = series_.at(end);
    RotationSeries next;
    next.expand(body_, end, series_.orientation(v), series_.spin(v), beyond);
    if constexpr (kWidth == 1) {
      series_ = next;
      continue;
    }
    series_.start_s = select(beyond, next.start_s, series_.start_s);
    series_.length_s = select(beyond, next.length_s, series_.length_s);
    series_.rate = select(beyond, next.rate, series_.rate);
    series_.start = select(beyond, next.start, series_.start);
    series_.up0 = select(beyond, next.up0, series_.up0);
    series_.l0 = select(beyond, next.l0, series_.l0);
    series_.gain = select(beyond, next.gain, series_.gain);
    for (int n = 0; n <= RotationSeries::kOrder; ++n) {
      series_.wx[n] = select(beyond, next.wx[n], series_.wx[n]);
      series_.wy[n] = select(beyond, next.wy[n], series_.wy[n]);
      series_.wz[n] = select(beyond, next.wz[n], series_.wz[n]);
      series_.psi[n] = select(beyond, next.psi[n], series_.psi[n]);
    }
  }
}

inline FlightPath::Up FlightPath::up_at(Pack time_s, Mask where) {
  if (!couples_spin(body_)) {  // Rodrigues: the up vector turns about the spin by -|w| t
    const SinCos turn = sin_cos(speed_ * time_s);
    return {along_ + turn.cosine * across_ + turn.sine * turned_,
            speed_ * (turn.cosine * turned_ - turn.sine * across_)};
  }
  reach(time_s, where);
  const RotationSeries::Values v = series_.at(time_s);
  const Pack3 up = series_.up(v);
  return {up, cross(up, series_.spin(v))};
}

inline Motion FlightPath::at(Pack time_s, Mask where) {
  Motion m;
  m.position = start_.position + time_s * (start_.velocity + (0.5 * time_s) * gravity_);
  m.velocity = start_.velocity + time_s * gravity_;
  if (!couples_spin(body_)) {
    const SinCos half = sin_cos(0.5 * (speed_ * time_s));
    m.orientation = normalized(start_.orientation * Quaternion{half.cosine, half.sine * axis_.x,
                                                               half.sine * axis_.y, half.sine * axis_.z});
    m.spin = start_.spin;
    return m;
  }
  reach(time_s, where);
  const RotationSeries::Values v = series_.at(time_s);
  m.orientation = series_.orientation(v);
  m.spin = rotation(m.orientation).apply(series_.spin(v));
  return m;
}

// |h''| <= |g_z| + r |d2(up)/dt2|. For a constant spin d2(up)/dt2 = (up x w) x w has the constant length
// |up x w| |w|; else |up' x w + up x w'| <= w^2 + |w'|, each component of w bounded by its largest value on
// the curve of constant energy and momentum (Landau and Lifshitz, Mechanics, section 37). These are written
// without differences of nearly equal numbers: a needle's moments may differ by 1e12.
inline Pack FlightPath::curvature_bound() const {
  const double r = body_.bounding_radius;
  const Pack fall = magnitude(gravity_.z);
  if (!couples_spin(body_)) return fall + r * (norm(across_) * speed_ * speed_);
  if (body_.isotropic) return fall + r * (speed_ * speed_);  // its series is of a constant spin
  const Pack never = broadcast(1e300);
  const Pack square[3] = {spin_.x * spin_.x, spin_.y * spin_.y, spin_.z * spin_.z};
  int least_axis = 0, most_axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (body_.inertia[k] < body_.inertia[least_axis]) least_axis = k;
    if (body_.inertia[k] >= body_.inertia[most_axis]) most_axis = k;
  }
  const int middle_axis = 3 - least_axis - most_axis;
  const double i1 = body_.inertia[least_axis], i2 = body_.inertia[middle_axis], i3 = body_.inertia[most_axis];
  const Pack w1 = square[least_axis], w2 = square[middle_axis], w3 = square[most_axis];
  const Pack most1 = root(w1 + w2 * (i2 * (i3 - i2) / (i1 * (i3 - i1))));
  const Pack most3 = root(w3 + w2 * (i2 * (i2 - i1) / (i3 * (i3 - i1))));
  const Pack by1 = i3 > i2 ? w1 * (i1 * (i3 - i1) / (i2 * (i3 - i2))) : never;
  const Pack by3 = i2 > i1 ? w3 * (i3 * (i3 - i1) / (i2 * (i2 - i1))) : never;
  const Pack most2 = root(w2 + least(by1, by3));
  const Pack3 rate{((i3 - i2) / i1) * most2 * most3, ((i3 - i1) / i2) * most3 * most1,
                   ((i2 - i1) / i3) * most1 * most2};
  return fall + r * (most1 * most1 + most2 * most2 + most3 * most3 + norm(rate));
}

// Conservative advancement: from a time t every point stays above h + h' s - A s^2 / 2, so no root is stepped
// over, and near a root the step is Newton's. A circular edge is the lower envelope of its points; with a and
// b the parts of the up vector and of its rate across the axis, and |a + s b| <= |a| + s a.b / |a| + s^2 b^2
// / (2 |a|) or, near its flat pose, |a| + s |b|, it has bounds of the same form.
inline FlightPath::Contact FlightPath::next_contact(Pack limit_s, Mask where) {
  constexpr int kMostAdvances = 10000;
  const Pack zero = broadcast(0.0), never = broadcast(1e100);
  const Pack bound = greatest(curvature_bound(), broadcast(1e-290));
  const double size = body_.bounding_radius;
  if (rings(body_) > 0) count(Effect::circular_edges, where);
  if (body_.rounding > 0.0) count(Effect::rounding, where);
  // What cannot be told from touching: rounding of the heights. And the step off a grazed ground, in which no
  // point comes down by more than 1e-16 of the size.
  const Pack floor = 1e-14 * (size + magnitude(start_.position.z));
  const Pack least_step = 1e-8 * root(size / bound);
  const Up unturned{broadcast(0.0, 0.0, 0.0), broadcast(0.0, 0.0, 0.0)};  // whose height no turn changes
  Pack t = zero;
  Mask open = where & (limit_s >= zero), found = none();
  // The step until a point at height h > 0 may touch, where that is before `step`.
  const auto shorten = [&](Pack& step, Pack h, Pack rate, Pack curvature) {
    const Mask sooner = h + step * (rate - (0.5 * curvature) * step) < zero;
    if (!any(sooner & open)) return;
    const Pack swing = root(rate * rate + 2.0 * curvature * h);
    const Pack s = select(rate >= zero, (rate + swing) / curvature, 2.0 * h / (swing - rate));
    step = select(sooner, least(s, step), step);
  };
  for (int i = 0; i < kMostAdvances && any(open); ++i) {
    const Up u = body_.centred ? unturned : up_at(t, open);
    const Pack z = height(t) - body_.rounding, climb_rate = climb(t);
    Pack step = never;
    Mask landed = none(), near = none();
    const auto arrive = [&](Pack h, Pack rate) {
      const Mask falling = rate < zero;
      landed = landed | ((h <= floor) & falling);
      near = near | ((h <= 100.0 * floor) & falling);
    };
    for (int k = 0; k < body_.vertices; ++k) {
      const double* p = body_.vertex + 3 * k;
      const Pack h = positive(z + (u.up.x * p[0] + u.up.y * p[1] + u.up.z * p[2]));
      const Pack rate = climb_rate + (u.rate.x * p[0] + u.rate.y * p[1] + u.rate.z * p[2]);
      arrive(h, rate);
      shorten(step, h, rate, bound);
    }
    for (int k = 0; k < rings(body_); ++k) {
      const lanes::Ring& ring = body_.ring[k];
      const Pack3 axis = broadcast(ring.axis), centre = broadcast(ring.centre);
      const Pack3 a = u.up - dot(u.up, axis) * axis, b = u.rate - dot(u.rate, axis) * axis;
      const Pack across = norm(a), turning = norm(b);
      const Pack h = positive(z + dot(u.up, centre) - ring.radius * across);
      const Pack middle = climb_rate + dot(u.rate, centre);
      const Mask tilted = across > zero;
      const Pack inverse = select(tilted, broadcast(1.0) / across, zero);
      const Pack rate =
          select(tilted, middle - ring.radius * (dot(a, b) * inverse), middle - ring.radius * turning);
      arrive(h, rate);
      Pack flat_step = step, tilted_step = select(tilted, step, zero);
      shorten(flat_step, h, middle - ring.radius * turning, bound);
      shorten(tilted_step, h, rate, bound + ring.radius * turning * turning * inverse);
      step = greatest(flat_step, tilted_step);
    }
    // A step that time cannot resolve, just above the ground: the root is here.
    const Mask stuck = step <= 4e-16 * t;
    const Mask here = open & (landed | (stuck & near));
    found = found | here;
    open = open & negated(here);
    t = select(open, t + select(stuck, greatest(8e-16 * t, least_step), step), t);
    open = open & (t <= limit_s);
  }
  return {t, found};
}

}  // namespace ifa::IFA_LANES_NAMESPACE
