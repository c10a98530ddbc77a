#include "ifa/rigid/effects.hpp"

#include <optional>
#include <utility>

#include "ifa/base/error.hpp"
#include "ifa/rigid/hull.hpp"

namespace ifa {
namespace {

Body::Definition reshaped(Body::Definition d, const EngineEffects& effects) {
  if (!effects.circular_edges) {
    for (const Vec3& corner : ring_points(d.rings_m, kCornersOfRing)) d.vertices_m.push_back(corner);
    d.rings_m.clear();
  }
  if (!effects.rounding && d.radius_m > 0.0) {
    if (d.rings_m.empty() && convex_hull(d.vertices_m).flat)
      throw ArgumentError("rounding: cannot be off for a body that has no volume without it");
    d.radius_m = 0.0;
  }
  return d;
}

}  // namespace

EngineEffects needed_effects(const Body& body) {
  const Material& m = body.material();
  return {!body.isotropic(), m.friction > 0.0 || m.rolling_friction_m > 0.0 || m.spin_friction_m > 0.0,
          body.radius_m() > 0.0, !body.rings().empty()};
}

Body with_effects(const Body& body, const EngineEffects& effects) {
  const EngineEffects needed = needed_effects(body);
  std::optional<bool> spin_coupling, friction;
  if (effects.spin_coupling != needed.spin_coupling) spin_coupling = effects.spin_coupling;
  if (effects.friction != needed.friction) friction = effects.friction;
  const bool same_shape =
      (effects.rounding || !needed.rounding) && (effects.circular_edges || !needed.circular_edges);
  if (same_shape) return body.with_switches(spin_coupling, friction);
  return Body::make(reshaped(body.definition(), effects)).with_switches(spin_coupling, friction);
}

}  // namespace ifa
