#include "ifa/rigid/engine_ode.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "ifa/base/error.hpp"
#include "ifa/rigid/flight.hpp"
#include "ifa/rigid/ode_world.hpp"

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
  double inertia() const { return mass_kg * length_m * length_m; }
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
};

// In scaled units. A step's arithmetic stays far from overflow below it.
constexpr double kLargestSpeed = 1e30;
// Of sqrt(g R): how fast a penetration is undone, and so how far a body may hop from it: 1/200 of its radius.
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
  void find_touching();
  void choose_bearing();
  void make_contacts(double length, bool impact);
  Vec3 friction_torque(double length) const;
  double approach_speed() const;
  bool step_contact(double length_s);
  bool step_bouncing(const OdeStep& step, std::span<double> normal_forces);
  double kinetic(const Vec3& velocity, const Vec3& angular_velocity, const Quat& orientation) const;
  void record(Phase phase);
  bool rests(double length_s);
  bool supported() const;

  const Body* body_;
  OdeOptions options_;
  Units units_;
  // scaled
  double mass_, radius_, reach_, gravity_down_, margin_ = 0.0;
  Vec3 inertia_, gravity_;
  std::vector<Vec3> vertices_;
  OdeWorld world_;
  Flight flight_;
  State state_;
  std::vector<int> touching_;
  std::vector<Vec3> arms_;  // from the centre of mass to the contacts
  std::vector<OdeContact> contacts_;
  std::vector<double> forces_;
  // SI
  double time_s_ = 0.0, slow_since_s_ = 0.0;
  bool slow_ = false;
  int still_steps_ = 0;
  Run run_;
};

OdeSimulation::OdeSimulation(const Body& body, const OdeOptions& options)
    : body_(&body),
      options_(options),
      units_(body),
      mass_(body.mass_kg() / units_.mass_kg),
      radius_(body.radius_m() / units_.length_m),
      reach_(body.bounding_radius_m() / units_.length_m),
      gravity_down_(std::max(0.0, -options.gravity_m_s2.z())),
      inertia_(body.principal_inertia() / units_.inertia()),
      gravity_(options.gravity_m_s2),
      world_(mass_, inertia_, gravity_),
      flight_(body) {
  const double step = options.step_s / units_.time_s;
  margin_ = std::min(gravity_.norm() * step * step, kLargestMargin * reach_);
  for (const Vec3& v : body.principal_vertices()) vertices_.push_back(v / units_.length_m);
}

bool OdeSimulation::sane() const {
  const auto bounded = [](const Vec3& v) { return v.squaredNorm() < kLargestSpeed * kLargestSpeed; };
  return bounded(state_.position) && bounded(state_.velocity) && bounded(state_.angular_velocity) &&
         state_.orientation.coeffs().allFinite();  // not a number is not bounded either
}

void OdeSimulation::record(Phase phase) { run_.nodes.push_back({time_s_, units_.si(state_), phase}); }

// Contacts straight from the vertices, however far below the ground: a thin plate has no side to fall out of.
void OdeSimulation::find_touching() {
  touching_.clear();
  const double z = state_.position.z() - radius_;
  if (z + radius_ - reach_ > margin_) return;
  const Vec3 up = state_.orientation.conjugate() * kUp;
  for (std::size_t i = 0; i < vertices_.size(); ++i)
    if (z + up.dot(vertices_[i]) <= margin_) touching_.push_back(static_cast<int>(i));
}

