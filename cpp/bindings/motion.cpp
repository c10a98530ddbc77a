// Motions, and random states.
#include "ifa/motion/motion.hpp"

#include <cmath>

#include "bindings.hpp"
#include "ifa/motion/difference.hpp"
#include "ifa/motion/sampling.hpp"
#include "states.hpp"

namespace ifa::bindings {

void bind_motion(py::module_& m) {
  py::class_<Motion, std::shared_ptr<Motion>>(m, "Motion", "A motion of the core; ifa.Motion wraps it.")
      .def_property_readonly("start_s", &Motion::start_s)
      .def_property_readonly("end_s", &Motion::end_s)
      .def("hits", [](const Motion& motion) { return from_hits(motion.hits()); })
      .def("dense_times", [](const Motion& motion) { return from_vector(motion.dense_times()); })
      .def(
          "sample",
          [](const Motion& motion, const Array& times_s, bool after) {
            const std::vector<double> times = to_vector(times_s, "times_s");
            for (const double t : times)
              if (!std::isfinite(t)) throw ArgumentError("times_s: must be finite");
            std::vector<State> states;
            {
              py::gil_scoped_release release;
              states = motion.sample(times, after ? Side::after : Side::before);
            }
            return from_states(states);
          },
          py::arg("times_s"), py::arg("after") = true,
          "positions (n, 3), quaternions wxyz (n, 4), velocities (n, 3), angular velocities (n, 3).")
      .def("difference", &difference, py::arg("other"), py::arg("from_s"), py::arg("to_s"),
           py::call_guard<py::gil_scoped_release>());

  m.def(
      "sample_states",
      [](const Body& body, std::size_t n, std::uint64_t seed, std::uint64_t first, double cone_rad,
         std::pair<double, double> speed_m_s, std::pair<double, double> spin_rad_s, int threads) {
        const SamplingOptions options{cone_rad, speed_m_s.first, speed_m_s.second, spin_rad_s.first,
                                      spin_rad_s.second};
        const auto work = [&](Progress* p) {
          std::vector<State> states(n);
          sample_states(body, options, seed, first, states, threads, p);
          for (State& s : states) s = to_body(body, s);
          return states;
        };
        return from_samples(run_interruptible<std::vector<State>>(nullptr, work));
      },
      py::arg("body"), py::arg("n"), py::kw_only(), py::arg("seed"), py::arg("first"), py::arg("cone_rad"),
      py::arg("speed_m_s"), py::arg("spin_rad_s"), py::arg("threads"));
}

}  // namespace ifa::bindings
