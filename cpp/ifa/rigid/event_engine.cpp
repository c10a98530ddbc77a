#include "ifa/rigid/event_engine.hpp"

#include <algorithm>

#include "ifa/rigid/views.hpp"

namespace ifa {
namespace {

const lanes::Kernels& one = lanes::kScalarKernels;

Phase phase_of(lanes::Stage stage) {
  switch (stage) {
    case lanes::Stage::flight:
      return Phase::flight;
    case lanes::Stage::contact:
      return Phase::contact;
    default:
      return Phase::rest;
  }
}

}  // namespace

EventSimulation::EventSimulation(const Body& body, const SimulationOptions& options)
    : body_(view_of(body)), settings_(settings_of(body, options)) {}

void EventSimulation::start(const State& state, double time_s, std::vector<Node>* nodes,
                            std::vector<Load>* loads, const Progress* progress) {
  sim_ = begin_sim(body_, settings_, state, time_s);
  nodes_ = nodes;
  loads_ = loads;
  progress_ = progress;
  record();
}

State EventSimulation::state() const { return state_of(sim_); }

void EventSimulation::record() {
  if (nodes_) nodes_->push_back({sim_.time_s, state(), phase_of(sim_.stage)});
}

double EventSimulation::separation_speed() const { return one.separation_speed(body_, sim_); }

double EventSimulation::approach_speed() const { return std::max(0.0, -separation_speed()); }

EventSimulation::Stop EventSimulation::advance(double until_s) {
  sim_.until_s = until_s;
  lanes::Sim* const sims[1] = {&sim_};
  lanes::Stop stop = lanes::Stop::none;
  for (;;) {
    if (progress_) progress_->throw_if_cancelled();
    if (sim_.stage == lanes::Stage::flight) {
      one.fly(body_, settings_, sims, 1, &stop);
      if (stop == lanes::Stop::none) continue;
      return stop == lanes::Stop::impact ? Stop::impact : Stop::time_limit;
    }
    if (!settings_.sustained_contact) return Stop::contact;
    lanes::LoadData load;
    const double before_s = sim_.time_s;
    one.step(body_, settings_, sims, 1, &stop, &load);
    if (loads_ && sim_.time_s > before_s)
      loads_->push_back({load.begin_s, load.length_s, load.normal_impulse, load.slip_speed});
    if (stop == lanes::Stop::impact) return Stop::impact;
    if (stop == lanes::Stop::time_limit) return Stop::time_limit;
    record();
    if (stop == lanes::Stop::rest) return Stop::rest;
  }
}

Hit EventSimulation::resolve() {
  if (nodes_ && (nodes_->empty() || nodes_->back().time_s != sim_.time_s)) record();
  lanes::Sim* const sims[1] = {&sim_};
  lanes::HitData data;
  one.resolve(body_, settings_, sims, 1, &data);
  record();
  return {sim_.time_s, Eigen::Map<const Vec3>(data.impulse), data.approach_speed,
          Eigen::Map<const Vec3>(data.position)};
}

Run simulate(const Body& body, const State& state, const SimulationOptions& options, double until_s,
             const Progress* progress) {
  Run run;
  EventSimulation simulation(body, options);
  simulation.start(state, 0.0, &run.nodes, nullptr, progress);
  bool strikes = simulation.approach_speed() > 0.0;
  for (;;) {
    if (strikes) {
      run.hits.push_back(simulation.resolve());
      if (static_cast<int>(run.hits.size()) >= options.max_impacts) {
        run.status = RunStatus::impact_limit;
        break;
      }
    }
    const auto stop = simulation.advance(until_s);
    strikes = stop == EventSimulation::Stop::impact;
    if (strikes) continue;
    run.status = stop == EventSimulation::Stop::rest      ? RunStatus::rest
                 : stop == EventSimulation::Stop::contact ? RunStatus::contact
                                                          : RunStatus::time_limit;
    run.rest_s = run.status == RunStatus::rest ? simulation.rest_s() : 0.0;
    if (run.status == RunStatus::time_limit && simulation.time_s() > run.nodes.back().time_s)
      run.nodes.push_back({simulation.time_s(), simulation.state(), run.nodes.back().phase});
    break;
  }
  // A last line: nothing known leads here, and no numbers are passed off that are none.
  if (!is_finite(simulation.state())) {
    run.status = RunStatus::failed;
    while (run.nodes.size() > 1 && !is_finite(run.nodes.back().state)) run.nodes.pop_back();
  }
  return run;
}

}  // namespace ifa