// A point in the span of others adds only redundant rows: of many, keep those furthest out and down in eight
// directions, and the one that approaches fastest.
void OdeSimulation::choose_bearing() {
  constexpr std::size_t kFew = 4, kDirections = 8;
  const auto arm_of = [&](int i) { return Vec3(state_.orientation * vertices_[i] - radius_ * kUp); };
  if (touching_.size() > kFew) {
    std::array<int, kDirections + 1> chosen{};
    std::array<double, kDirections + 1> best;
    best.fill(-kNever);
    for (const int i : touching_) {
      const Vec3 arm = arm_of(i);
      const double d = std::numbers::sqrt2 / 2.0, x = arm.x(), y = arm.y(), z = arm.z();
      const double sinking = -state_.angular_velocity.cross(arm).z();
      const std::array<double, kDirections + 1> reach = {x - z,           d * (x + y) - z, y - z,
                                                         d * (y - x) - z, -x - z,          -d * (x + y) - z,
                                                         -y - z,          d * (x - y) - z, sinking};
      for (std::size_t k = 0; k < reach.size(); ++k)
        if (reach[k] > best[k]) best[k] = reach[k], chosen[k] = i;
    }
    std::sort(chosen.begin(), chosen.end());
    touching_.assign(chosen.begin(), std::unique(chosen.begin(), chosen.end()));
  }
  arms_.clear();
  for (const int i : touching_) arms_.push_back(arm_of(i));
}

double OdeSimulation::approach_speed() const {
  double fastest = 0.0;
  for (const Vec3& arm : arms_)
    fastest = std::max(fastest, -(state_.velocity + state_.angular_velocity.cross(arm)).z());
  return fastest;
}

void OdeSimulation::make_contacts(double length, bool impact) {
  const Material& material = body_->material();
  const Quat inverse = state_.orientation.conjugate();
  contacts_.clear();
  for (const Vec3& arm : arms_) {
    const auto mobility = [&](const Vec3& direction) {  // J M^-1 J^T of a row
      const Vec3 lever = inverse * arm.cross(direction);
      return 1.0 / mass_ + lever.cwiseProduct(lever).dot(inertia_.cwiseInverse());
    };
    OdeContact c;
    c.position = state_.position + arm;
    c.depth = -c.position.z();
    const Vec3 velocity = state_.velocity + state_.angular_velocity.cross(arm);
    // ODE's friction is a box about two axes. The first is the slip that would be without friction, so that
    // no heading is special. What slides on has no second one, which would hold it against every sideways
    // pull; in an impact, which turns the slip, both together come nearer to the cone.
    const Vec3 pulled = velocity + length * gravity_;
    const Vec3 slip(pulled.x(), pulled.y(), 0.0);
    const double slip_speed = slip.norm();
    if (slip_speed > 0.0) c.slip_direction = slip / slip_speed;
    const double along = mobility(c.slip_direction);
    c.softness = {options_.cfm * length * mobility(kUp), options_.cfm * length * along,
                  options_.cfm * length * mobility(kUp.cross(c.slip_direction))};
    const double stoppable = material.friction * mass_ * gravity_down_ * length * along;
    c.friction = material.friction;
    c.cross_friction = !impact && slip_speed > stoppable ? 0.0 : material.friction;
    c.restitution = impact ? material.restitution : 0.0;
    contacts_.push_back(c);
  }
}

// Rolling and spinning friction under the body's weight. ODE's rows for them, three to a contact, are
// redundant and make its LCP solver fail, so they are a torque here: at most what ends the turning of the
// free body, which the contacts only make slower to turn.
Vec3 OdeSimulation::friction_torque(double length) const {
  const Material& material = body_->material();
  const double weight = mass_ * gravity_down_;
  const Vec3& spin = state_.angular_velocity;
  const auto resist = [&](const Vec3& part, double lever_m) -> Vec3 {
    const double speed = part.norm();
    if (speed == 0.0 || lever_m == 0.0) return Vec3::Zero();
    const Vec3 axis = state_.orientation.conjugate() * part / speed;
    const double stopping = speed / length / axis.cwiseProduct(axis).dot(inertia_.cwiseInverse());
    return part / speed * -std::min(lever_m / units_.length_m * weight, stopping);
  };
  return resist({spin.x(), spin.y(), 0.0}, material.rolling_friction_m) +
         resist({0.0, 0.0, spin.z()}, material.spin_friction_m);
}

double OdeSimulation::kinetic(const Vec3& velocity, const Vec3& angular_velocity,
                              const Quat& orientation) const {
  const Vec3 spin = orientation.conjugate() * angular_velocity;
  return 0.5 * (mass_ * velocity.squaredNorm() + inertia_.dot(spin.cwiseProduct(spin)));
}

