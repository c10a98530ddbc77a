// A motion in time: simulated nodes, exact between them, seen through a piecewise linear change of time.
#pragma once

#include <vector>

#include "ifa/rigid/event_engine.hpp"
#include "ifa/rigid/run.hpp"

namespace ifa {

// Simulated time against motion time, linear between knots and of slope 1 outside them. Both increase
// strictly.
struct TimeMap {
  std::vector<double> simulated_s, motion_s;

  double to_simulated(double motion_time_s) const;
  double to_motion(double simulated_time_s) const;
  // d simulated / d motion just after (or just before) a motion time: what velocities are multiplied by.
  double rate(double motion_time_s, bool after) const;
};

enum class Side { before, after };  // of an impact, where the velocities jump

// Poses between nodes: flight in closed form; sustained contact by a cubic through positions and velocities,
// and by the shortest rotation. Held still before the first node and after the last. Immutable; owns its
// body.
class Motion {
 public:
  // Nodes in principal axes and simulated time, hits in simulated time, both ordered in time.
  Motion(Body body, const Vec3& gravity_m_s2, std::vector<Node> nodes, std::vector<Hit> hits, TimeMap time);

  double start_s() const { return time_.to_motion(nodes_.front().time_s); }
  double end_s() const { return time_.to_motion(nodes_.back().time_s); }
  const Body& body() const { return body_; }
  const TimeMap& time() const { return time_; }
  const std::vector<Node>& nodes() const { return nodes_; }

  // Hits with their times in the motion and everything else as simulated (approach speeds before retiming).
  std::vector<Hit> hits() const;

  // In body axes and motion time; velocities are those that are seen, retiming included.
  std::vector<State> sample(const std::vector<double>& times_s, Side side = Side::after) const;

  // Times from start to end at `rate_hz` or denser, with every impact instant, and at least five steps
  // between two of them: enough to find the contacts again from the poses alone. Where sustained contact was
  // simulated in shorter steps (a coin that wobbles turns its velocity round within a millisecond), also at
  // these steps.
  std::vector<double> dense_times(double rate_hz = 1000.0) const;

  // How far below the ground a hull point is at the dense times, at most; 0 if none is.
  double max_penetration_m(const std::vector<double>& times_s) const;

 private:
  Body body_;
  Vec3 gravity_;
  std::vector<Node> nodes_;
  std::vector<Hit> hits_;
  TimeMap time_;
};

}  // namespace ifa
