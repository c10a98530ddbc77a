// The forward search asked what is wrong with marks, and what would help.
#include "ifa/forward/explain.hpp"

#include <optional>

#include "bindings.hpp"
#include "ifa/base/message.hpp"

namespace ifa::bindings {
namespace {

// What an explanation looks at of an ifa.Solution, from its to_dict().
Solution to_solution(const py::dict& d) {
  Solution s;
  s.score = d["score"].cast<double>();
  s.succeeded = d["succeeded"].cast<bool>();
  s.plausible = d["plausible"].cast<bool>();
  s.missed_hits = d["missed_hits"].cast<int>();
  s.extra_hits = d["extra_hits"].cast<int>();
  s.max_penetration_m = d["max_penetration_m"].cast<double>();
  for (const py::handle event : d["events"]) {
    const auto factor = [&](const char* name) { return event["factors"][name].cast<double>(); };
    EventReport e{};
    e.retime = event["retime"].cast<double>();
    e.excess = event["excess"].cast<double>();
    e.factors.time = factor("time");
    e.factors.amplitude = factor("amplitude");
    e.factors.length = factor("length");
    e.factors.centroid = factor("centroid");
    s.events.push_back(e);
  }
  return s;
}

py::dict from_explanation(const Explanation& e, const Marks& marks) {
  py::list conflicts, repairs;
  for (const Conflict& c : e.conflicts) {
    py::dict d;
    d["mark"] = c.mark;
    d["name"] = mark_name(c.mark, marks.times_s[c.mark]);
    d["kind"] = std::string(name_of(c.kind));
    d["text"] = c.text;
    d["finding"] = c.finding.empty() ? std::optional<std::string>() : c.finding;
    conflicts.append(d);
  }
  for (const Repair& r : e.repairs) {
    const bool material = r.kind == RepairKind::restitution || r.kind == RepairKind::friction;
    py::dict d;
    d["kind"] = std::string(name_of(r.kind));
    d["mark"] = material ? std::optional<std::size_t>() : r.mark;
    d["amount"] = r.amount;
    d["unit"] = std::string(unit_of(r.kind));
    d["cost"] = r.cost;
    d["text"] = r.text;
    d["plausible"] = r.plausible;
    d["score"] = r.score;
    d["rung"] = r.rung;
    d["marks"] = r.request.marks;
    d["restitution"] = r.request.body.material().restitution;
    d["friction"] = r.request.body.material().friction;
    d["energy_gain_j"] = r.request.energy_gain_j;
    repairs.append(d);
  }
  py::dict d;
  d["succeeded"] = e.succeeded;
  d["plausible"] = e.plausible;
  d["conflicts"] = conflicts;
  d["repairs"] = repairs;
  d["trials"] = e.trials;
  d["complete"] = e.complete;
  return d;
}

}  // namespace

void bind_explain(py::module_& m) {
  m.def(
      "explain",
      [](const Body& body, const Marks& marks, const std::optional<py::dict>& solution, double merge_gap_s,
         std::uint64_t seed, double time_budget_s, int threads, bool fit_material, double energy_gain_j,
         bool contact, const std::shared_ptr<Progress>& progress) {
        SolveOptions options;
        options.seed = seed;
        options.time_budget_s = time_budget_s;
        options.threads = threads;
        options.fit_material = fit_material;
        options.energy_gain_j = energy_gain_j;
        options.events = contact ? Events::contact : Events::audible;
        std::optional<Solution> known;
        if (solution) known = to_solution(*solution);
        const auto work = [&](Progress* p) {
          return explain(body, marks, options, merge_gap_s, known ? &*known : nullptr, p);
        };
        return from_explanation(run_interruptible<Explanation>(progress, work), marks);
      },
      py::arg("body"), py::arg("marks"), py::kw_only(), py::arg("solution"), py::arg("merge_gap_s"),
      py::arg("seed"), py::arg("time_budget_s"), py::arg("threads"), py::arg("fit_material"),
      py::arg("energy_gain_j"), py::arg("contact"), py::arg("progress"));
}

}  // namespace ifa::bindings