// Newton's restitution with friction can add energy. Where the contacts would do work, the velocities are
// blended towards those of no restitution until they do none. Their work is the gain of kinetic energy beyond
// that of gravity over the step, at the mean velocity.
bool OdeSimulation::step_bouncing(const OdeStep& step, std::span<double> normal_forces) {
  const State before = state_;
  const Vec3 weight = mass_ * step.length * gravity_;
  const double kinetic_before = kinetic(before.velocity, before.angular_velocity, before.orientation);
  const auto work = [&](const State& after) {
    return kinetic(after.velocity, after.angular_velocity, before.orientation) - kinetic_before -
           0.5 * weight.dot(before.velocity + after.velocity);
  };
  if (!world_.step(step, contacts_, normal_forces)) return false;
  const State elastic = world_.get();
  const double gain = work(elastic);
  if (!(gain > 0.0)) return true;

  for (OdeContact& c : contacts_) c.restitution = 0.0;
  std::vector<double> plastic_forces(normal_forces.size());
  world_.set(before);
  OdeStep gentle = step;
  gentle.erp = 0.0;
  if (!world_.step(gentle, contacts_, plastic_forces)) return false;
  const State plastic = world_.get();
  const Vec3 dv = elastic.velocity - plastic.velocity,
             dw = elastic.angular_velocity - plastic.angular_velocity;
  // The work is a parabola in the elastic share: `low` at 0, where it can be positive by rounding only, and
  // `gain` at 1.
  const double low = std::min(0.0, work(plastic));
  const double a = kinetic(dv, dw, before.orientation), b = gain - low - a;
  const double root = std::sqrt(std::max(0.0, b * b - 4.0 * a * low));
  double share = b > 0.0 ? -2.0 * low / (b + root) : (root - b) / (2.0 * a);
  share = std::clamp(share * (1.0 - 1e-15), 0.0, 1.0);
  State after = before;
  after.velocity = plastic.velocity + share * dv;
  after.angular_velocity = plastic.angular_velocity + share * dw;
  after.position += step.length * after.velocity;
  after.orientation = (rotation_exp(step.length * after.angular_velocity) * before.orientation).normalized();
  world_.set(after);
  for (std::size_t i = 0; i < normal_forces.size(); ++i)
    normal_forces[i] = plastic_forces[i] + share * (normal_forces[i] - plastic_forces[i]);
  return true;
}

bool OdeSimulation::step_contact(double length_s) {
  OdeStep step;
  step.length = length_s / units_.time_s;
  step.erp = options_.erp;
  step.layer = margin_;
  step.correcting_speed = kCorrectingShare * std::sqrt(gravity_.norm() * reach_);
  step.bounce_speed = options_.micro_speed_m_s / units_.speed();
  choose_bearing();
  const double approach = approach_speed();
  const bool impact = approach > step.bounce_speed;
  make_contacts(step.length, impact);
  if (!impact) {
    step.torque = friction_torque(step.length);
    if (!world_.step(step, contacts_)) return false;
    state_ = world_.get();
    return sane();
  }
  const State before = state_;
  forces_.resize(contacts_.size());
  const bool whole = step_bouncing(step, forces_);
  state_ = world_.get();
  if (!whole || !sane()) return false;
  Hit hit;
  hit.time_s = time_s_;
  hit.approach_speed_m_s = approach * units_.speed();
  hit.impulse_n_s = mass_ * (state_.velocity - before.velocity) * units_.impulse();
  double sum = 0.0;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    hit.position_m += forces_[i] * contacts_[i].position * units_.length_m;
    sum += forces_[i];
  }
  hit.position_m = sum > 0.0 ? Vec3(hit.position_m / sum) : Vec3(contacts_[0].position * units_.length_m);
  run_.hits.push_back(hit);
  State after = before;
  after.velocity = state_.velocity;
  after.angular_velocity = state_.angular_velocity;
  run_.nodes.push_back({time_s_, units_.si(after), Phase::contact});
  return true;
}

