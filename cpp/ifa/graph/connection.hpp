// Motion connections: flights from one pose to another (paper section 5.3.2).
#pragma once

#include "ifa/graph/shooting.hpp"
#include "ifa/rigid/body.hpp"
#include "ifa/rigid/state.hpp"

namespace ifa {

struct Connection {
  State start;        // the pose it begins at, with the velocities that lead to its end
  Shooting shooting;  // of its rotation; the position is a closed form
  bool converged() const { return shooting.outcome == Shot::converged; }
};

const char* why(Shot outcome);  // a clause, for messages: "the flight ..."

// Makes connections of one body. Principal axes throughout. Nothing is allocated, and one connector may serve
// several threads. The body must outlive it.
class Connector {
 public:
  explicit Connector(const Body& body);

  // The flight from the pose of `from` to that of `to` in `duration_s` > 0, to within `tolerance_rad`. Its
  // spin is the one near the average, in the body's axes, of those of `from` and `like`, the take-off whose
  // flight led to `to`: in world axes, as the paper has it, a momentum along a thin body's axis would seem to
  // be one across it.
  Connection connect(const State& from, const State& like, const State& to, double duration_s,
                     const Vec3& gravity_m_s2, double tolerance_rad = kShootingTolerance_rad) const;

  // Whether some point of the hull is below the ground by more than `tolerance_m` > 0 at any time of the
  // flight from `start`, its ends included. Exact: no point can dip unseen. A point that goes down at once,
  // or comes up at the end, is seen where it is that deep.
  bool penetrates(const State& start, double duration_s, const Vec3& gravity_m_s2, double tolerance_m) const;

 private:
  const Body& body_;
  lanes::BodyView view_;
};

}  // namespace ifa
