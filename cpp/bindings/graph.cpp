// The database of the contact-event graph.
#include "ifa/graph/build.hpp"
#include "ifa/graph/replay.hpp"
#include "ifa/graph/solve.hpp"

#include "connections.hpp"
#include "solution.hpp"
#include "states.hpp"

namespace ifa::bindings {
namespace {

// Read-only views of the mapped columns; each keeps the database.
py::dict columns(const std::shared_ptr<Database>& database) {
  py::dict out;
  const py::object owner = py::cast(database);
  Nodes::each(database->nodes(), [&]<class T>(std::span<const T> column, int width, const char* name) {
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(column.size()) / width};
    if (width > 1) shape.push_back(width);
    py::array_t<T> array(shape, column.data(), owner);
    array.attr("flags").attr("writeable") = false;
    out[name] = array;
  });
  return out;
}

// As of a run from the onset: (when it began to rest or None, times, states, hits).
py::tuple replay(const Database& database, std::size_t i, const std::shared_ptr<Progress>& progress) {
  Record record;
  const Passage passage =
      run_interruptible<Passage>(progress, [&](Progress* p) { return replay_edge(database, i, record, p); });
  const bool edge = (database.nodes().flags[i] & kEdge) != 0;
  std::vector<double> times;
  std::vector<State> states;
  for (const Node& node : record.nodes) {
    times.push_back(node.time_s);
    states.push_back(to_body(database.body(), node.state));
  }
  if (edge) {
    for (const State* state : {&passage.onset.before, &passage.onset.after}) {
      times.push_back(passage.interval_s);
      states.push_back(to_body(database.body(), *state));
    }
    record.hits.push_back(passage.onset.hit);
    record.hits.back().time_s = passage.interval_s;
  }
  const py::object rest_s = edge ? py::object(py::none()) : py::float_(passage.rest_s);
  return py::make_tuple(rest_s, from_vector(times), from_states(states), from_hits(record.hits));
}

Recipe to_recipe(std::uint64_t seed, bool contact, double merge_gap_s, double cone_rad,
                 std::pair<double, double> speed_m_s, std::pair<double, double> spin_rad_s, double until_s) {
  Recipe recipe;
  recipe.seed = seed;
  recipe.physics.hearing.events = contact ? Events::contact : Events::audible;
  recipe.physics.hearing.merge_gap_s = merge_gap_s;
  recipe.sampling = {cone_rad, speed_m_s.first, speed_m_s.second, spin_rad_s.first, spin_rad_s.second};
  recipe.until_s = until_s;
  return recipe;
}

}  // namespace

