// Motions of a pack of simulations, and the points with which bodies touch the ground.
#pragma once

#include "ifa/rigid/lanes/effects.hpp"

namespace ifa::IFA_LANES_NAMESPACE {

using lanes::kMostBearing;
using lanes::kMostRings;
using lanes::kMostSettling;
using lanes::kRingPoints;
using lanes::kSlots;
using lanes::Sim;

// Of the body's size: points this near to the ground touch it. Above the rounding of the flight's root and
// the projection's tolerance, far below anything visible.
inline constexpr double kTouchShare = 1e-8;

struct Motion {
  Pack3 position;
  Quaternion orientation;
  Pack3 velocity, spin;  // world axes
};

inline Motion select(Mask m, const Motion& a, const Motion& b) {
  return {select(m, a.position, b.position), select(m, a.orientation, b.orientation),
          select(m, a.velocity, b.velocity), select(m, a.spin, b.spin)};
}

// Lanes beyond `count` repeat the first simulation and are never written.
inline Motion load(Sim* const* sims, int count) {
  Motion m{};
  for (int l = 0; l < kWidth; ++l) {
    const Sim& s = *sims[l < count ? l : 0];
    set(m.position.x, l, s.position[0]), set(m.position.y, l, s.position[1]),
        set(m.position.z, l, s.position[2]);
    set(m.orientation.w, l, s.orientation[0]), set(m.orientation.x, l, s.orientation[1]),
        set(m.orientation.y, l, s.orientation[2]), set(m.orientation.z, l, s.orientation[3]);
    set(m.velocity.x, l, s.velocity[0]), set(m.velocity.y, l, s.velocity[1]),
        set(m.velocity.z, l, s.velocity[2]);
    set(m.spin.x, l, s.spin[0]), set(m.spin.y, l, s.spin[1]), set(m.spin.z, l, s.spin[2]);
  }
  return m;
}

inline void store(const Motion& m, Sim* const* sims, int count) {
  for (int l = 0; l < count; ++l) {
    Sim& s = *sims[l];
    s.position[0] = get(m.position.x, l), s.position[1] = get(m.position.y, l),
    s.position[2] = get(m.position.z, l);
    s.orientation[0] = get(m.orientation.w, l), s.orientation[1] = get(m.orientation.x, l),
    s.orientation[2] = get(m.orientation.y, l), s.orientation[3] = get(m.orientation.z, l);
    s.velocity[0] = get(m.velocity.x, l), s.velocity[1] = get(m.velocity.y, l),
    s.velocity[2] = get(m.velocity.z, l);
    s.spin[0] = get(m.spin.x, l), s.spin[1] = get(m.spin.y, l), s.spin[2] = get(m.spin.z, l);
  }
}

inline Mask first_lanes(int count) {
  Mask m = none();
  for (int l = 0; l < kWidth; ++l) set(m, l, l < count);
  return m;
}

// The points of a body that may touch: its vertices, and for each circular edge the lowest point and seven
// more around it, which stay with the body from then on.
class Points {
 public:
  Points(const BodyView& body, const Pack3& up) : body_(body) { place_rings(up); }

  int count() const { return body_.vertices + kRingPoints * rings(body_); }

  Pack3 at(int point) const {
    if (is_vertex(point)) return broadcast(body_.vertex + 3 * point);
    return ring_point_[point - body_.vertices];
  }

  // Each lane its own point.
  Pack3 at(const int* point_of_lane) const {
    Pack3 p{};
    for (int l = 0; l < kWidth; ++l) {
      const int k = point_of_lane[l];
      if (is_vertex(k)) {
        const double* v = body_.vertex + 3 * k;
        set(p.x, l, v[0]), set(p.y, l, v[1]), set(p.z, l, v[2]);
      } else {
        const Pack3& r = ring_point_[k - body_.vertices];
        set(p.x, l, get(r.x, l)), set(p.y, l, get(r.y, l)), set(p.z, l, get(r.z, l));
      }
    }
    return p;
  }

  // Turns each circular edge's points so that its first is the lowest again.
  void place_rings(const Pack3& up);

 private:
  bool is_vertex(int point) const { return !compiled(Effect::circular_edges) || point < body_.vertices; }

  const BodyView& body_;
  Pack3 ring_point_[kMostRings * kRingPoints];
};

inline void Points::place_rings(const Pack3& up) {
  static constexpr double kHalfRoot = 0.70710678118654752440;
  static constexpr double kCosine[kRingPoints] = {1, kHalfRoot, 0, -kHalfRoot, -1, -kHalfRoot, 0, kHalfRoot};
  static constexpr double kSine[kRingPoints] = {0, kHalfRoot, 1, kHalfRoot, 0, -kHalfRoot, -1, -kHalfRoot};
  for (int k = 0; k < rings(body_); ++k) {
    const lanes::Ring& ring = body_.ring[k];
    const Pack3 axis = broadcast(ring.axis), centre = broadcast(ring.centre);
    const Pack3 tilt = dot(up, axis) * axis - up;
    const Pack across = norm(tilt);
    const Pack3 lowest = select(across > broadcast(1e-12), (1.0 / across) * tilt, broadcast(ring.side));
    const Pack3 side = cross(axis, lowest);
    for (int j = 0; j < kRingPoints; ++j)
      ring_point_[kRingPoints * k + j] =
          centre + broadcast(ring.radius * kCosine[j]) * lowest + broadcast(ring.radius * kSine[j]) * side;
  }
}

// For each lane a few of the points.
struct Bearing {
  int count[kWidth] = {};  // of them that touch
  int all[kWidth] = {};    // with those that may settle
  int point[kSlots][kWidth] = {};

