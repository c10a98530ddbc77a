#include "ifa/rigid/engine_ode.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ifa/base/error.hpp"
#include "ifa/rigid/flight.hpp"
#include "ifa/rigid/ode_contacts.hpp"

namespace ifa {
namespace {

// Scaled units, in which the body's radius is in [1, 4), its mass in [1, 2) and gravity keeps its number. All
// are powers of two (the length's of four), so that scaling is exact: a body scaled by these has the same
// bits.
struct Units {
  double length_m = 1.0, time_s = 1.0, mass_kg = 1.0;

  explicit Units(const Body& body) {
    const int power_of_four = std::ilogb(body.bounding_radius_m()) >> 1;
    length_m = std::ldexp(1.0, 2 * power_of_four);
    time_s = std::ldexp(1.0, power_of_four);
    mass_kg = std::ldexp(1.0, std::ilogb(body.mass_kg()));
  }
  double speed() const { return length_m / time_s; }
  double impulse() const { return mass_kg * speed(); }

  State scaled(State s) const {
    s.position /= length_m;
    s.velocity /= speed();
    s.angular_velocity *= time_s;
    return s;
  }
  State si(State s) const {
    s.position *= length_m;
    s.velocity *= speed();
    s.angular_velocity /= time_s;
    return s;
  }
  OdeBody scaled(const Body& body) const {
    const Material m = body.contact_material();
    OdeBody out{body.mass_kg() / mass_kg,
                body.radius_m() / length_m,
                body.bounding_radius_m() / length_m,
                body.principal_inertia() / (mass_kg * length_m * length_m),
                body.principal_vertices(),
                body.principal_rings(),
                m.restitution,
                m.friction,
                m.rolling_friction_m / length_m,
                m.spin_friction_m / length_m};
    for (Vec3& v : out.vertices) v /= length_m;
    for (Ring& ring : out.rings) ring.centre_m /= length_m, ring.radius_m /= length_m;
    return out;
  }
};

// In scaled units. A step's arithmetic stays far from overflow below it.
constexpr double kLargestSpeed = 1e30;
// Of sqrt(g R): how fast a penetration is undone, and so how far a body may hop from it, 1/200 of its radius.
constexpr double kCorrectingShare = 0.1;
// Of the radius. A vertex touches while it is within g h^2 of the ground on either side: what a step's
// rotation lifts it by and a step of free fall lowers it by.
constexpr double kLargestMargin = 0.01;

class OdeSimulation {
 public:
  OdeSimulation(const Body& body, const OdeOptions& options);
  Run run(const State& start, double until_s, const Progress* progress);

 private:
  bool sane() const;
  void record(Phase phase);
  void advance(double length_s) { time_s_ = length_s == until_s_ - time_s_ ? until_s_ : time_s_ + length_s; }
  bool fly(double length_s);
  bool touch(double length_s);
  bool strike(OdeStep step, double approach);
  bool bounce(const OdeStep& step, std::span<double> normal_forces);
  bool rests(double length_s);

