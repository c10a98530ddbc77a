// Batches of simulations, into arrays that Python has made and checked.
#include "ifa/rigid/batch.hpp"
#include "ifa/rigid/start_check.hpp"

#include <array>
#include <cstdio>

#include "bindings.hpp"

namespace ifa::bindings {
namespace {

static_assert(static_cast<int>(SampleStatus::rest) == 0 && static_cast<int>(SampleStatus::time_limit) == 1 &&
                  static_cast<int>(SampleStatus::impact_limit) == 2 &&
                  static_cast<int>(SampleStatus::failed) == 3 &&
                  static_cast<int>(SampleStatus::not_run) == 4 &&
                  static_cast<int>(SampleStatus::contact) == 5,
              "ifa.SampleStatus (python/ifa/batch.py) holds these codes");

// The elements of `out[name]`: the caller's own memory, never a copy.
template <class T, class Element = T>
std::span<T> elements(const py::dict& out, const char* name, std::size_t size) {
  const py::object object = out[name];
  if (!py::isinstance<py::array_t<Element, py::array::c_style>>(object))
    throw ArgumentError(std::string("out.") + name + ": wrong dtype or layout");
  auto array = py::reinterpret_borrow<py::array>(object);
  if (static_cast<std::size_t>(array.size()) != size)
    throw ArgumentError(std::string("out.") + name + ": wrong size");
  return {static_cast<T*>(array.mutable_data()), size};
}

BatchOutputs to_outputs(const py::dict& out, std::size_t n, std::size_t m) {
  BatchOutputs o;
  o.status = elements<SampleStatus, std::uint8_t>(out, "status", n);
  o.end_time_s = elements<double>(out, "end_time_s", n);
  o.position_m = elements<double>(out, "position_m", 3 * n);
  o.quaternion_wxyz = elements<double>(out, "quaternion_wxyz", 4 * n);
  o.velocity_m_s = elements<double>(out, "velocity_m_s", 3 * n);
  o.angular_velocity_rad_s = elements<double>(out, "angular_velocity_rad_s", 3 * n);
  o.hit_count = elements<std::int32_t>(out, "hit_count", n);
  o.hit_time_s = elements<double>(out, "hit_time_s", n * m);
  o.hit_impulse_n_s = elements<double>(out, "hit_impulse_n_s", 3 * n * m);
  o.hit_approach_speed_m_s = elements<double>(out, "hit_approach_speed_m_s", n * m);
  o.hit_position_m = elements<double>(out, "hit_position_m", 3 * n * m);
  o.hits_per_sample = m;
  return o;
}

std::vector<State> to_states(const Array& position_m, const Array& quaternion_wxyz, const Array& velocity_m_s,
                             const Array& angular_velocity_rad_s) {
  const std::vector<Vec3> positions = to_points(position_m, "position_m");
  const std::vector<Vec3> velocities = to_points(velocity_m_s, "velocity_m_s");
  const std::vector<Vec3> spins = to_points(angular_velocity_rad_s, "angular_velocity_rad_s");
  const std::size_t n = positions.size();
  if (velocities.size() != n || spins.size() != n || quaternion_wxyz.ndim() != 2 ||
      static_cast<std::size_t>(quaternion_wxyz.shape(0)) != n || quaternion_wxyz.shape(1) != 4)
    throw ArgumentError("states: needs n rows in each array");
  std::vector<State> states(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double* q = quaternion_wxyz.data(i, 0);
    states[i] = {positions[i], Quat(q[0], q[1], q[2], q[3]), velocities[i], spins[i]};
  }
  return states;
}

void check_starts(std::span<const Body* const> bodies, std::span<const State> states) {
  for (std::size_t i = 0; i < states.size(); ++i) {
    const std::string why = unfit_start(*bodies[bodies.size() == 1 ? 0 : i], states[i]);
    if (!why.empty()) throw ArgumentError("states: row " + std::to_string(i) + ": " + why);
  }
}

// The core writes orientations of principal axes.
void to_body_axes(std::span<const Body* const> bodies, const BatchOutputs& out) {
  for (std::size_t i = 0; i < out.status.size(); ++i) {
    if (out.status[i] == SampleStatus::failed || out.status[i] == SampleStatus::not_run) continue;
    double* q = &out.quaternion_wxyz[4 * i];
    State s;
    s.orientation = Quat(q[0], q[1], q[2], q[3]);
    const Quat r = to_body(*bodies[bodies.size() == 1 ? 0 : i], s).orientation;
    q[0] = r.w();
    std::copy_n(r.vec().data(), 3, q + 1);
  }
}

void run_batch(const std::vector<std::shared_ptr<Body>>& given, const Array& position_m,
               const Array& quaternion_wxyz, const Array& velocity_m_s, const Array& angular_velocity_rad_s,
               double step_s, double until_s, const Array& gravity_m_s2, std::size_t hits, int threads,
               const std::string& instruction_set, const py::dict& out,
               const std::shared_ptr<Progress>& progress, bool sustained_contact) {
  std::vector<State> states = to_states(position_m, quaternion_wxyz, velocity_m_s, angular_velocity_rad_s);
  if (given.size() != 1 && given.size() != states.size())
    throw ArgumentError("body: needs one, or one for each state");
  std::vector<const Body*> bodies;
  for (const auto& body : given) bodies.push_back(body.get());
  const BatchOutputs outputs = to_outputs(out, states.size(), hits);
  BatchOptions options;
  options.simulation.step_s = step_s;
  options.simulation.sustained_contact = sustained_contact;
  options.simulation.gravity_m_s2 = to_vec3(gravity_m_s2, "gravity_m_s2");
  options.until_s = until_s;
  options.threads = threads;
  options.instruction_set = instruction_set;
  run_interruptible<bool>(progress, [&](Progress* p) {
    for (std::size_t i = 0; i < states.size(); ++i)
      states[i] = to_principal(*bodies[bodies.size() == 1 ? 0 : i], states[i]);
    check_starts(bodies, states);
    try {
      simulate_batch(bodies, states, options, outputs, p);
    } catch (...) {  // what was done by then is whole
      to_body_axes(bodies, outputs);
      throw;
    }
    to_body_axes(bodies, outputs);
    p->raise_to(1.0);  // also of an empty batch
    return true;
  });
}

}  // namespace

void bind_batch(py::module_& m) {
  m.def("simulate_batch", &run_batch, py::arg("bodies"), py::arg("position_m"), py::arg("quaternion_wxyz"),
        py::arg("velocity_m_s"), py::arg("angular_velocity_rad_s"), py::kw_only(), py::arg("step_s"),
        py::arg("until_s"), py::arg("gravity_m_s2"), py::arg("hits"), py::arg("threads"),
        py::arg("instruction_set"), py::arg("out"), py::arg("progress"), py::arg("sustained_contact") = true,
        "Into the arrays of `out`, named and shaped as those of ifa.Batch, which Python checks.");
  m.def("instruction_sets", &instruction_sets, "The names of those that run here, the narrowest first.");
}

}  // namespace ifa::bindings
