// The project's own engine="ode", behind the same interface as the peers, so that its time is that of the
// engine alone.
#include <algorithm>
#include <exception>
#include <utility>

#include "ifa/rigid/engine_ode.hpp"
#include "peer.hpp"

namespace {

ifa::Body make_body(const PeerBody& body) {
  ifa::Body::Definition definition;
  for (std::int64_t i = 0; i < body.vertex_count; ++i)
    definition.vertices_m.emplace_back(body.vertices_m + 3 * i);
  definition.radius_m = body.radius_m;
  definition.mass_kg = body.mass_kg;
  definition.inertia_kg_m2 = ifa::Vec3(body.inertia_kg_m2).asDiagonal();
  definition.material = {body.restitution, body.friction, 0.0, 0.0};
  return ifa::Body::make(std::move(definition));
}

ifa::State make_state(const double* row) {
  ifa::State state;
  state.position = ifa::Vec3(row);
  state.orientation = ifa::Quat(row[3], row[4], row[5], row[6]);
  state.velocity = ifa::Vec3(row + 7);
  state.angular_velocity = ifa::Vec3(row + 10);
  return state;
}

void write(const ifa::Node& node, double* row) {
  const ifa::State& s = node.state;
  *row++ = node.time_s;
  for (int i = 0; i < 3; ++i) *row++ = s.position[i];
  for (const double c : {s.orientation.w(), s.orientation.x(), s.orientation.y(), s.orientation.z()})
    *row++ = c;
  for (int i = 0; i < 3; ++i) *row++ = s.velocity[i];
  for (int i = 0; i < 3; ++i) *row++ = s.angular_velocity[i];
}

}  // namespace

const char* peer_version() { return "ODE (dWorldStep), double precision"; }

std::int64_t peer_run(const PeerBody* given, const PeerOptions* options, std::int64_t n, const double* states,
                      PeerEnd* ends, double* trace, std::int64_t room) try {
  const ifa::Body body = make_body(*given);
  ifa::OdeOptions ode;
  ode.gravity_m_s2 = {0.0, 0.0, -options->gravity_m_s2};
  ode.step_s = options->step_s;
  ode.skip_flight = options->skip_flight != 0;
  ode.micro_speed_m_s = options->micro_speed_m_s;
  ode.rest_speed_m_s = options->rest_speed_m_s;
  ode.rest_duration_s = options->rest_span_s;
  std::int64_t rows = 0;
  for (std::int64_t i = 0; i < n; ++i) {
    const ifa::Run run = ifa::simulate_ode(body, make_state(states + kStateWidth * i), ode, options->until_s);
    ends[i] = run.status == ifa::RunStatus::rest     ? peer_at_rest
              : run.status == ifa::RunStatus::failed ? peer_failed
                                                     : peer_moving;
    if (!trace) continue;
    rows = static_cast<std::int64_t>(run.nodes.size());
    for (std::int64_t k = 0; k < std::min(rows, room); ++k) write(run.nodes[k], trace + kTraceWidth * k);
  }
  return rows;
} catch (const std::exception&) {  // nothing may pass a C interface
  return -1;
}
