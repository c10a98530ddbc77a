#include "bindings.hpp"

PYBIND11_MODULE(_core, m) {
  m.doc() = "The C++ core of ifa. Use the documented package `ifa` instead.";
  m.attr("__version__") = IFA_VERSION;
  ifa::bindings::bind_base(m);
  ifa::bindings::bind_sound(m);
  ifa::bindings::bind_rigid(m);
  ifa::bindings::bind_batch(m);
  ifa::bindings::bind_signature(m);
  ifa::bindings::bind_motion(m);
  ifa::bindings::bind_solution(m);
  ifa::bindings::bind_forward(m);
  ifa::bindings::bind_explain(m);
  ifa::bindings::bind_graph(m);
  ifa::bindings::bind_verify(m);
}
