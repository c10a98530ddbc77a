#include "ifa/forward/materials.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/base/counted.hpp"

#include "ifa/forward/estimate.hpp"

namespace ifa {
namespace {

bool alike(const Material& a, const Material& b) {
  constexpr double kRestitution = 0.04, kFriction = 0.05;
  return std::abs(a.restitution - b.restitution) < kRestitution &&
         std::abs(a.friction - b.friction) < kFriction;
}

}  // namespace

std::vector<Material> materials_to_try(const Body& body, const Marks& marks, bool fit) {
  std::vector<Material> materials{body.material()};
  if (!fit) return materials;
  count_run(Effect::material_fit);
  const auto add = [&](double restitution, double friction) {
    Material material = body.material();
    material.restitution = restitution;
    material.friction = friction;
    count_run(Effect::material_fit);
    if (std::ranges::none_of(materials, [&](const Material& m) { return alike(m, material); }))
      materials.push_back(material);
  };
  const Estimate said = estimate(body, marks);
  const Material given = body.material();
  if (said.ball) {  // its gaps give the restitution exactly, or say nothing of it
    if (said.restitution_from_gaps)
      materials.push_back(
          {said.restitution, given.friction, given.rolling_friction_m, given.spin_friction_m});
    return materials;
  }
  if (said.restitution_from_gaps) add(said.restitution, given.friction);
  // Restitution above all, over what hard bodies on hard ground have; friction hardly shows in when hits
  // come.
  for (const double e : {0.3, 0.45, 0.6, 0.75}) add(e, given.friction);
  for (const double factor : {0.5, 2.0}) add(given.restitution, factor * given.friction);
  return materials;
}

}  // namespace ifa