void bind_graph(py::module_& m) {
  bind_connections(m);
  auto& replay_error = py::register_exception<ReplayError>(m, "ReplayError", m.attr("IfaError"));
  replay_error.doc() = "An edge of a database does not lead where it led when the database was built.";
  m.attr("SIMULATED_SHARE") = kSimulatedShare;
  py::class_<Database, std::shared_ptr<Database>>(m, "Database")
      .def_property_readonly("columns", &columns)
      .def_property_readonly("nodes", [](const Database& d) { return d.nodes().size(); })
      .def_property_readonly("simulations", &Database::simulations)
      .def_property_readonly("body", [](const Database& d) { return std::make_shared<Body>(d.body()); })
      .def_property_readonly("seed", [](const Database& d) { return d.recipe().seed; })
      .def_property_readonly("contact",
                             [](const Database& d) { return d.physics().hearing.events == Events::contact; })
      .def_property_readonly("merge_gap_s", [](const Database& d) { return d.physics().hearing.merge_gap_s; })
      .def_property_readonly("until_s", [](const Database& d) { return d.recipe().until_s; })
      .def_property_readonly("sampling",
                             [](const Database& d) {
                               const SamplingOptions& s = d.recipe().sampling;
                               py::dict out;
                               out["cone_rad"] = s.cone_rad;
                               out["speed_m_s"] = std::pair(s.least_speed_m_s, s.most_speed_m_s);
                               out["spin_rad_s"] = std::pair(s.least_spin_rad_s, s.most_spin_rad_s);
                               return out;
                             })
      .def("need_body", &Database::need_body)
      .def(
          "check",
          [](const Database& d, int threads, const std::shared_ptr<Progress>& progress) {
            run_interruptible<bool>(progress, [&](Progress* p) {
              d.check(threads, p);
              return true;
            });
          },
          py::arg("threads"), py::arg("progress"))
      .def("replay", &replay, py::arg("node"), py::arg("progress"));
  m.attr("GRAPH_RUNGS") = graph_rung_count();
  py::class_<ContactGraph, std::shared_ptr<ContactGraph>>(m, "ContactGraph")
      .def_property_readonly("transitions",
                             [](const ContactGraph& g) { return g.transitions().target.size(); });
  m.def(
      "make_graph",
      [](const Database& database, double energy_gain_j, int threads,
         const std::shared_ptr<Progress>& progress) {
        return std::make_shared<ContactGraph>(run_interruptible<ContactGraph>(
            progress, [&](Progress* p) { return ContactGraph::of(database, energy_gain_j, threads, p); }));
      },
      py::arg("database"), py::arg("energy_gain_j"), py::arg("threads"), py::arg("progress"));
  m.def(
      "solve_graph",
      [](const ContactGraph& graph, const Marks& marks, double time_budget_s, int rung, int takes,
         double energy_gain_j, double lead_in_s, bool branch_and_bound,
         const std::shared_ptr<Progress>& progress, const std::map<std::string, bool>& forced,
         std::size_t states, std::size_t neighbours, std::size_t children) {
        const GraphOptions options{time_budget_s,
                                   rung,
                                   takes,
                                   energy_gain_j,
                                   lead_in_s,
                                   branch_and_bound ? GraphSearch::branch_and_bound : GraphSearch::layered,
                                   to_forced(forced),
                                   {states, neighbours, children}};
        return from_solution(run_interruptible<Solution>(
            progress, [&](Progress* p) { return solve_graph(graph, marks, options, p); }));
      },
      py::arg("graph"), py::arg("marks"), py::kw_only(), py::arg("time_budget_s"), py::arg("rung"),
      py::arg("takes"), py::arg("energy_gain_j"), py::arg("lead_in_s"), py::arg("branch_and_bound"),
      py::arg("progress"), py::arg("forced") = std::map<std::string, bool>{},
      py::arg("states") = GraphSizes{}.states, py::arg("neighbours") = GraphSizes{}.neighbours,
      py::arg("children") = GraphSizes{}.children);
  m.def(
      "open_database",
      [](const std::string& path) { return std::make_shared<Database>(Database::open(path)); },
      py::call_guard<py::gil_scoped_release>());
  m.def(
      "build_database",
      [](const Body& body, const std::string& path, std::uint64_t simulations, std::uint64_t seed,
         int threads, bool contact, double merge_gap_s, double cone_rad, std::pair<double, double> speed_m_s,
         std::pair<double, double> spin_rad_s, double until_s, const std::shared_ptr<Progress>& progress) {
        const Recipe recipe = to_recipe(seed, contact, merge_gap_s, cone_rad, speed_m_s, spin_rad_s, until_s);
        return std::make_shared<Database>(run_interruptible<Database>(progress, [&](Progress* p) {
          return build_database(body, recipe, path, simulations, threads, p);
        }));
      },
      py::arg("body"), py::arg("path"), py::kw_only(), py::arg("simulations"), py::arg("seed"),
      py::arg("threads"), py::arg("contact"), py::arg("merge_gap_s"), py::arg("cone_rad"),
      py::arg("speed_m_s"), py::arg("spin_rad_s"), py::arg("until_s"), py::arg("progress"));
}

}  // namespace ifa::bindings
