// Which materials a fit chooses from.
#pragma once

#include <vector>

#include "ifa/rigid/body.hpp"
#include "ifa/signature/marks.hpp"

namespace ifa {

// The body's own, and with `fit` others around what the gaps between the marks suggest.
std::vector<Material> materials_to_try(const Body& body, const Marks& marks, bool fit);

}  // namespace ifa
