// The forward search.
#include "ifa/forward/kept.hpp"
#include "ifa/forward/solve.hpp"

#include <optional>

#include "ifa/base/message.hpp"
#include "ifa/forward/estimate.hpp"
#include "solution.hpp"

namespace ifa::bindings {
namespace {

py::tuple from_range(const Range& range) { return py::make_tuple(range.least, range.most); }

py::dict from_gap(const GapEstimate& g) {
  py::dict d;
  d["gap_s"] = g.gap_s;
  d["flight_s"] = g.flight_s;
  d["takeoff_speed_m_s"] = g.takeoff_speed_m_s;
  d["takeoff_speed_range_m_s"] = from_range(g.takeoff_speed_range_m_s);
  d["apex_m"] = g.apex_m;
  d["apex_range_m"] = from_range(g.apex_range_m);
  d["energy_j"] = g.energy_j;
  d["most_energy_j"] = g.most_energy_j;
  d["needed_j"] = g.needed_j;
  d["surplus_j"] = g.surplus_j;
  d["ratio"] = g.ratio;
  return d;
}

py::dict from_estimate(const Estimate& e, const Marks& marks) {
  py::list gaps, findings;
  for (const GapEstimate& gap : e.gaps) gaps.append(from_gap(gap));
  for (const Finding& finding : e.findings) {
    py::dict d;
    d["mark"] = finding.mark;
    d["name"] = mark_name(finding.mark, marks.times_s[finding.mark]);
    d["text"] = finding.text;
    findings.append(d);
  }
  py::dict d;
  d["centre_height_m"] = from_range(e.centre_height_m);
  d["ball"] = e.ball;
  d["gaps"] = gaps;
  d["restitution"] = e.restitution;
  d["friction"] = e.friction;
  d["restitution_from_gaps"] = e.restitution_from_gaps;
  d["next_gap_s"] = e.next_gap_s;
  d["rest_is_near"] = e.rest_is_near;
  d["findings"] = findings;
  return d;
}

}  // namespace

void bind_forward(py::module_& m) {
  m.attr("RUNGS") = rung_count();
  const auto rungs = standard_ladder();
  m.attr("LADDER") = py::tuple(py::cast(std::vector<int>(rungs.begin(), rungs.end())));
  m.attr("CLEARLY_DIFFERENT") = kClearlyDifferent;
  py::class_<KeptSearch, std::shared_ptr<KeptSearch>>(m, "KeptSearch", "What a solve keeps for another one.");
  m.def(
      "solve_forward",
      [](const Body& body, const Marks& marks, std::uint64_t seed, double time_budget_s, int threads,
         bool fit_material, double energy_gain_j, int rung, bool contact, int takes, double lead_in_s,
         const std::shared_ptr<KeptSearch>& reuse, const std::shared_ptr<Progress>& progress,
         const std::map<std::string, bool>& forced, const std::vector<int>& ladder, bool until_succeeded,
         int least_rung, int roots, int variants) {
        const SolveOptions options{seed,
                                   time_budget_s,
                                   threads,
                                   fit_material,
                                   energy_gain_j,
                                   rung,
                                   contact ? Events::contact : Events::audible,
                                   takes,
                                   lead_in_s,
                                   reuse,
                                   to_forced(forced),
                                   ladder,
                                   until_succeeded ? Goal::succeeded : Goal::plausible,
                                   least_rung,
                                   {roots, variants}};
        const auto work = [&](Progress* p) { return solve_forward(body, marks, options, p); };
        return from_solution(run_interruptible<Solution>(progress, work));
      },
      py::arg("body"), py::arg("marks"), py::kw_only(), py::arg("seed"), py::arg("time_budget_s"),
      py::arg("threads"), py::arg("fit_material"), py::arg("energy_gain_j"), py::arg("rung"),
      py::arg("contact"), py::arg("takes"), py::arg("lead_in_s"), py::arg("reuse"), py::arg("progress"),
      py::arg("forced") = std::map<std::string, bool>{}, py::arg("ladder") = std::vector<int>{},
      py::arg("until_succeeded") = false, py::arg("least_rung") = 0, py::arg("roots") = Proposals{}.roots,
      py::arg("variants") = Proposals{}.variants);
  m.def(
      "estimate",
      [](const Body& body, const Marks& marks, const Array& gravity_m_s2) {
        const Vec3 gravity = to_vec3(gravity_m_s2, "gravity_m_s2");
        Estimate e;
        {
          const py::gil_scoped_release release;
          e = estimate(body, marks, gravity);
        }
        return from_estimate(e, marks);
      },
      py::arg("body"), py::arg("marks"), py::arg("gravity_m_s2"));
}

}  // namespace ifa::bindings