// As the event engine's: slow for long enough and supported, or standing still on three points or a round
// one.
bool OdeSimulation::rests(double length_s) {
  const double speed = (state_.velocity.norm() + state_.angular_velocity.norm() * reach_) * units_.speed();
  double depth = 0.0;
  for (const OdeContact& c : contacts_) depth = std::max(depth, c.depth);
  if (speed >= options_.rest_speed_m_s || depth > 2.0 * margin_) {  // still rising, or still being pushed out
    slow_ = false;
    still_steps_ = 0;
    return false;
  }
  if (!slow_) {
    slow_ = true;
    slow_since_s_ = time_s_ - length_s;
  }
  const bool stable = touching_.size() >= 3 || vertices_.size() == 1;
  still_steps_ = stable && speed < 1e-3 * options_.rest_speed_m_s ? still_steps_ + 1 : 0;
  return still_steps_ >= 3 || (time_s_ - slow_since_s_ >= options_.rest_duration_s && supported());
}

// Whether the mass centre is over the touching points: seen from above they leave no gap of more than half a
// turn around it.
bool OdeSimulation::supported() const {
  std::vector<double> angles;
  for (const Vec3& arm : arms_) {
    if (arm.head<2>().norm() <= 1e-3 * reach_) return true;
    angles.push_back(std::atan2(arm.y(), arm.x()));
  }
  if (angles.size() < 2) return false;
  std::sort(angles.begin(), angles.end());
  double gap = angles.front() + 2.0 * std::numbers::pi - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  return gap <= std::numbers::pi + 1e-3;
}

Run OdeSimulation::run(const State& start, double until_s, const Progress* progress) {
  constexpr int kStepsBetweenLooks = 256;
  const auto end = [&](RunStatus status) {
    run_.status = status;
    if (status != RunStatus::failed && status != RunStatus::rest && run_.nodes.back().time_s != time_s_)
      record(run_.nodes.back().phase);
    return std::move(run_);
  };
  state_ = units_.scaled(start);
  run_.nodes.push_back({0.0, start, Phase::flight});
  if (!sane()) return end(RunStatus::failed);
  world_.set(state_);
  bool flying = true;
  for (int i = 0;; ++i) {
    if (progress && i % kStepsBetweenLooks == 0) progress->throw_if_cancelled();
    find_touching();
    if (i == 0) {
      flying = touching_.empty();
      run_.nodes.front().phase = flying ? Phase::flight : Phase::contact;
    } else if (!flying || !touching_.empty()) {
      flying = touching_.empty();
      record(flying ? Phase::flight : Phase::contact);
    }
    if (time_s_ >= until_s) return end(RunStatus::time_limit);
    const double left = until_s - time_s_;
    const bool last = left < options_.step_s * (1.0 + 1e-6);  // no step of next to nothing after it
    const double length_s = last ? left : options_.step_s;
    if (flying) {
      slow_ = false;
      if (options_.skip_flight) {
        flight_.start(units_.si(state_), options_.gravity_m_s2);
        const double length = flight_.next_contact(left);
        const bool lands = length <= left && length < kNever;
        if (!lands && left == kNever) return end(RunStatus::time_limit);
        state_ = units_.scaled(flight_.at(lands ? length : left));
        time_s_ = lands ? time_s_ + length : until_s;
        world_.set(state_);
      } else {
        if (!world_.step({.length = length_s / units_.time_s}, {})) return end(RunStatus::failed);
        state_ = world_.get();
        time_s_ = last ? until_s : time_s_ + length_s;
      }
      if (!sane()) return end(RunStatus::failed);
      continue;
    }
    if (!step_contact(length_s)) return end(RunStatus::failed);
    time_s_ = last ? until_s : time_s_ + length_s;
    if (static_cast<int>(run_.hits.size()) >= options_.max_impacts) return end(RunStatus::impact_limit);
    if (rests(length_s)) {
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