  int most() const {
    int n = 0;
    for (int l = 0; l < kWidth; ++l) n = all[l] > n ? all[l] : n;
    return n;
  }
  Mask has(int slot) const {
    Mask m = none();
    for (int l = 0; l < kWidth; ++l) set(m, l, slot < all[l]);
    return m;
  }
  Mask touches(int slot) const {
    Mask m = none();
    for (int l = 0; l < kWidth; ++l) set(m, l, slot < count[l]);
    return m;
  }
};

// Of many points of one lane, those furthest out in eight directions (the others lie within their span) and,
// if it is wanted, the one that approaches fastest.
class Spread {
 public:
  void consider(int point, double x, double y, double approach) {
    constexpr double d = 0.70710678118654752440;
    const double reach[9] = {x, d * (x + y), y, d * (y - x), -x, -d * (x + y), -y, d * (x - y), approach};
    for (int k = 0; k < 9; ++k)
      if (!(reach[k] <= best_[k])) best_[k] = reach[k], chosen_[k] = point;
  }

  // In ascending order, each once; `most` is 8 or 9.
  int take(int* out, int most) const {
    int n = 0;
    for (int k = 0; k < most; ++k) {
      int place = n;
      bool known = false;
      for (int i = 0; i < n; ++i) known = known || out[i] == chosen_[k];
      if (known) continue;
      for (; place > 0 && out[place - 1] > chosen_[k]; --place) out[place] = out[place - 1];
      out[place] = chosen_[k];
      ++n;
    }
    return n;
  }

 private:
  double best_[9] = {-1e300, -1e300, -1e300, -1e300, -1e300, -1e300, -1e300, -1e300, -1e300};
  int chosen_[9] = {};
};

// The points that touch the ground at a motion's pose, all or a spread of them.
inline Bearing touching_points(const BodyView& body, const Points& points, const Motion& m, const Rotation& r,
                               Mask where) {
  Bearing bearing;
  if (rings(body) > 0) count(Effect::circular_edges, where);
  if (body.rounding > 0.0) count(Effect::rounding, where);
  const Pack3 up = r.up();
  const Pack z = m.position.z - body.rounding;
  const Pack touch = broadcast(kTouchShare * body.bounding_radius);
  bool crowded = false;
  for (int k = 0; k < points.count(); ++k) {
    for (unsigned b = bits(where & (z + dot(up, points.at(k)) <= touch)); b; b &= b - 1) {
      const int l = __builtin_ctz(b);
      if (bearing.count[l] < kMostBearing)
        bearing.point[bearing.count[l]++][l] = k;
      else
        crowded = true, bearing.all[l] = -1;
    }
  }
  for (int l = 0; l < kWidth; ++l) {
    if (bearing.all[l] == 0) bearing.all[l] = bearing.count[l];
  }
  if (!crowded) return bearing;
  Spread spread[kWidth];
  unsigned crowd = 0;
  for (int l = 0; l < kWidth; ++l) crowd |= bearing.all[l] < 0 ? 1u << l : 0u;
  for (int k = 0; k < points.count(); ++k) {
    const Pack3 p = points.at(k), arm = r.apply(p);
    const Pack approach = broadcast(0.0) - cross(m.spin, arm).z;
    for (unsigned b = crowd & bits(where & (z + dot(up, p) <= touch)); b; b &= b - 1) {
      const int l = __builtin_ctz(b);
      spread[l].consider(k, get(arm.x, l), get(arm.y, l), get(approach, l));
    }
  }
  for (unsigned b = crowd; b; b &= b - 1) {
    const int l = __builtin_ctz(b);
    int chosen[9];
    bearing.count[l] = bearing.all[l] = spread[l].take(chosen, 9);
    for (int i = 0; i < bearing.count[l]; ++i) bearing.point[i][l] = chosen[i];
  }
  return bearing;
}

// Normal velocity of a point, r its arm without the rounding, which has no share in it.
inline Pack normal_velocity(const Motion& m, const Pack3& arm) {
  return m.velocity.z + (m.spin.x * arm.y - m.spin.y * arm.x);
}

// The largest approach speed over the touching points, which may be negative: they separate; -1e100 where
// nothing touches.
inline Pack approach_speed(const BodyView& body, const Points& points, const Motion& m, const Rotation& r) {
  const Pack3 up = r.up();
  const Pack z = m.position.z - body.rounding;
  const Pack touch = broadcast(kTouchShare * body.bounding_radius);
  Pack fastest = broadcast(-1e100);
  for (int k = 0; k < points.count(); ++k) {
    const Pack3 p = points.at(k);
    const Mask touches = z + dot(up, p) <= touch;
    if (!any(touches)) continue;
    fastest = select(touches, greatest(fastest, -normal_velocity(m, r.apply(p))), fastest);
  }
  // A circular edge that lies flat approaches fastest somewhere between its points.
  for (int k = 0; k < rings(body); ++k) {
    const lanes::Ring& ring = body.ring[k];
    const Mask flat = z + dot(up, points.at(body.vertices + kRingPoints * k + kRingPoints / 2)) <= touch;
    if (!any(flat)) continue;
    const Pack3 axis = r.apply(broadcast(ring.axis)), centre = r.apply(broadcast(ring.centre));
    const Pack turning = norm(m.spin - dot(m.spin, axis) * axis);
    fastest = select(flat, greatest(fastest, ring.radius * turning - normal_velocity(m, centre)), fastest);
  }
  return fastest;
}

}  // namespace ifa::IFA_LANES_NAMESPACE
