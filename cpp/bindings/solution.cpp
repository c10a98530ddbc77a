// Solutions, for all searches.
#include "solution.hpp"

#include "ifa/forward/kept.hpp"

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

// One dict for each effect, in their order.
py::list from_plan(const Plan& plan) {
  py::list effects;
  for (std::size_t e = 0; e < kEffects; ++e) {
    const PlannedEffect& planned = plan[static_cast<Effect>(e)];
    py::dict d;
    d["name"] = std::string(kEffectNames[e]);
    d["on"] = planned.on;
    d["forced"] = planned.forced;
    d["because"] = planned.because;
    effects.append(d);
  }
  return effects;
}

}  // namespace

ForcedEffects to_forced(const std::map<std::string, bool>& forced) {
  ForcedEffects effects;
  for (const auto& [name, on] : forced) effects[index_of(effect_named(name))] = on;
  return effects;
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
  py::list constraints;  // (error, factor)
  for (const ConstraintReport& c : s.constraints) constraints.append(py::make_tuple(c.error, c.factor));
  py::dict d;
  d["constraints"] = constraints;
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
  py::list history;
  for (const Stage& stage : s.history) {
    py::dict h;
    h["time_s"] = stage.time_s;
    h["rung"] = stage.rung;
    h["score"] = stage.score;
    h["succeeded"] = stage.succeeded;
    h["plausible"] = stage.plausible;
    history.append(h);
  }
  d["history"] = history;
  py::list others;
  for (const Solution& other : s.others) others.append(from_solution(other));
  d["others"] = others;
  d["search_log_weight"] = s.search_log_weight;
  d["search_log_bound"] = s.search_log_bound;
  const py::list effects = from_plan(s.plan);
  for (std::size_t e = 0; e < kEffects; ++e) effects[e]["runs"] = s.effect_runs.runs[e];
  d["effects"] = effects;
  d["kept"] = std::const_pointer_cast<KeptSearch>(s.kept);
  return d;
}

void bind_solution(py::module_& m) {
  py::list names;
  for (const std::string_view name : kEffectNames) names.append(std::string(name));
  m.attr("EFFECTS") = names;
  m.def(
      "plan",
      [](const Body& body, const Marks& marks, bool contact, bool fit_material, double lead_in_s,
         bool method_graph, const std::map<std::string, bool>& forced) {
        return from_plan(make_plan(body, marks,
                                   {contact ? Events::contact : Events::audible, fit_material, lead_in_s,
                                    method_graph, to_forced(forced)}));
      },
      py::arg("body"), py::arg("marks"), py::kw_only(), py::arg("contact"), py::arg("fit_material"),
      py::arg("lead_in_s"), py::arg("method_graph"), py::arg("forced"));
  auto& no_motion = py::register_exception<NoMotionError>(m, "NoMotionError", m.attr("IfaError"));
  no_motion.doc() = "There is no motion to show: no first contact was found for this body and these marks.";
}

}  // namespace ifa::bindings