  OdeOptions options_;
  Units units_;
  OdeBody body_;
  OdeWorld world_;
  OdeContacts contacts_;
  Flight flight_;
  State state_;  // scaled, as gravity and margin are
  Vec3 gravity_;
  double margin_;
  double time_s_ = 0.0, until_s_ = 0.0, slow_since_s_ = 0.0;
  bool slow_ = false;
  int still_steps_ = 0;
  std::vector<double> forces_;
  Run run_;
};

OdeSimulation::OdeSimulation(const Body& body, const OdeOptions& options)
    : options_(options),
      units_(body),
      body_(units_.scaled(body)),
      world_(body_.mass, body_.inertia, options.gravity_m_s2),
      contacts_(body_),
      flight_(body),
      gravity_(options.gravity_m_s2) {
  const double step = options.step_s / units_.time_s;
  margin_ = std::min(gravity_.norm() * step * step, kLargestMargin * body_.reach);
}

bool OdeSimulation::sane() const {
  const auto bounded = [](const Vec3& v) { return v.squaredNorm() < kLargestSpeed * kLargestSpeed; };
  return bounded(state_.position) && bounded(state_.velocity) && bounded(state_.angular_velocity) &&
         state_.orientation.coeffs().allFinite();  // not a number is not bounded either
}

void OdeSimulation::record(Phase phase) {
  if (!run_.nodes.empty() && run_.nodes.back().time_s == time_s_)
    run_.nodes.back().phase = phase;
  else
    run_.nodes.push_back({time_s_, units_.si(state_), phase});
}

// To the next contact or the end, or by a step.
bool OdeSimulation::fly(double length_s) {
  slow_ = false;
  if (options_.skip_flight) {
    flight_.start(units_.si(state_), options_.gravity_m_s2);
    const double limit = until_s_ - time_s_, length = flight_.next_contact(limit);
    const bool lands = length <= limit && length < kNever;
    if (!lands && limit == kNever) {
      time_s_ = kNever;
      return true;
    }
    state_ = units_.scaled(flight_.at(lands ? length : limit));
    advance(lands ? length : limit);
    world_.set(state_);
  } else {
    if (!world_.step({.length = length_s / units_.time_s}, {})) return false;
    state_ = world_.get();
    advance(length_s);
  }
  return sane();
}

// A step with contacts. An impact, where flight is skipped, takes no time.
bool OdeSimulation::touch(double length_s) {
  OdeStep step;
  step.length = length_s / units_.time_s;
  step.erp = options_.erp;
  step.layer = margin_;
  step.correcting_speed = kCorrectingShare * std::sqrt(gravity_.norm() * body_.reach);
  step.bounce_speed = options_.micro_speed_m_s / units_.speed();
  const double approach = contacts_.approach_speed(state_);
  if (approach > step.bounce_speed) {
    step.instant = options_.skip_flight;
    if (!strike(step, approach)) return false;
    if (!step.instant) advance(length_s);
    return true;
  }
  step.torque = contacts_.friction_torque(state_, step.length, gravity_);
  if (!world_.step(step, contacts_.make(state_, step.length, gravity_, options_.cfm, false))) return false;
  state_ = world_.get();
  advance(length_s);
  return sane();
}

bool OdeSimulation::strike(OdeStep step, double approach) {
  const State before = state_;
  forces_.resize(contacts_.arms().size());
  if (!bounce(step, forces_)) return false;
  Hit hit;
  hit.time_s = time_s_;
  hit.approach_speed_m_s = approach * units_.speed();
  hit.impulse_n_s = body_.mass * (state_.velocity - before.velocity) * units_.impulse();
  Vec3 moment = Vec3::Zero();
  double sum = 0.0;
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    moment += forces_[i] * contacts_.arms()[i];
    sum += forces_[i];
  }
  const Vec3 centre = sum > 0.0 ? Vec3(moment / sum) : contacts_.arms().front();
  hit.position_m = (before.position + centre) * units_.length_m;
  run_.hits.push_back(hit);
  State after = before;
  after.velocity = state_.velocity;
  after.angular_velocity = state_.angular_velocity;
  run_.nodes.push_back({time_s_, units_.si(after), Phase::contact});
  if (step.instant) {
    state_ = after;
    world_.set(state_);
  }
  return sane();
}

// Newton's restitution with friction can add energy. Where the contacts would do work, the velocities are
// blended towards those of no restitution until they do none. Their work is the gain of kinetic energy beyond
// that of gravity over the step, at the mean velocity.
bool OdeSimulation::bounce(const OdeStep& step, std::span<double> normal_forces) {
  const State before = state_;
  const Vec3 gravity = step.instant ? Vec3(Vec3::Zero()) : gravity_;
  const auto kinetic = [&](const Vec3& velocity, const Vec3& angular_velocity) {
    return body_.kinetic_energy(velocity, angular_velocity, before.orientation);
  };
  const auto work = [&](const State& after) {
    return kinetic(after.velocity, after.angular_velocity) -
           kinetic(before.velocity, before.angular_velocity) -
           0.5 * body_.mass * step.length * gravity.dot(before.velocity + after.velocity);
  };
  std::vector<OdeContact> contacts = contacts_.make(before, step.length, gravity, options_.cfm, true);
  if (!world_.step(step, contacts, normal_forces)) return false;
  state_ = world_.get();
  const double gain = work(state_);
  if (!(gain > 0.0)) return true;

  for (OdeContact& c : contacts) c.restitution = 0.0;
  std::vector<double> plastic_forces(normal_forces.size());
  world_.set(before);
  OdeStep gentle = step;
  gentle.erp = 0.0;
  if (!world_.step(gentle, contacts, plastic_forces)) return false;
  const State plastic = world_.get();
  const Vec3 dv = state_.velocity - plastic.velocity, dw = state_.angular_velocity - plastic.angular_velocity;
  // The work is a parabola in the share of the restitution: `low` at 0, above 0 by rounding only, `gain`
  // at 1.
  const double low = std::min(0.0, work(plastic));
  const double a = kinetic(dv, dw), b = gain - low - a;
  const double root = std::sqrt(std::max(0.0, b * b - 4.0 * a * low));
  double share = b > 0.0 ? -2.0 * low / (b + root) : (root - b) / (2.0 * a);
  share = std::clamp(share * (1.0 - 1e-15), 0.0, 1.0);
  state_.velocity = plastic.velocity + share * dv;
  state_.angular_velocity = plastic.angular_velocity + share * dw;
  state_.position = before.position + step.length * state_.velocity;
  state_.orientation =
      (rotation_exp(step.length * state_.angular_velocity) * before.orientation).normalized();
  world_.set(state_);
  for (std::size_t i = 0; i < normal_forces.size(); ++i)
    normal_forces[i] = plastic_forces[i] + share * (normal_forces[i] - plastic_forces[i]);
  return true;
}

// As the event engine's: slow for long enough and supported, or standing still on three points or a ball's
// one; and no longer pushed out of the ground.
bool OdeSimulation::rests(double length_s) {
  const double speed =
      (state_.velocity.norm() + state_.angular_velocity.norm() * body_.reach) * units_.speed();
  if (speed >= options_.rest_speed_m_s || contacts_.depth(state_) > 2.0 * margin_) {
    slow_ = false;
    still_steps_ = 0;
    return false;
  }
  if (!slow_) {
    slow_ = true;
    slow_since_s_ = time_s_ - length_s;
  }
  still_steps_ = contacts_.stable() && speed < 1e-3 * options_.rest_speed_m_s ? still_steps_ + 1 : 0;
  return still_steps_ >= 3 || (time_s_ - slow_since_s_ >= options_.rest_duration_s && contacts_.supported());
}

Run OdeSimulation::run(const State& start, double until_s, const Progress* progress) {
  constexpr int kStepsBetweenLooks = 256;
  const auto end = [&](RunStatus status) {
    run_.status = status;
    return std::move(run_);
  };
  until_s_ = until_s;
  run_.nodes.push_back({0.0, start, Phase::flight});
  state_ = units_.scaled(start);
  if (!sane()) return end(RunStatus::failed);
  world_.set(state_);
  bool flying = false;
  for (int i = 0;; ++i) {
    if (progress && i % kStepsBetweenLooks == 0) progress->throw_if_cancelled();
    if (time_s_ == kNever) return end(RunStatus::time_limit);  // it will not come down
    const double left = until_s - time_s_;
    // No step of next to nothing at the end.
    const double length_s = left < options_.step_s * (1.0 + 1e-6) ? left : options_.step_s;
    contacts_.find(state_, margin_, options_.step_s / units_.time_s);
    const bool flew = std::exchange(flying, contacts_.empty());
    if (!flew || !flying || left <= 0.0) record(flying ? Phase::flight : Phase::contact);
    if (left <= 0.0) return end(RunStatus::time_limit);
    const double before_s = time_s_;
    if (!(flying ? fly(length_s) : touch(length_s))) return end(RunStatus::failed);
    if (static_cast<int>(run_.hits.size()) >= options_.max_impacts) return end(RunStatus::impact_limit);
    if (!flying && time_s_ > before_s && rests(length_s)) {
      state_.velocity.setZero();
      state_.angular_velocity.setZero();
      record(Phase::rest);
      run_.rest_s = slow_since_s_;
      return end(RunStatus::rest);
    }
  }
}

void need(bool condition, const char* message) {
  if (!condition) throw ArgumentError(message);
}

}  // namespace

Run simulate_ode(const Body& body, const State& state, const OdeOptions& options, double until_s,
                 const Progress* progress) {
  need(std::isfinite(options.step_s) && options.step_s > 0.0, "step_s: must be finite and above 0");
  need(options.gravity_m_s2.allFinite() && !options.gravity_m_s2.isZero(0.0),
       "gravity_m_s2: must be finite and not zero");
  need(options.erp >= 0.0 && options.erp <= 0.2, "erp: must lie between 0 and 0.2");
  need(options.cfm > 0.0 && options.cfm <= 1e-2, "cfm: must be above 0 and at most 0.01");
  need(until_s >= 0.0, "until_s: must be 0 or more");
  need(until_s < kNever || options.gravity_m_s2.z() < 0.0,
       "gravity_m_s2: must point down, or until_s be given");
  return OdeSimulation(body, options).run(state, until_s, progress);
}

}  // namespace ifa
