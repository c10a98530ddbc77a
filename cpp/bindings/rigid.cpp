// Bodies, convex hulls and mass properties.
#include "bindings.hpp"
#include "ifa/rigid/effects.hpp"
#include "ifa/rigid/engine_ode.hpp"
#include "ifa/rigid/event_engine.hpp"
#include "states.hpp"

#include "ifa/rigid/body.hpp"
#include "ifa/rigid/hull.hpp"
#include "ifa/rigid/start_check.hpp"
#include "ifa/rigid/symmetry.hpp"

namespace ifa::bindings {
namespace {

std::vector<Triangle> to_triangles(const py::array_t<int, py::array::c_style | py::array::forcecast>& array) {
  if (array.ndim() != 2 || array.shape(1) != 3) throw ArgumentError("triangles: needs shape (n, 3)");
  std::vector<Triangle> triangles(array.shape(0));
  for (std::size_t i = 0; i < triangles.size(); ++i) std::copy_n(array.data(i, 0), 3, triangles[i].begin());
  return triangles;
}

py::array_t<int> from_triangles(const std::vector<Triangle>& triangles) {
  py::array_t<int> array({static_cast<py::ssize_t>(triangles.size()), py::ssize_t{3}});
  int* out = array.mutable_data();
  for (const Triangle& t : triangles) out = std::copy(t.begin(), t.end(), out);
  return array;
}

py::tuple from_mass_properties(const MassProperties& m) {
  return py::make_tuple(m.volume_m3, from_vec3(m.centre_of_mass_m), from_mat3(m.inertia_kg_m2));
}

// Rows of centre, axis and radius.
std::vector<Ring> to_rings(const Array& array) {
  if (array.ndim() != 2 || array.shape(1) != 7) throw ArgumentError("rings_m: needs shape (n, 7)");
  std::vector<Ring> rings;
  for (py::ssize_t i = 0; i < array.shape(0); ++i) {
    const double* row = array.data(i, 0);
    rings.push_back({Vec3(row[0], row[1], row[2]), Vec3(row[3], row[4], row[5]), row[6]});
  }
  return rings;
}

Array from_rings(const std::vector<Ring>& rings) {
  Array array({static_cast<py::ssize_t>(rings.size()), py::ssize_t{7}});
  double* out = array.mutable_data();
  for (const Ring& ring : rings) {
    out = std::copy_n(ring.centre_m.data(), 3, out);
    out = std::copy_n(ring.axis.data(), 3, out);
    *out++ = ring.radius_m;
  }
  return array;
}

Body make_body(const std::string& name, const Array& vertices_m, const Array& rings_m, double radius_m,
               double mass_kg, const Array& centre_of_mass_m, const Array& inertia_kg_m2, double restitution,
               double friction, double rolling_friction_m, double spin_friction_m) {
  Body::Definition definition;
  definition.name = name;
  definition.vertices_m = to_points(vertices_m, "vertices_m");
  definition.rings_m = to_rings(rings_m);
  definition.radius_m = radius_m;
  definition.mass_kg = mass_kg;
  definition.centre_of_mass_m = to_vec3(centre_of_mass_m, "centre_of_mass_m");
  definition.inertia_kg_m2 = to_mat3(inertia_kg_m2, "inertia_kg_m2");
  definition.material = {restitution, friction, rolling_friction_m, spin_friction_m};
  py::gil_scoped_release release;
  return Body::make(std::move(definition));
}

// (name, continuous, maps (n, 3, 3) in body axes, axis (3,) in body axes)
py::tuple symmetry_of(const Body& body) {
  const Symmetry symmetry = [&] {
    const py::gil_scoped_release release;
    return Symmetry::of(body);
  }();
  const Mat3 axes = body.body_from_principal().toRotationMatrix();
  Array maps({static_cast<py::ssize_t>(symmetry.elements().size()), py::ssize_t{3}, py::ssize_t{3}});
  double* out = maps.mutable_data();
  for (const SymmetryElement& g : symmetry.elements()) {
    const Mat3 map = axes * g.map * axes.transpose();
    for (int i = 0; i < 9; ++i) *out++ = map(i / 3, i % 3);
  }
  const Vec3 axis = axes * symmetry.axis();
  return py::make_tuple(symmetry.name(), symmetry.kind() != Symmetry::Kind::finite, maps, from_vec3(axis));
}

void bind_body(py::module_& m) {
  py::class_<Body, std::shared_ptr<Body>>(m, "Body", "A rigid body of the core; ifa.Body wraps it.")
      .def(py::init(&make_body), py::kw_only(), py::arg("name"), py::arg("vertices_m"), py::arg("rings_m"),
           py::arg("radius_m"), py::arg("mass_kg"), py::arg("centre_of_mass_m"), py::arg("inertia_kg_m2"),
           py::arg("restitution"), py::arg("friction"), py::arg("rolling_friction_m"),
           py::arg("spin_friction_m"))
      .def_property_readonly("name", &Body::name)
      .def_property_readonly(
          "vertices_m", [](const Body& b) { return from_points(b.vertices()); },
          "(n, 3) extreme points of the hull about the centre of mass, body axes.")
      .def_property_readonly(
          "rings_m", [](const Body& b) { return from_rings(b.rings()); },
          "(n, 7) centre about the centre of mass, unit axis and radius of each circular edge, body axes.")
      .def_property_readonly("radius_m", &Body::radius_m)
      .def_property_readonly("mass_kg", &Body::mass_kg)
      .def_property_readonly("centre_of_mass_m",
                             [](const Body& b) { return from_vec3(b.definition().centre_of_mass_m); })
      .def_property_readonly("inertia_kg_m2", [](const Body& b) { return from_mat3(b.inertia_kg_m2()); })
      .def_property_readonly("principal_inertia_kg_m2",
                             [](const Body& b) { return from_vec3(b.principal_inertia()); })
      .def_property_readonly("bounding_radius_m", &Body::bounding_radius_m)
      .def("symmetry", &symmetry_of)
      .def_property_readonly(
          "needed_effects",
          [](const Body& b) {
            const EngineEffects e = needed_effects(b);
            py::dict needed;
            needed["spin_coupling"] = e.spin_coupling;
            needed["friction"] = e.friction;
            needed["rounding"] = e.rounding;
            needed["circular_edges"] = e.circular_edges;
            return needed;
          },
          "Those of the engine's effects that the body calls for, by name.")
      .def(
          "with_effects",
          [](const Body& b, bool spin_coupling, bool friction, bool rounding, bool circular_edges) {
            return with_effects(b, {spin_coupling, friction, rounding, circular_edges});
          },
          py::kw_only(), py::arg("spin_coupling"), py::arg("friction"), py::arg("rounding"),
          py::arg("circular_edges"), "The body with these effects of the engine on or off.")
      .def_property_readonly("restitution", [](const Body& b) { return b.material().restitution; })
      .def_property_readonly("friction", [](const Body& b) { return b.material().friction; })
      .def_property_readonly("rolling_friction_m",
                             [](const Body& b) { return b.material().rolling_friction_m; })
      .def_property_readonly("spin_friction_m", [](const Body& b) { return b.material().spin_friction_m; });

  m.def(
      "convex_hull",
      [](const Array& points) {
        const std::vector<Vec3> in = to_points(points, "vertices_m");
        Hull hull;
        {
          py::gil_scoped_release release;
          hull = convex_hull(in);
        }
        return py::make_tuple(from_points(hull.vertices), from_triangles(hull.triangles), hull.flat);
      },
      py::arg("points"),
      "Points (n, 3) to (vertices (m, 3), outward triangles (k, 3), flat). No triangles where flat.");
  m.def(
      "mass_properties",
      [](const Array& vertices_m,
         const py::array_t<int, py::array::c_style | py::array::forcecast>& triangles, double density_kg_m3) {
        const std::vector<Vec3> vertices = to_points(vertices_m, "vertices_m");
        const std::vector<Triangle> faces = to_triangles(triangles);
        MassProperties properties;
        {
          py::gil_scoped_release release;
          properties = mass_properties(vertices, faces, density_kg_m3);
        }
        return from_mass_properties(properties);
      },
      py::arg("vertices_m"), py::arg("triangles"), py::arg("density_kg_m3"),
      "Of the solid inside a closed mesh: (volume_m3, centre_of_mass_m (3,), inertia_kg_m2 (3, 3)).");
  m.def(
      "rounded_hull_mass_properties",
      [](const Array& vertices_m, double radius_m, double density_kg_m3, const Array& rings_m) {
        const std::vector<Vec3> vertices = to_points(vertices_m, "vertices_m");
        std::vector<Ring> rings = to_rings(rings_m);
        MassProperties properties;
        {
          py::gil_scoped_release release;
          check_rings(rings);
          properties = rounded_hull_mass_properties(vertices, radius_m, density_kg_m3, rings);
        }
        return from_mass_properties(properties);
      },
      py::arg("vertices_m"), py::arg("radius_m"), py::arg("density_kg_m3"),
      py::arg("rings_m") = Array(std::vector<py::ssize_t>{0, 7}),
      "Of the hull of the vertices and rings rounded by radius_m: (volume_m3, centre_of_mass_m (3,), "
      "inertia_kg_m2 (3, 3)).");
}

State to_state(const Array& position_m, const Array& quaternion_wxyz, const Array& velocity_m_s,
               const Array& angular_velocity_rad_s) {
  State s;
  s.position = to_vec3(position_m, "position_m");
  if (quaternion_wxyz.ndim() != 1 || quaternion_wxyz.size() != 4)
    throw ArgumentError("quaternion_wxyz: needs shape (4,)");
  const double* q = quaternion_wxyz.data();
  s.orientation = Quat(q[0], q[1], q[2], q[3]);
  s.velocity = to_vec3(velocity_m_s, "velocity_m_s");
  s.angular_velocity = to_vec3(angular_velocity_rad_s, "angular_velocity_rad_s");
  return s;
}

const char* status_name(RunStatus status) {
  switch (status) {
    case RunStatus::rest:
      return "rest";
    case RunStatus::time_limit:
      return "time_limit";
    case RunStatus::failed:
      return "failed";
    case RunStatus::contact:
      return "contact";
    default:
      return "impact_limit";
  }
}

// (status, rest_s, times (n,), states, hits)
py::tuple from_run(const Body& body, const Run& run) {
  std::vector<double> times;
  std::vector<State> states;
  for (const Node& node : run.nodes) {
    times.push_back(node.time_s);
    states.push_back(to_body(body, node.state));
  }
  return py::make_tuple(status_name(run.status), run.rest_s, from_vector(times), from_states(states),
                        from_hits(run.hits));
}

// In principal axes; throws ArgumentError where no simulation can begin.
State to_start(const Body& body, const Array& position_m, const Array& quaternion_wxyz,
               const Array& velocity_m_s, const Array& angular_velocity_rad_s) {
  const State state =
      to_principal(body, to_state(position_m, quaternion_wxyz, velocity_m_s, angular_velocity_rad_s));
  const std::string why = unfit_start(body, state);
  if (!why.empty()) throw ArgumentError(why);
  return state;
}

void bind_simulation(py::module_& m) {
  m.def(
      "fly",
      [](const Body& body, const Array& position_m, const Array& quaternion_wxyz, const Array& velocity_m_s,
         const Array& angular_velocity_rad_s, const Array& times_s, const Array& gravity_m_s2) {
        const State state = to_state(position_m, quaternion_wxyz, velocity_m_s, angular_velocity_rad_s);
        const std::vector<double> times = to_vector(times_s, "times_s");
        const Vec3 gravity = to_vec3(gravity_m_s2, "gravity_m_s2");
        std::vector<State> states;
        {
          const py::gil_scoped_release release;
          Flight flight(body);
          flight.start(to_principal(body, state), gravity);
          for (const double t : times) states.push_back(to_body(body, flight.at(t)));
        }
        return from_states(states);
      },
      py::arg("body"), py::arg("position_m"), py::arg("quaternion_wxyz"), py::arg("velocity_m_s"),
      py::arg("angular_velocity_rad_s"), py::arg("times_s"), py::arg("gravity_m_s2"));
  m.def(
      "simulate",
      [](const Body& body, const Array& position_m, const Array& quaternion_wxyz, const Array& velocity_m_s,
         const Array& angular_velocity_rad_s, double step_s, double until_s, const Array& gravity_m_s2,
         const std::shared_ptr<Progress>& progress, bool sustained_contact) {
        const State state = to_start(body, position_m, quaternion_wxyz, velocity_m_s, angular_velocity_rad_s);
        SimulationOptions options;
        options.sustained_contact = sustained_contact;
        options.step_s = step_s;
        options.gravity_m_s2 = to_vec3(gravity_m_s2, "gravity_m_s2");
        return from_run(body, run_interruptible<Run>(progress, [&](Progress* p) {
                          return simulate(body, state, options, until_s, p);
                        }));
      },
      py::arg("body"), py::arg("position_m"), py::arg("quaternion_wxyz"), py::arg("velocity_m_s"),
      py::arg("angular_velocity_rad_s"), py::arg("step_s"), py::arg("until_s"), py::arg("gravity_m_s2"),
      py::arg("progress"), py::arg("sustained_contact") = true);
  m.def(
      "simulate_ode",
      [](const Body& body, const Array& position_m, const Array& quaternion_wxyz, const Array& velocity_m_s,
         const Array& angular_velocity_rad_s, double step_s, double until_s, const Array& gravity_m_s2,
         bool skip_flight, const std::shared_ptr<Progress>& progress) {
        const State state = to_start(body, position_m, quaternion_wxyz, velocity_m_s, angular_velocity_rad_s);
        OdeOptions options;
        options.step_s = step_s;
        options.gravity_m_s2 = to_vec3(gravity_m_s2, "gravity_m_s2");
        options.skip_flight = skip_flight;
        return from_run(body, run_interruptible<Run>(progress, [&](Progress* p) {
                          return simulate_ode(body, state, options, until_s, p);
                        }));
      },
      py::arg("body"), py::arg("position_m"), py::arg("quaternion_wxyz"), py::arg("velocity_m_s"),
      py::arg("angular_velocity_rad_s"), py::arg("step_s"), py::arg("until_s"), py::arg("gravity_m_s2"),
      py::arg("skip_flight"), py::arg("progress"));
}

}  // namespace

py::tuple from_samples(const std::vector<State>& samples) {
  std::vector<Vec3> positions, velocities, spins;
  std::vector<Quat> orientations;
  for (const State& s : samples) {
    positions.push_back(s.position);
    orientations.push_back(s.orientation);
    velocities.push_back(s.velocity);
    spins.push_back(s.angular_velocity);
  }
  return py::make_tuple(from_points(positions), from_quaternions(orientations), from_points(velocities),
                        from_points(spins));
}

py::tuple from_states(std::vector<State> states) {
  for (std::size_t i = 1; i < states.size(); ++i)  // q and -q are one rotation; keep w continuous
    if (states[i].orientation.dot(states[i - 1].orientation) < 0.0) states[i].orientation.coeffs() *= -1.0;
  return from_samples(states);
}

py::tuple from_hits(const std::vector<Hit>& hits) {
  std::vector<double> times, speeds;
  std::vector<Vec3> impulses, positions;
  for (const Hit& h : hits) {
    times.push_back(h.time_s);
    impulses.push_back(h.impulse_n_s);
    speeds.push_back(h.approach_speed_m_s);
    positions.push_back(h.position_m);
  }
  return py::make_tuple(from_vector(times), from_points(impulses), from_vector(speeds),
                        from_points(positions));
}

void bind_rigid(py::module_& m) {
  bind_body(m);
  bind_simulation(m);
}

}  // namespace ifa::bindings
