#include "ifa/rigid/views.hpp"

#include <algorithm>

#include "ifa/base/effects.hpp"
#include "ifa/base/error.hpp"

namespace ifa {

static_assert(sizeof(Vec3) == 3 * sizeof(double));  // an array of Vec3 is one of doubles
static_assert(kMostRings == lanes::kMostRings);

lanes::BodyView view_of(const Body& body) {
  if (!compiled(Effect::spin_coupling) && body.couples_spin())
    throw ArgumentError("spin_coupling: this build has none");
  if (!compiled(Effect::circular_edges) && !body.rings().empty())
    throw ArgumentError("rings_m: this build has no circular edges");
  lanes::BodyView view;
  view.vertex = body.principal_vertices().empty() ? nullptr : body.principal_vertices().front().data();
  view.vertices = static_cast<int>(body.principal_vertices().size());
  for (const Ring& ring : body.principal_rings()) {
    lanes::Ring& out = view.ring[view.rings++];
    const Vec3 side = ring.axis.unitOrthogonal();
    std::copy_n(ring.centre_m.data(), 3, out.centre);
    std::copy_n(ring.axis.data(), 3, out.axis);
    std::copy_n(side.data(), 3, out.side);
    out.radius = ring.radius_m;
  }
  view.rounding = body.radius_m();
  view.bounding_radius = body.bounding_radius_m();
  view.mass = body.mass_kg();
  for (int i = 0; i < 3; ++i) view.inertia[i] = body.principal_inertia()[body.isotropic() ? 0 : i];
  view.isotropic = body.isotropic();
  view.centred = view.vertices == 1 && view.rings == 0 && body.principal_vertices().front().isZero(0.0);
  view.couples_spin = body.couples_spin();
  view.cone = body.has_cone();
  const Material material = body.contact_material();
  view.restitution = material.restitution;
  view.friction = material.friction;
  view.rolling_friction_m = material.rolling_friction_m;
  view.spin_friction_m = material.spin_friction_m;
  return view;
}

lanes::Settings settings_of(const Body& body, const SimulationOptions& options) {
  lanes::Settings settings;
  for (int i = 0; i < 3; ++i) settings.gravity[i] = options.gravity_m_s2[i];
  settings.step_s = options.step_s;
  settings.micro_speed = options.micro_speed_m_s;
  settings.rest_speed = options.rest_speed_m_s;
  settings.rest_duration_s = options.rest_duration_s;
  settings.sustained_contact = compiled(Effect::sustained_contact) && options.sustained_contact;
  // The slowest bounce leaves at restitution times the micro speed; the floor is above rounding.
  settings.step_speed = options.gravity_m_s2.norm() * options.step_s;
  settings.least_bounce =
      std::max(1e-4 * settings.step_speed, 0.999 * body.material().restitution * options.micro_speed_m_s);
  return settings;
}

lanes::Sim begin_sim(const lanes::BodyView& body, const lanes::Settings& settings, const State& state,
                     double time_s) {
  lanes::Sim sim{};
  const Quat& q = state.orientation;
  const double orientation[4] = {q.w(), q.x(), q.y(), q.z()};
  std::copy_n(state.position.data(), 3, sim.position);
  std::copy_n(orientation, 4, sim.orientation);
  std::copy_n(state.velocity.data(), 3, sim.velocity);
  std::copy_n(state.angular_velocity.data(), 3, sim.spin);
  sim.time_s = time_s;
  sim.stage = lanes::kScalarKernels.separation_speed(body, sim) < settings.least_bounce
                  ? lanes::Stage::contact
                  : lanes::Stage::flight;
  return sim;
}

State state_of(const lanes::Sim& sim) {
  State state;
  state.position = Eigen::Map<const Vec3>(sim.position);
  state.orientation = Quat(sim.orientation[0], sim.orientation[1], sim.orientation[2], sim.orientation[3]);
  state.velocity = Eigen::Map<const Vec3>(sim.velocity);
  state.angular_velocity = Eigen::Map<const Vec3>(sim.spin);
  return state;
}

}  // namespace ifa
