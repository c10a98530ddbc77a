// Marks: the contact-time signature of a sound, or of a simulated run.
#include "ifa/signature/marks.hpp"

#include <array>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "bindings.hpp"
#include "ifa/signature/signature_of.hpp"

namespace ifa::bindings {
namespace {

Ending to_ending(const std::string& text) {
  if (text == "rest") return Ending::rest;
  if (text == "open") return Ending::open;
  throw ArgumentError("ending: must be \"rest\" or \"open\", got \"" + text + "\"");
}

// (mark, position (2,)) and (mark, body direction (3,), direction (3,)); the mark None is rest.
using Positions = std::vector<std::pair<std::size_t, std::array<double, 2>>>;
using Orientations =
    std::vector<std::tuple<std::optional<std::size_t>, std::array<double, 3>, std::array<double, 3>>>;

Constraints to_constraints(const Positions& positions, const Orientations& orientations) {
  const auto vec3 = [](const std::array<double, 3>& v) { return Vec3(v[0], v[1], v[2]); };
  Constraints c;
  for (const auto& [mark, at] : positions) c.positions.push_back({mark, {at[0], at[1]}});
  for (const auto& [mark, body, world] : orientations)
    c.orientations.push_back({mark.value_or(kAtRest), vec3(body), vec3(world)});
  return c;
}

Positions from_positions(const Constraints& constraints) {
  Positions out;
  for (const PositionConstraint& c : constraints.positions)
    out.push_back({c.mark, {c.position_m.x(), c.position_m.y()}});
  return out;
}

Orientations from_orientations(const Constraints& constraints) {
  const auto array = [](const Vec3& v) { return std::array{v.x(), v.y(), v.z()}; };
  Orientations out;
  for (const OrientationConstraint& c : constraints.orientations) {
    const auto mark = c.mark == kAtRest ? std::optional<std::size_t>() : c.mark;
    out.push_back({mark, array(c.body_direction), array(c.direction)});
  }
  return out;
}

Marks make_marks(const Array& times_s, const std::optional<Array>& durations_s,
                 const std::optional<Array>& amplitudes, const std::optional<Array>& centroids_s,
                 const std::string& ending, double merge_gap_s, const Positions& positions,
                 const Orientations& orientations) {
  Marks marks;
  marks.times_s = to_vector(times_s, "times_s");
  const std::size_t n = marks.size();
  marks.durations_s = durations_s ? to_vector(*durations_s, "durations_s") : std::vector<double>(n, 0.0);
  if (amplitudes) {
    marks.amplitudes = to_vector(*amplitudes, "amplitudes");
    // to Marks an empty list means "unknown"; to a caller who gives one it is too short
    if (n > 0 && marks.amplitudes.empty()) throw ArgumentError("amplitudes: the list is empty; leave it out");
  }
  marks.centroids_s = centroids_s ? to_vector(*centroids_s, "centroids_s")
                                  : std::vector<double>(n, std::numeric_limits<double>::quiet_NaN());
  marks.ending = to_ending(ending);
  marks.constraints = to_constraints(positions, orientations);
  validate(marks, merge_gap_s);
  return marks;
}

// Of a run's hits: times (n,), impulses (n, 3) and approach speeds (n,).
Marks run_marks(const Array& times_s, const Array& impulses_n_s, const Array& approach_speeds_m_s,
                bool at_rest, double audible_speed_m_s, double merge_gap_s) {
  const std::vector<double> times = to_vector(times_s, "time_s");
  const std::vector<Vec3> impulses = to_points(impulses_n_s, "impulse_n_s");
  const std::vector<double> speeds = to_vector(approach_speeds_m_s, "approach_speed_m_s");
  if (impulses.size() != times.size() || speeds.size() != times.size())
    throw ArgumentError("run: its hits need a time, an impulse and an approach speed each");
  Run run;
  run.status = at_rest ? RunStatus::rest : RunStatus::time_limit;
  for (std::size_t i = 0; i < times.size(); ++i)
    run.hits.push_back({times[i], impulses[i], speeds[i], Vec3::Zero()});
  return signature_of(run, {Events::audible, audible_speed_m_s, merge_gap_s});
}

}  // namespace

void bind_signature(py::module_& m) {
  m.attr("MERGE_GAP_S") = kMergeGap_s;
  m.attr("AUDIBLE_SPEED_M_S") = HearingOptions{}.audible_speed_m_s;

  py::class_<Marks>(m, "Marks", "The marks as the core holds them; `ifa.Signature` is the documented face.")
      .def(py::init(&make_marks), py::arg("times_s"), py::arg("durations_s") = py::none(),
           py::arg("amplitudes") = py::none(), py::arg("centroids_s") = py::none(),
           py::arg("ending") = "rest", py::arg("merge_gap_s") = kMergeGap_s,
           py::arg("positions") = Positions{}, py::arg("orientations") = Orientations{})
      .def("__len__", &Marks::size)
      .def_property_readonly("times_s", [](const Marks& marks) { return from_vector(marks.times_s); })
      .def_property_readonly("durations_s", [](const Marks& marks) { return from_vector(marks.durations_s); })
      .def_property_readonly("amplitudes",
                             [](const Marks& marks) -> std::optional<Array> {
                               if (marks.amplitudes.empty()) return std::nullopt;
                               return from_vector(marks.amplitudes);
                             })
      .def_property_readonly("centroids_s", [](const Marks& marks) { return from_vector(marks.centroids_s); })
      .def_property_readonly("positions",
                             [](const Marks& marks) { return from_positions(marks.constraints); })
      .def_property_readonly("orientations",
                             [](const Marks& marks) { return from_orientations(marks.constraints); })
      .def_property_readonly(
          "ending", [](const Marks& marks) { return marks.ending == Ending::rest ? "rest" : "open"; });

  m.def("run_marks", &run_marks, py::arg("times_s"), py::arg("impulses_n_s"), py::arg("approach_speeds_m_s"),
        py::arg("at_rest"), py::arg("audible_speed_m_s"), py::arg("merge_gap_s"),
        "The Marks of a run's hits, not yet validated.");
}

}  // namespace ifa::bindings
