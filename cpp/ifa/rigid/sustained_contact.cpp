// Sustained contact of the event engine: steps with the touching points held on the ground, landings within a
// step, and coming to rest.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "ifa/rigid/event_engine.hpp"

namespace ifa {
namespace {

constexpr double kLargestTurn = 0.05;    // rad in one step
constexpr double kStepTolerance = 1e-8;  // m/s, of the contact problem in a step
constexpr int kStepSweeps = 100;
constexpr double kSoftLanding = 0.1;  // of the micro speed: a slower landing is no impact

}  // namespace

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

}  // namespace ifa
