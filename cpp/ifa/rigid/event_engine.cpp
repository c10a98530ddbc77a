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
constexpr double kLargestTurn = 0.05;    // rad in one step of sustained contact
constexpr double kStepTolerance = 1e-8;  // m/s, of the contact problem in a step
constexpr int kStepSweeps = 100;
constexpr double kSoftLanding = 0.1;  // of the micro speed: a slower landing is no impact

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

bool EventSimulation::almost_at_rest() const {
  return state_.velocity.norm() + state_.angular_velocity.norm() * body_->bounding_radius_m() <
         options_.rest_speed_m_s;
}

// Points just above the ground may come down to it within the step, and no further: a rim settles as a whole,
// where point after point would cut it into landings without end.
void EventSimulation::add_settling_points(const Quat& predicted, double length_s) {
  const double near = 2.0 * length_s * (options_.rest_speed_m_s + options_.gravity_m_s2.norm() * length_s);
  const Vec3 up = state_.orientation.conjugate() * kUp;
  const auto& vertices = body_->principal_vertices();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (touches_[i]) continue;
    const double h = state_.position.z() - body_->radius_m() + up.dot(vertices[i]);
    if (h > near) continue;
    ContactPoint p;
    p.arm = predicted * vertices[i] - body_->radius_m() * kUp;
    p.vertex = static_cast<int>(i);
    p.target_speed = -h / length_s;
    points_.push_back(p);
  }
}

// One step with the touching points held above the ground. Forces are evaluated at the predicted pose, so
// that a pivot's centripetal force turns with it; positions advance by the mean velocity (exact for free
// fall).
EventSimulation::Step EventSimulation::try_step(double length_s) {
  const State& s = state_;
  State next = s;
  const Quat predicted = (rotation_exp(s.angular_velocity * length_s) * s.orientation).normalized();
  next.velocity = s.velocity + length_s * options_.gravity_m_s2;
  const Mat3 inverse_inertia = inverse_inertia_world(*body_, predicted);
  if (!body_->isotropic()) {  // the angular momentum stays, the inertia turns
    const Vec3 spin = s.orientation.conjugate() * s.angular_velocity;
    next.angular_velocity = inverse_inertia * (s.orientation * body_->principal_inertia().cwiseProduct(spin));
  }
  const Material& material = body_->material();
  const ContactBody problem{body_->mass_kg(), inverse_inertia, material.friction, material.rolling_friction_m,
                            material.spin_friction_m};
  choose_bearing(predicted);
  for (ContactPoint& p : points_) p.impulse = length_s * forces_[p.vertex];
  const bool settling = almost_at_rest();
  if (settling) add_settling_points(predicted, length_s);
  solver_.solve(problem, points_, next.velocity, next.angular_velocity, kStepTolerance, kStepSweeps);

  Step step{next, 0.0, 0.0, 0};
  holding_.clear();
  for (const ContactPoint& p : points_) {
    const Vec3 v = next.velocity + next.angular_velocity.cross(p.arm);
    if (p.impulse.z() > 0.0) {
      step.normal_impulse += p.impulse.z();
      step.slip_speed = std::max(step.slip_speed, v.head<2>().norm());
      ++step.loaded;
    }
    if (touches_[p.vertex] && (p.impulse.z() > 0.0 || v.z() <= 1e-7)) holding_.push_back(p.vertex);
  }
  // What settles stops exactly on the ground only if it moves by the velocity that the constraint bounds.
  const double old_share = settling ? 0.0 : 0.5;
  const Vec3 velocity = old_share * s.velocity + (1.0 - old_share) * next.velocity;
  const Vec3 spin = old_share * s.angular_velocity + (1.0 - old_share) * next.angular_velocity;
  step.state.position = s.position + length_s * velocity;
  step.state.orientation = (rotation_exp(length_s * spin) * s.orientation).normalized();
  return step;
}

