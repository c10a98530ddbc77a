// Which materials a fit chooses from.
#pragma once

#include <vector>

#include "ifa/rigid/body.hpp"
#include "ifa/signature/marks.hpp"

namespace ifa {

// The body's own, and with `fit` what the gaps between the marks suggest: exact for a ball, which then needs
// no others; for other bodies a hint, beside which a few restitutions and frictions are tried.
std::vector<Material> materials_to_try(const Body& body, const Marks& marks, bool fit);

}  // namespace ifa
