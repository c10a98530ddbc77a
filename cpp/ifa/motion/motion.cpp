#include "ifa/motion/motion.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/base/error.hpp"

namespace ifa {
namespace {

double map_linear(const std::vector<double>& from, const std::vector<double>& to, double t) {
  if (from.empty()) return t;
  if (t <= from.front()) return to.front() + (t - from.front());
  if (t >= from.back()) return to.back() + (t - from.back());
  const std::size_t i = std::upper_bound(from.begin(), from.end(), t) - from.begin();
  if (t == from[i - 1]) return to[i - 1];
  const double share = (t - from[i - 1]) / (from[i] - from[i - 1]);
  return to[i - 1] + share * (to[i] - to[i - 1]);
}

// Cubics through both positions and both orientations (as rotation vectors from the first) with both
// velocities: a contact step turns the body by 0.05 rad at most, over which these differ from the body's own
// by its cube. A body that settles moves by the velocity at the end of the step: a straight line. Elsewhere
// the way may differ a little from that of the mean velocity, by what puts the points back on the ground;
// the end's velocity must show all the same, since an impact may follow.
State between(const Node& a, const Node& b, double t, double radius_m) {
  const double length = b.time_s - a.time_s, u = (t - a.time_s) / length;
  const double u2 = u * u, u3 = u2 * u;
  Quat turn = b.state.orientation * a.state.orientation.conjugate();
  if (turn.w() < 0.0) turn.coeffs() *= -1.0;
  const Vec3 way = b.state.position - a.state.position, theta = rotation_log(turn);
  const Vec3 &v0 = a.state.velocity, &v1 = b.state.velocity;
  const Vec3 &w0 = a.state.angular_velocity, &w1 = b.state.angular_velocity;
  constexpr double kSettled = 0.25;  // of the change of velocity: 0 where a body settles, elsewhere about 0.5
  const auto speed2 = [&](const Vec3& v, const Vec3& w) {
    return v.squaredNorm() + radius_m * radius_m * w.squaredNorm();
  };
  const bool smooth =
      speed2(way / length - v1, theta / length - w1) >= kSettled * kSettled * speed2(v1 - v0, w1 - w0);
  const auto path = [&](const Vec3& change, const Vec3& first, const Vec3& last) {
    if (!smooth) return Vec3(u * change);
    return Vec3((3 * u2 - 2 * u3) * change + (u3 - 2 * u2 + u) * length * first + (u3 - u2) * length * last);
  };
  const auto rate = [&](const Vec3& change, const Vec3& first, const Vec3& last) {
    if (!smooth) return Vec3(change / length);
    return Vec3((6 * u - 6 * u2) / length * change + (3 * u2 - 4 * u + 1) * first + (3 * u2 - 2 * u) * last);
  };
  State s;
  s.position = a.state.position + path(way, v0, v1);
  s.velocity = rate(way, v0, v1);
  s.orientation = (rotation_exp(path(theta, w0, w1)) * a.state.orientation).normalized();
  s.angular_velocity = rate(theta, w0, w1);
  return s;
}

}  // namespace

double TimeMap::to_simulated(double t) const { return map_linear(motion_s, simulated_s, t); }
double TimeMap::to_motion(double t) const { return map_linear(simulated_s, motion_s, t); }

double TimeMap::rate(double t, bool after) const {
  if (motion_s.size() < 2) return 1.0;
  const auto place = after ? std::upper_bound(motion_s.begin(), motion_s.end(), t)
                           : std::lower_bound(motion_s.begin(), motion_s.end(), t);
  if (place == motion_s.begin() || place == motion_s.end()) return 1.0;
  const std::size_t i = place - motion_s.begin();
  return (simulated_s[i] - simulated_s[i - 1]) / (motion_s[i] - motion_s[i - 1]);
}

Motion::Motion(Body body, const Vec3& gravity_m_s2, std::vector<Node> nodes, std::vector<Hit> hits,
               TimeMap time)
    : body_(std::move(body)),
      gravity_(gravity_m_s2),
      nodes_(std::move(nodes)),
      hits_(std::move(hits)),
      time_(std::move(time)) {
  if (nodes_.empty()) throw ArgumentError("nodes: a motion needs at least one");
}

std::vector<Hit> Motion::hits() const {
  std::vector<Hit> hits = hits_;
  for (Hit& h : hits) h.time_s = time_.to_motion(h.time_s);
  return hits;
}

std::vector<State> Motion::sample(const std::vector<double>& times_s, Side side) const {
  std::vector<State> states;
  states.reserve(times_s.size());
  Flight flight(body_);
  const Node* in_flight = nullptr;
  const bool after = side == Side::after;
  for (const double motion_time : times_s) {
    const double t = time_.to_simulated(motion_time);
    State s;
    if (t < nodes_.front().time_s || t > nodes_.back().time_s) {
      s = (t < nodes_.front().time_s ? nodes_.front() : nodes_.back()).state;
      s.velocity.setZero();
      s.angular_velocity.setZero();
    } else {
      // `next` is the node that ends the interval of t; at an impact the side decides.
      const auto place = after ? std::upper_bound(nodes_.begin(), nodes_.end(), t,
                                                  [](double x, const Node& n) { return x < n.time_s; })
                               : std::lower_bound(nodes_.begin(), nodes_.end(), t,
                                                  [](const Node& n, double x) { return n.time_s < x; });
      if (place == nodes_.begin() || place == nodes_.end()) {
        s = (place == nodes_.begin() ? nodes_.front() : nodes_.back()).state;
      } else {
        const Node &a = *(place - 1), &b = *place;
        if (t == a.time_s || a.phase == Phase::rest) {
          s = a.state;
        } else if (t == b.time_s) {
          s = b.state;
        } else if (a.phase == Phase::flight) {
          if (in_flight != &a) {
            flight.start(a.state, gravity_);
            in_flight = &a;
          }
          s = flight.at(t - a.time_s);
        } else {
          s = between(a, b, t, body_.bounding_radius_m());
        }
      }
    }
    const double rate = time_.rate(motion_time, after);
    s.velocity *= rate;
    s.angular_velocity *= rate;
    s = to_body(body_, s);
    if (!states.empty() && states.back().orientation.dot(s.orientation) < 0.0) s.orientation.coeffs() *= -1.0;
    states.push_back(s);
  }
  return states;
}

std::vector<double> Motion::dense_times(double rate_hz) const {
  constexpr double kLeastSteps = 5.0;
  // Of a step at the given rate: steps of contact shorter than the first are followed, down to the second,
  // just below the shortest that follows a circular edge. What is shorter is a step that an impact cut.
  constexpr double kFollowed = 0.75, kFinest = 1.0 / 150.0;
  const auto steps_in = [](double steps) { return static_cast<int>(std::ceil(steps * (1.0 - 1e-9))); };
  std::vector<double> breaks{start_s()};
  for (const Hit& h : hits()) breaks.push_back(h.time_s);
  for (const double t : time_.motion_s) breaks.push_back(t);
  breaks.push_back(end_s());
  std::sort(breaks.begin(), breaks.end());
  std::vector<double> times{start_s()};
  std::size_t node = 0;
  for (const double end : breaks) {
    const double begin = times.back();
    if (end <= begin || end > end_s()) continue;
    const auto go_to = [&](double to) {
      const double from = times.back(), length = to - from;
      const int steps = steps_in(std::max(length * rate_hz, kLeastSteps * length / (end - begin)));
      for (int i = 1; i < steps; ++i) {
        const double t = from + length * i / steps;
        if (t > times.back() && t < to) times.push_back(t);
      }
      times.push_back(to);
    };
    for (; node + 1 < nodes_.size(); ++node) {
      const double t = time_.to_motion(nodes_[node].time_s);
      if (t >= end) break;
      if (nodes_[node].phase != Phase::contact) continue;
      const double step = time_.to_motion(nodes_[node + 1].time_s) - t;
      if (step * rate_hz < kFollowed && std::min(t - times.back(), end - t) * rate_hz >= kFinest) go_to(t);
    }
    go_to(end);
  }
  return times;
}

double Motion::max_penetration_m(const std::vector<double>& times_s) const {
  double deepest = 0.0;
  for (const State& s : sample(times_s)) {
    const Vec3 up = s.orientation.conjugate() * kUp;
    for (const Vec3& p : body_.vertices())
      deepest = std::max(deepest, body_.radius_m() - s.position.z() - up.dot(p));
    for (const Ring& ring : body_.rings())
      deepest = std::max(deepest, body_.radius_m() - s.position.z() + reach_m(ring, -up));
  }
  return deepest;
}

}  // namespace ifa
