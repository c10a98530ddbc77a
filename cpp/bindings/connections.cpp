// Connections of the graph, made by themselves: what their tolerance costs.
#include "connections.hpp"

#include "ifa/graph/connection.hpp"
#include "ifa/graph/connection_problems.hpp"
#include "ifa/graph/paper_shooting.hpp"
#include "ifa/rigid/flight.hpp"
#include "ifa/rigid/views.hpp"

namespace ifa::bindings {
namespace {

const Vec3 kGravity(0.0, 0.0, -9.81);

struct Shots {
  std::vector<Vec3> spins_rad;  // at the start, principal axes, times the duration
  std::vector<bool> converged;
  std::vector<int> iterations;

  void add(const Vec3& spin_rad, bool did, int steps) {
    spins_rad.push_back(spin_rad);
    converged.push_back(did);
    iterations.push_back(steps);
  }
};

class Connections {
 public:
  Connections(const Body& body, std::uint64_t seed, std::size_t simulations, std::size_t count)
      : body_(body), problems_(draw_connection_problems(body, seed, simulations, count, kGravity)) {}

  Shots connect(double tolerance_rad) const {
    const Connector connector(body_);
    Shots shots;
    for (const ConnectionProblem& p : problems_) {
      const Connection c = connector.connect(p.from, p.like, p.to, p.duration_s, kGravity, tolerance_rad);
      shots.add(c.shooting.spin_rad, c.converged(), c.shooting.iterations);
    }
    return shots;
  }

  Shots connect_as_paper(double tolerance_rad, int most_iterations) const {
    const lanes::BodyView view = view_of(body_);
    Shots shots;
    for (const ConnectionProblem& p : problems_) {
      const Quat &q0 = p.from.orientation, &q1 = p.like.orientation;
      const Vec3 guess = p.duration_s * paper_guess(view, q0, q0.conjugate() * p.from.angular_velocity, q1,
                                                    q1.conjugate() * p.like.angular_velocity);
      const PaperShooting s =
          shoot_as_paper(view, q0.conjugate() * p.to.orientation, guess, tolerance_rad, most_iterations);
      shots.add(s.spin_rad, s.converged, s.iterations);
    }
    return shots;
  }

  // The angles between the targets and where flights with these spins end.
  std::vector<double> missed_rad(const std::vector<Vec3>& spins_rad) const {
    if (spins_rad.size() != problems_.size())
      throw ArgumentError("spins_rad: needs one for each of the " + std::to_string(problems_.size()) +
                          " connections");
    std::vector<double> missed;
    Flight flight(body_);
    for (std::size_t k = 0; k < problems_.size(); ++k) {
      const ConnectionProblem& p = problems_[k];
      State start = p.from;
      start.angular_velocity = start.orientation * (spins_rad[k] / p.duration_s);
      flight.start(start, kGravity);
      const Quat end = flight.at(p.duration_s).orientation;
      missed.push_back(rotation_log(p.to.orientation.conjugate() * end).norm());
    }
    return missed;
  }

 private:
  Body body_;
  std::vector<ConnectionProblem> problems_;
};

py::tuple from_shots(const Shots& shots) {
  return py::make_tuple(from_points(shots.spins_rad), shots.converged, shots.iterations);
}

}  // namespace

void bind_connections(py::module_& m) {
  m.attr("SHOOTING_TOLERANCE_RAD") = kShootingTolerance_rad;
  py::class_<Connections>(m, "Connections", "Random connections of a body that are to be made.")
      .def(py::init<const Body&, std::uint64_t, std::size_t, std::size_t>(), py::arg("body"), py::kw_only(),
           py::arg("seed"), py::arg("simulations"), py::arg("count"),
           py::call_guard<py::gil_scoped_release>())
      // (spins (n, 3), converged (n,), iterations (n,))
      .def(
          "connect", [](const Connections& c, double tol) { return from_shots(c.connect(tol)); },
          py::arg("tolerance_rad"))
      .def(
          "connect_as_paper",
          [](const Connections& c, double tol, int most) {
            return from_shots(c.connect_as_paper(tol, most));
          },
          py::arg("tolerance_rad"), py::arg("most_iterations"))
      .def(
          "missed_rad",
          [](const Connections& c, const Array& spins_rad) {
            return from_vector(c.missed_rad(to_points(spins_rad, "spins_rad")));
          },
          py::arg("spins_rad"));
}

}  // namespace ifa::bindings
