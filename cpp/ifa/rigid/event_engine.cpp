#include "ifa/rigid/event_engine.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace ifa {
namespace {

// Of the body's size: points this near to the ground touch it. Above the rounding of the flight's root and
// the projection's tolerance, far below anything visible.
constexpr double kTouchShare = 1e-8;

}  // namespace

EventSimulation::EventSimulation(const Body& body, const SimulationOptions& options)
    : body_(&body), options_(options), flight_(body), touch_m_(kTouchShare * body.bounding_radius_m()) {
  touches_.resize(body.vertices().size());
  forces_.resize(body.vertices().size(), Vec3::Zero());
}

void EventSimulation::start(const State& state, double time_s, std::vector<Node>* nodes,
                            std::vector<Load>* loads) {
  state_ = state;
  time_s_ = time_s;
  nodes_ = nodes;
  loads_ = loads;
  slow_ = false;
  still_steps_ = 0;
  std::fill(forces_.begin(), forces_.end(), Vec3::Zero());
  find_touching();
  choose_phase();
}

void EventSimulation::record(Phase phase) {
  if (nodes_) nodes_->push_back({time_s_, state_, phase});
}

void EventSimulation::enter(Phase phase) {
  phase_ = phase;
  if (phase == Phase::flight) {
    flight_.start(state_, options_.gravity_m_s2);
    flight_start_s_ = time_s_;
    slow_ = false;
  }
  record(phase);
}

void EventSimulation::find_touching() {
  touching_.clear();
  const Vec3 up = state_.orientation.conjugate() * kUp;
  const double z = state_.position.z() - body_->radius_m();
  const auto& vertices = body_->principal_vertices();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    touches_[i] = z + up.dot(vertices[i]) <= touch_m_;
    if (touches_[i]) touching_.push_back(static_cast<int>(i));
  }
}

// The points that impulses act on: all that touch, or of a whole rim those furthest out in eight directions
// (the others lie within their span) and the one that approaches fastest.
void EventSimulation::choose_bearing(const Quat& orientation) {
  constexpr std::size_t kFew = 8;
  points_.clear();
  const auto add = [&](int vertex, const Vec3& arm) {
    ContactPoint p;
    p.arm = arm;
    p.vertex = vertex;
    points_.push_back(p);
  };
  const auto arm_of = [&](int i) {
    return Vec3(orientation * body_->principal_vertices()[i] - body_->radius_m() * kUp);
  };
  if (touching_.size() <= kFew) {
    for (const int i : touching_) add(i, arm_of(i));
    return;
  }
  std::array<int, kFew + 1> chosen;
  std::array<double, kFew + 1> best;
  best.fill(-kNever);
  for (const int i : touching_) {
    const Vec3 arm = arm_of(i);
    const double d = std::numbers::sqrt2 / 2.0, x = arm.x(), y = arm.y();
    const std::array<double, kFew + 1> reach = {
        x,           d * (x + y), y,
        d * (y - x), -x,          -d * (x + y),
        -y,          d * (x - y), -state_.angular_velocity.cross(arm).z()};
    for (std::size_t k = 0; k < reach.size(); ++k)
      if (reach[k] > best[k]) {
        best[k] = reach[k];
        chosen[k] = i;
      }
  }
  std::sort(chosen.begin(), chosen.end());
  const auto end = std::unique(chosen.begin(), chosen.end());
  for (auto i = chosen.begin(); i != end; ++i) add(*i, arm_of(*i));
}

double EventSimulation::separation_speed() const {
  double least = kNever;
  for (const int i : touching_) {
    least = std::min(least, -approach_of(state_, i));
  }
  return least;
}

double EventSimulation::approach_speed() const { return std::max(0.0, -separation_speed()); }

// Points that neither bounce nor fall off need sustained contact. The slowest bounce that `resolve` gives
// leaves at restitution times the micro speed; the floor is above rounding.
void EventSimulation::choose_phase() {
  constexpr double kLeastBounce = 1e-6;  // m/s
  const double bounce =
      std::max(kLeastBounce, 0.999 * body_->material().restitution * options_.micro_speed_m_s);
  enter(separation_speed() < bounce ? Phase::contact : Phase::flight);
}

EventSimulation::Stop EventSimulation::advance(double until_s) {
  for (;;) {
    if (phase_ == Phase::flight) return advance_flight(until_s);
    if (const auto stop = advance_contact(until_s)) return *stop;
  }
}

EventSimulation::Stop EventSimulation::advance_flight(double until_s) {
  const double length = flight_.next_contact(until_s - flight_start_s_);
  if (flight_start_s_ + length > until_s || length == kNever) {
    if (until_s < kNever) {
      state_ = flight_.at(until_s - flight_start_s_);
      time_s_ = until_s;
    }
    return Stop::time_limit;
  }
  state_ = flight_.at(length);
  time_s_ = flight_start_s_ + length;
  find_touching();
  return Stop::impact;
}

Hit EventSimulation::resolve() {
  Hit hit;
  hit.time_s = time_s_;
  hit.approach_speed_m_s = approach_speed();
  if (nodes_ && (nodes_->empty() || nodes_->back().time_s != time_s_)) record(phase_);
  choose_bearing(state_.orientation);
  const ImpactResult result = resolve_impact(*body_, options_.micro_speed_m_s, solver_, points_, state_);
  hit.impulse_n_s = result.impulse_n_s;
  hit.position_m = result.position_m;
  choose_phase();
  return hit;
}

Run simulate(const Body& body, const State& state, const SimulationOptions& options, double until_s,
             const Progress* progress) {
  Run run;
  EventSimulation simulation(body, options);
  simulation.start(state, 0.0, &run.nodes);
  if (simulation.approach_speed() > 0.0) run.hits.push_back(simulation.resolve());
  for (;;) {
    if (progress) progress->throw_if_cancelled();
    const auto stop = simulation.advance(until_s);
    if (stop == EventSimulation::Stop::impact) {
      run.hits.push_back(simulation.resolve());
      if (static_cast<int>(run.hits.size()) < options.max_impacts) continue;
      run.status = RunStatus::impact_limit;
      return run;
    }
    run.status = stop == EventSimulation::Stop::rest ? RunStatus::rest : RunStatus::time_limit;
    run.rest_s = run.status == RunStatus::rest ? simulation.rest_s() : 0.0;
    if (run.status == RunStatus::time_limit && simulation.time_s() > run.nodes.back().time_s)
      run.nodes.push_back({simulation.time_s(), simulation.state(), run.nodes.back().phase});
    return run;
  }
}

}  // namespace ifa
