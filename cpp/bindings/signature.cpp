// Marks: the contact-time signature of a sound.
#include "ifa/signature/marks.hpp"

#include <limits>
#include <optional>

#include "bindings.hpp"

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

}  // namespace

void bind_signature(py::module_& m) {
  m.attr("MERGE_GAP_S") = kMergeGap_s;

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
}

}  // namespace ifa::bindings
