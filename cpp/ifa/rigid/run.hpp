// What a simulation yields.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "ifa/rigid/state.hpp"

namespace ifa {

inline constexpr double kNever = std::numeric_limits<double>::infinity();  // a time

enum class Phase : std::uint8_t { flight, contact, rest };

// The motion at an instant, and how it goes on from there to the next node. An impact is two nodes at one
// time.
struct Node {
  double time_s;
  State state;
  Phase phase;
};

// One impact instant, audible or not.
struct Hit {
  double time_s = 0.0;
  Vec3 impulse_n_s = Vec3::Zero();  // sum over the touching points, on the body
  double approach_speed_m_s = 0.0;  // the largest over the touching points
  Vec3 position_m = Vec3::Zero();   // centre of the normal impulses
};

// One step of sustained contact: what it would sound like.
struct Load {
  double time_s, length_s;
  double impulse_n_s;     // normal
  double slip_speed_m_s;  // the largest over the loaded points
};

// `failed`: the engine gave up, and what it has until then is kept. `contact`: sustained contact began, and
// is off.
enum class RunStatus { rest, time_limit, impact_limit, failed, contact };

struct Run {
  RunStatus status = RunStatus::time_limit;
  double rest_s = 0.0;  // where status is rest: when it began
  std::vector<Node> nodes;
  std::vector<Hit> hits;
};

}  // namespace ifa
