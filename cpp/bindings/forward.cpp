// The forward search.
#include "ifa/forward/solve.hpp"

#include <optional>

#include "bindings.hpp"

namespace ifa::bindings {
namespace {

py::dict from_factors(const Factors& f) {
  py::dict d;
  d["velocity"] = f.velocity;
  d["orientation"] = f.orientation;
  d["time"] = f.time;
  d["amplitude"] = f.amplitude;
  d["length"] = f.length;
  d["centroid"] = f.centroid;
  return d;
}

py::dict from_solution(const Solution& s) {
  py::list events;
  for (const EventReport& e : s.events) {
    py::dict d;
    d["target_s"] = e.target_s;
    d["achieved_s"] = e.achieved_s;
    d["error_s"] = e.error_s;
    d["error_retimed_s"] = e.error_retimed_s;
    d["retime"] = e.retime;
    d["excess"] = e.excess;
    d["factors"] = from_factors(e.factors);
    events.append(d);
  }
  py::dict d;
  d["motion"] = std::const_pointer_cast<Motion>(s.motion);
  d["score"] = s.score;
  d["score_without_sound"] = s.score_without_sound;
  d["succeeded"] = s.succeeded;
  d["plausible"] = s.plausible;
  d["events"] = events;
  d["max_abs_error_s"] = s.max_abs_error_s;
  d["missed_hits"] = s.missed_hits;
  d["extra_hits"] = s.extra_hits;
  d["max_penetration_m"] = s.max_penetration_m;
  d["max_energy_gain_j"] = s.max_energy_gain_j;
  d["simulated_s"] = s.simulated_s;
  d["restitution"] = s.restitution;
  d["friction"] = s.friction;
  d["rung"] = s.rung;
  return d;
}

}  // namespace

void bind_forward(py::module_& m) {
  auto& no_motion = py::register_exception<NoMotionError>(m, "NoMotionError", m.attr("IfaError"));
  no_motion.doc() = "There is no motion to show: no first contact was found for this body and these marks.";
  m.attr("RUNGS") = rung_count();
  m.def(
      "solve_forward",
      [](const Body& body, const Marks& marks, std::uint64_t seed, double time_budget_s, int threads,
         bool fit_material, double energy_gain_j, int rung, const std::shared_ptr<Progress>& progress) {
        const SolveOptions options{seed, time_budget_s, threads, fit_material, energy_gain_j, rung};
        const auto work = [&](Progress* p) { return solve_forward(body, marks, options, p); };
        return from_solution(run_interruptible<Solution>(progress, work));
      },
      py::arg("body"), py::arg("marks"), py::kw_only(), py::arg("seed"), py::arg("time_budget_s"),
      py::arg("threads"), py::arg("fit_material"), py::arg("energy_gain_j"), py::arg("rung"),
      py::arg("progress"));
}

}  // namespace ifa::bindings
