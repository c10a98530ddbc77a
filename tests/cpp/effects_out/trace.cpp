#include "trace.hpp"

#include <array>
#include <cstdint>

#include "ifa/rigid/batch.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

void add(std::vector<double>& out, const State& s) {
  for (const double x : s.position) out.push_back(x);
  for (const double x : s.orientation.coeffs()) out.push_back(x);
  for (const double x : s.velocity) out.push_back(x);
  for (const double x : s.angular_velocity) out.push_back(x);
}

void add_flights(std::vector<double>& out, const Body& body, const std::vector<State>& states) {
  Flight flight(body);
  for (const State& s : states) {
    flight.start(s, sample::downwards());
    add(out, flight.at(0.3));
    out.push_back(flight.next_contact(2.0));
  }
}

void add_runs(std::vector<double>& out, const Body& body, const std::vector<State>& states,
              const SimulationOptions& options) {
  for (const State& s : states) {
    const ifa::Run run = simulate(body, s, options, 2.0);
    for (const Node& node : run.nodes) {
      out.push_back(node.time_s);
      add(out, node.state);
    }
    for (const Hit& hit : run.hits) {
      for (const double x : hit.impulse_n_s) out.push_back(x);
      out.push_back(hit.approach_speed_m_s);
    }
  }
}

void add_batch(std::vector<double>& out, const Body& body, const std::vector<State>& states,
               const SimulationOptions& simulation, const char* set) {
  const std::size_t n = states.size();
  std::vector<double> end(n), position(3 * n), quaternion(4 * n), velocity(3 * n), spin(3 * n);
  BatchOutputs outputs;
  outputs.end_time_s = end, outputs.position_m = position, outputs.quaternion_wxyz = quaternion;
  outputs.velocity_m_s = velocity, outputs.angular_velocity_rad_s = spin;
  BatchOptions options;
  options.simulation = simulation;
  options.until_s = 2.0;
  options.threads = 1;
  options.instruction_set = set;
  const std::array bodies{&body};
  simulate_batch(bodies, states, options, outputs);
  for (const auto* values : {&end, &position, &quaternion, &velocity, &spin})
    out.insert(out.end(), values->begin(), values->end());
}

}  // namespace

std::vector<double> trace() {
  std::vector<double> out;
  SimulationOptions options;
  options.sustained_contact = false;
  const Material material{0.6, 0.3, 5e-5, 5e-5};
  for (const Body& body :
       {sample::ball(0.02, 0.03, material), sample::box({0.02, 0.02, 0.02}, 0.01, material)}) {
    std::vector<State> states;
    for (std::uint64_t i = 0; i < 60; ++i) {
      RandomStream random(3, i);
      states.push_back(sample::random_state(body, random, 0.05, 1.0, 40.0));
    }
    add_flights(out, body, states);
    add_runs(out, body, states, options);
    for (const std::string_view set : instruction_sets())
      if (set == "scalar" || set == "sse2") add_batch(out, body, states, options, set.data());
  }
  return out;
}

}  // namespace ifa
