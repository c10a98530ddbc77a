// Marks: the contact-time signature of a sound, or of a simulated run.
#include "ifa/signature/marks.hpp"

#include <limits>
#include <optional>

#include "bindings.hpp"
#include "ifa/signature/signature_of.hpp"

namespace ifa::bindings {
namespace {

Ending to_ending(const std::string& text) {
  if (text == "rest") return Ending::rest;
  if (text == "open") return Ending::open;
  throw ArgumentError("ending: must be \"rest\" or \"open\", got \"" + text + "\"");
}

Marks make_marks(const Array& times_s, const std::optional<Array>& durations_s,
                 const std::optional<Array>& amplitudes, const std::optional<Array>& centroids_s,
                 const std::string& ending, double merge_gap_s) {
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
           py::arg("ending") = "rest", py::arg("merge_gap_s") = kMergeGap_s)
      .def("__len__", &Marks::size)
      .def_property_readonly("times_s", [](const Marks& marks) { return from_vector(marks.times_s); })
      .def_property_readonly("durations_s", [](const Marks& marks) { return from_vector(marks.durations_s); })
      .def_property_readonly("amplitudes",
                             [](const Marks& marks) -> std::optional<Array> {
                               if (marks.amplitudes.empty()) return std::nullopt;
                               return from_vector(marks.amplitudes);
                             })
      .def_property_readonly("centroids_s", [](const Marks& marks) { return from_vector(marks.centroids_s); })
      .def_property_readonly(
          "ending", [](const Marks& marks) { return marks.ending == Ending::rest ? "rest" : "open"; });

  m.def("run_marks", &run_marks, py::arg("times_s"), py::arg("impulses_n_s"), py::arg("approach_speeds_m_s"),
        py::arg("at_rest"), py::arg("audible_speed_m_s"), py::arg("merge_gap_s"),
        "The Marks of a run's hits, not yet validated.");
}

}  // namespace ifa::bindings
