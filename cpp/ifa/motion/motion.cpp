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

// Cubic through both positions with both velocities, and the shortest rotation.
State between(const Node& a, const Node& b, double t) {
  const double length = b.time_s - a.time_s, u = (t - a.time_s) / length;
  const double u2 = u * u, u3 = u2 * u;
  State s;
  s.position = (2 * u3 - 3 * u2 + 1) * a.state.position + (u3 - 2 * u2 + u) * length * a.state.velocity +
               (3 * u2 - 2 * u3) * b.state.position + (u3 - u2) * length * b.state.velocity;
  s.velocity = (6 * u2 - 6 * u) / length * (a.state.position - b.state.position) +
               (3 * u2 - 4 * u + 1) * a.state.velocity + (3 * u2 - 2 * u) * b.state.velocity;
  s.orientation = a.state.orientation.slerp(u, b.state.orientation);
  s.angular_velocity = (1 - u) * a.state.angular_velocity + u * b.state.angular_velocity;
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
          s = between(a, b, t);
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
  std::vector<double> breaks{start_s()};
  for (const Hit& h : hits()) breaks.push_back(h.time_s);
  for (const double t : time_.motion_s) breaks.push_back(t);
  breaks.push_back(end_s());
  std::sort(breaks.begin(), breaks.end());
  std::vector<double> times{start_s()};
  for (const double end : breaks) {
    const double begin = times.back();
    if (end <= begin || end > end_s()) continue;
    constexpr int kLeastSteps = 5;
    const int steps =
        std::max(kLeastSteps, static_cast<int>(std::ceil((end - begin) * rate_hz * (1.0 + 1e-9))));
    for (int i = 1; i < steps; ++i) {
      const double t = begin + (end - begin) * i / steps;
      if (t > times.back() && t < end) times.push_back(t);
    }
    times.push_back(end);
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