double EventSimulation::approach_of(const State& state, int vertex) const {
  const Vec3 arm = state.orientation * body_->principal_vertices()[vertex] - body_->radius_m() * kUp;
  return -(state.velocity.z() + state.angular_velocity.cross(arm).z());
}

double EventSimulation::lowest_newcomer(const State& state, int* vertex) const {
  const Vec3 up = state.orientation.conjugate() * kUp;
  const double z = state.position.z() - body_->radius_m();
  double lowest = kNever;
  const auto& vertices = body_->principal_vertices();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (touches_[i]) continue;
    const double h = z + up.dot(vertices[i]);
    if (h < lowest) {
      lowest = h;
      *vertex = static_cast<int>(i);
    }
  }
  return lowest;
}

// Moves the pose so that held points are on the ground and none is below: the least change in the metric of
// the mass matrix, by Gauss-Seidel. Undoes the step's second-order drift.
void EventSimulation::project(State& state, int newcomer) {
  if (newcomer >= 0) holding_.push_back(newcomer);
  const auto& vertices = body_->principal_vertices();
  // Holding some points may push others below the ground: those are then held too.
  for (int round = 0; round < 4; ++round) {
    hold_on_ground(state);
    const Vec3 up = state.orientation.conjugate() * kUp;
    const double z = state.position.z() - body_->radius_m();
    const std::size_t held = holding_.size();
    double lowest = 0.0;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const double h = z + up.dot(vertices[i]);
      lowest = std::min(lowest, h);
      const int vertex = static_cast<int>(i);
      if (h < -touch_m_ && std::find(holding_.begin(), holding_.end(), vertex) == holding_.end())
        holding_.push_back(vertex);
    }
    if (holding_.size() > held && round < 3) continue;
    state.position.z() -= lowest;
    return;
  }
}

void EventSimulation::hold_on_ground(State& state) const {
  const auto& vertices = body_->principal_vertices();
  const Mat3 inverse_inertia = inverse_inertia_world(*body_, state.orientation);
  const double inverse_mass = 1.0 / body_->mass_kg();
  for (int round = 0; round < 3; ++round) {
    const Mat3 r = state.orientation.toRotationMatrix();
    const double z = state.position.z() - body_->radius_m();
    double rise = 0.0, worst = 0.0;
    Vec3 turn = Vec3::Zero();
    for (int sweep = 0; sweep < 30; ++sweep) {
      double change = 0.0;
      for (const int i : holding_) {
        const Vec3 p = r * vertices[i];
        const Vec3 lever(p.y(), -p.x(), 0.0);  // arm x up
        const double h = z + p.z() + rise + turn.dot(lever);
        if (sweep == 0) worst = std::max(worst, std::abs(z + p.z()));
        const Vec3 response = inverse_inertia * lever;
        const double push = -h / (inverse_mass + lever.dot(response));
        rise += push * inverse_mass;
        turn += push * response;
        change = std::max(change, std::abs(h));
      }
      if (change <= 1e-3 * touch_m_) break;
    }
    state.position.z() += rise;
    state.orientation = (rotation_exp(turn) * state.orientation).normalized();
    if (worst <= 0.1 * touch_m_) break;
  }
}

double EventSimulation::energy(const State& state) const {
  return kinetic_energy(*body_, state) - body_->mass_kg() * options_.gravity_m_s2.dot(state.position);
}

// Sustained contact never adds energy: what the step's error added is taken from the velocities.
void EventSimulation::limit_energy(State& state) const {
  const double excess = energy(state) - energy(state_);
  if (excess <= 0.0) return;
  const double kinetic = kinetic_energy(*body_, state);
  const double scale = kinetic > excess ? std::sqrt(1.0 - excess / kinetic) : 0.0;
  state.velocity *= scale;
  state.angular_velocity *= scale;
}

