#pragma once

#include "bindings.hpp"

namespace ifa::bindings {

void bind_connections(py::module_& m);  // with the graph

}  // namespace ifa::bindings
