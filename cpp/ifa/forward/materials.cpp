#include "ifa/forward/materials.hpp"

#include <cmath>

namespace ifa {

std::vector<Material> materials_to_try(const Body& body, const Marks&, bool fit) {
  std::vector<Material> materials{body.material()};
  if (!fit) return materials;
  for (const double restitution : {0.6, 0.45, 0.3, 0.75}) {
    if (std::abs(restitution - body.material().restitution) < 0.05) continue;
    Material material = body.material();
    material.restitution = restitution;
    materials.push_back(material);
  }
  return materials;
}

}  // namespace ifa