std::optional<EventSimulation::Stop> EventSimulation::advance_contact(double until_s) {
  if (time_s_ >= until_s) return Stop::time_limit;
  find_touching();
  if (touching_.empty()) {
    enter(Phase::flight);
    return std::nullopt;
  }
  const double spin = state_.angular_velocity.norm();
  double length = std::min({options_.step_s, until_s - time_s_, kLargestTurn / std::max(spin, 1e-9)});
  Step step = try_step(length);
  int newcomer = -1;
  double clearance = lowest_newcomer(step.state, &newcomer);
  if (clearance < 0.0 &&
      (almost_at_rest() || approach_of(step.state, newcomer) < kSoftLanding * options_.micro_speed_m_s)) {
    newcomer = -1;  // no impact: the projection holds it, and from the next step on it is a touching point
  } else if (clearance < 0.0) {
    // A point lands within the step: find the step that ends as it touches (regula falsi, Illinois).
    double low = 0.0, high = length, h_high = clearance;
    const double landing_m = 1e-6 * body_->bounding_radius_m();  // the projection closes the rest
    int ignored = -1, moved = 0;
    double h_low = std::max(lowest_newcomer(state_, &ignored), 0.1 * touch_m_);
    for (int i = 0; i < 40 && std::abs(clearance) > landing_m; ++i) {
      length = std::clamp((low * h_high - high * h_low) / (h_high - h_low), low, high);
      if (length <= 1e-12) break;
      step = try_step(length);
      clearance = lowest_newcomer(step.state, &newcomer);
      if (clearance < 0.0) {
        high = length;
        h_high = clearance;
        if (moved > 0) h_low *= 0.5;
        moved = 1;
      } else {
        low = length;
        h_low = clearance;
        if (moved < 0) h_high *= 0.5;
        moved = -1;
      }
    }
  } else {
    newcomer = -1;
  }
  for (const ContactPoint& p : points_) forces_[p.vertex] = p.impulse / length;
  project(step.state, newcomer);
  limit_energy(step.state);
  if (loads_) loads_->push_back({time_s_, length, step.normal_impulse, step.slip_speed});
  state_ = step.state;
  time_s_ += length;
  if (newcomer >= 0) {
    find_touching();
    slow_ = slow_ && approach_speed() < options_.rest_speed_m_s;
    if (approach_speed() > 0.0) return Stop::impact;
    record(Phase::contact);
    return std::nullopt;
  }
  if (check_rest(step, length)) {
    state_.velocity.setZero();
    state_.angular_velocity.setZero();
    phase_ = Phase::rest;
    record(Phase::rest);
    return Stop::rest;
  }
  record(Phase::contact);
  return std::nullopt;
}

bool EventSimulation::check_rest(const Step& step, double length_s) {
  const double speed = state_.velocity.norm() + state_.angular_velocity.norm() * body_->bounding_radius_m();
  if (speed >= options_.rest_speed_m_s || step.loaded == 0) {
    slow_ = false;
    still_steps_ = 0;
    return false;
  }
  if (!slow_) {
    slow_ = true;
    slow_since_s_ = time_s_ - length_s;
  }
  // On three points, or on one round one, standing still is for good: no need to watch it for 50 ms.
  const bool stable = step.loaded >= 3 || (body_->vertices().size() == 1);
  still_steps_ = stable && speed < 1e-3 * options_.rest_speed_m_s ? still_steps_ + 1 : 0;
  return still_steps_ >= 3 || (time_s_ - slow_since_s_ >= options_.rest_duration_s && supported());
}

// Whether the mass centre is over the touching points: seen from above, they leave no gap of more than half a
// turn around it. A body that balances on an edge for a moment is not at rest.
bool EventSimulation::supported() const {
  const double near = 1e-3 * body_->bounding_radius_m();
  std::vector<double> angles;
  for (const int i : touching_) {
    const Vec3 arm = state_.orientation * body_->principal_vertices()[i];
    if (arm.head<2>().norm() <= near) return true;
    angles.push_back(std::atan2(arm.y(), arm.x()));
  }
  if (angles.size() < 2) return false;
  std::sort(angles.begin(), angles.end());
  double gap = angles.front() + 2.0 * std::numbers::pi - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  return gap <= std::numbers::pi + 1e-3;
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
