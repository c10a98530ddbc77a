// The independent check of a motion.
#include <map>

#include "bindings.hpp"
#include "ifa/rigid/body.hpp"
#include "ifa/verify/certificate.hpp"

namespace ifa::bindings {
namespace {

py::dict from_certificate(const verify::Certificate& c) {
  using py::literals::operator""_a;
  py::list hits, events, marks, flights;
  for (const auto& h : c.hits)
    hits.append(
        py::dict("time_s"_a = h.time_s, "approach_speed_m_s"_a = h.approach_speed_m_s,
                 "position_m"_a = py::make_tuple(h.position_m.x(), h.position_m.y(), h.position_m.z()),
                 "certain"_a = h.certain, "event"_a = h.event));
  for (const auto& e : c.events)
    events.append(py::dict("time_s"_a = e.time_s, "duration_s"_a = e.duration_s, "hits"_a = e.hits));
  for (const auto& m : c.marks) {
    py::dict mark("target_s"_a = m.target_s, "achieved_s"_a = py::none(), "error_s"_a = py::none());
    if (m.matched) {
      mark["achieved_s"] = m.achieved_s;
      mark["error_s"] = m.error_s;
    }
    marks.append(mark);
  }
  for (const auto& f : c.flights)
    flights.append(py::dict("start_s"_a = f.start_s, "end_s"_a = f.end_s, "gravity_error"_a = f.gravity_error,
                            "horizontal_acceleration_m_s2"_a = f.horizontal_acceleration_m_s2,
                            "momentum_drift"_a = f.momentum_drift, "energy_j"_a = f.energy_j));
  return py::dict("passed"_a = c.passed, "failures"_a = c.failures, "hits"_a = hits, "events"_a = events,
                  "marks"_a = marks, "flights"_a = flights, "extra_events_s"_a = c.extra_events_s,
                  "missed_hits"_a = c.missed_hits, "extra_hits"_a = c.extra_hits,
                  "max_abs_error_s"_a = c.max_abs_error_s, "max_penetration_m"_a = c.max_penetration_m,
                  "max_gravity_error"_a = c.max_gravity_error,
                  "max_horizontal_acceleration_m_s2"_a = c.max_horizontal_acceleration_m_s2,
                  "max_momentum_drift"_a = c.max_momentum_drift, "max_energy_gain_j"_a = c.max_energy_gain_j,
                  "max_contact_energy_gain_j"_a = c.max_contact_energy_gain_j, "at_rest"_a = c.at_rest,
                  "rest_s"_a = c.rest_s);
}

py::dict verify_motion(const Array& times_s, const Array& positions_m, const Array& quaternions_wxyz,
                       const Body& body, const Array& mark_times_s, const Array& mark_durations_s, bool rest,
                       const Array& retime, double energy_gain_j, bool contact,
                       const std::map<std::string, double>& given) {
  verify::Options o;
  o.events = contact ? verify::Events::contact : verify::Events::audible;
  const std::pair<const char*, double*> fields[] = {{"audible_speed_m_s", &o.audible_speed_m_s},
                                                    {"merge_gap_s", &o.merge_gap_s},
                                                    {"gravity_m_s2", &o.gravity_m_s2},
                                                    {"rest_speed_m_s", &o.rest_speed_m_s},
                                                    {"rest_duration_s", &o.rest_duration_s},
                                                    {"time_tolerance_s", &o.time_tolerance_s},
                                                    {"penetration_limit_m", &o.penetration_limit_m}};
  for (const auto& [name, value] : fields) *value = given.at(name);

  verify::Poses poses{to_vector(times_s, "times_s"), to_points(positions_m, "positions_m"), {}};
  if (quaternions_wxyz.ndim() != 2 || quaternions_wxyz.shape(1) != 4)
    throw ArgumentError("quaternions_wxyz: needs shape (n, 4)");
  for (py::ssize_t i = 0; i < quaternions_wxyz.shape(0); ++i) {
    const double* q = quaternions_wxyz.data(i, 0);
    poses.orientations.emplace_back(q[0], q[1], q[2], q[3]);
  }
  const verify::MarkSet marks{to_vector(mark_times_s, "times_s"), to_vector(mark_durations_s, "durations_s"),
                              rest};
  const verify::Claims claims{to_vector(retime, "retime"), energy_gain_j};
  verify::Certificate certificate;
  {
    const py::gil_scoped_release release;
    certificate = verify::verify(poses, body, marks, claims, o);
  }
  return from_certificate(certificate);
}

}  // namespace

void bind_verify(py::module_& m) {
  m.def("verify", &verify_motion, py::kw_only(), py::arg("times_s"), py::arg("positions_m"),
        py::arg("quaternions_wxyz"), py::arg("body"), py::arg("mark_times_s"), py::arg("mark_durations_s"),
        py::arg("rest"), py::arg("retime"), py::arg("energy_gain_j"), py::arg("contact"), py::arg("options"),
        "Every option of ifa.verify, which documents them, must be in `options`.");
}

}  // namespace ifa::bindings
