// The C interface between native.py and an engine's library, the same for each engine: `peer_version` and
// `peer_run`.
#pragma once

#include <cstdint>

extern "C" {

struct PeerBody {
  const double* vertices_m;  // (vertex_count, 3) about the centre of mass, principal axes
  std::int64_t vertex_count;
  double radius_m, mass_kg;
  double inertia_kg_m2[3];
  double restitution, friction;
};

struct PeerOptions {
  double step_s, until_s, gravity_m_s2, micro_speed_m_s;
  double rest_speed_m_s, rest_span_s;
  std::int64_t skip_flight;  // where the engine has a choice
};

enum PeerEnd : std::int8_t { peer_moving = 0, peer_at_rest = 1, peer_failed = 2 };

// Where a motion goes, row by row: time, position, quaternion w x y z, velocity, angular velocity.
inline constexpr int kStateWidth = 13, kTraceWidth = 14;

#define IFA_PEER __attribute__((visibility("default")))

IFA_PEER const char* peer_version();

// Runs from each of `states` (n, 13), in principal axes, to rest or to the limit; `ends` (n) says which.
// `trace`, for n = 1, has `room` rows; returns how many there are (more than `room`: the rest are not
// written), without `trace` 0, and -1 where the engine does not take the body.
IFA_PEER std::int64_t peer_run(const PeerBody* body, const PeerOptions* options, std::int64_t n,
                               const double* states, PeerEnd* ends, double* trace, std::int64_t room);
}
