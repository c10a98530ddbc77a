#include "ifa/forward/start.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "ifa/forward/root.hpp"
#include "ifa/forward/steer.hpp"
#include "ifa/motion/sampling.hpp"

namespace ifa {

StartOptions start_options(const Body& body, const Marks& marks, double gravity_m_s2) {
  StartOptions options{0.5, 4.0, 0.03};
  double longest = 0.0;
  for (std::size_t k = 1; k < marks.size(); ++k)
    longest = std::max(longest, marks.times_s[k] - marks.times_s[k - 1]);
  // A gap T of free flight leaves the ground at g T / 2, after an impact 1 / e times as fast.
  const double bounce = std::max(body.material().restitution, 0.2);
  options.most_speed_m_s = std::max(4.0, 0.75 * gravity_m_s2 * longest / bounce);
  for (const OrientationConstraint& c : marks.constraints.orientations)
    if (c.mark == 0 && !options.facing) options.facing = c;
  return options;
}

namespace {

bool flies_before(const Body& body, const SearchPhysics& physics, const StartOptions& options,
                  const State& s) {
  return options.clear_s == 0.0 ||
         clear_before(body, s, physics.simulation.gravity_m_s2, options.clear_s) >= options.clear_s;
}

bool usable(const Body& body, const SearchPhysics& physics, const StartOptions& options, const State& s) {
  EventSimulation at(body, physics.simulation);
  at.start(s, 0.0);
  return at.approach_speed() >= physics.least_onset_speed_m_s() && flies_before(body, physics, options, s);
}

// Turns a touching body, so that it faces as it shall and touches again.
void face(const Body& body, const OrientationConstraint& facing, State& s) {
  const Vec3 now = seen(body, s, facing.body_direction.stableNormalized());
  s.orientation = (rotation_exp(turn_to(now, facing.direction)) * s.orientation).normalized();
  s.position.z() = 0.0;
  s.position.z() = -lowest_gap_m(body, s);
}

}  // namespace

std::optional<State> sample_start(const Body& body, const SearchPhysics& physics, const StartOptions& options,
                                  RandomStream& random) {
  State s = sample_touching(body, random);
  if (options.facing) face(body, *options.facing, s);
  constexpr double kDegree = std::numbers::pi / 180.0;
  const bool thrown = random.uniform() < 0.5;
  const double cone = (thrown ? 80.0 : 30.0) * kDegree;
  const Vec3 direction = sample_downward(cone, random);
  const double speed = random.uniform(options.least_speed_m_s, options.most_speed_m_s);
  s.velocity = speed * direction;
  const double most_spin = thrown ? std::max(20.0, speed / body.bounding_radius_m()) : 20.0;
  Vec3 axis = random.unit_vector();
  if (thrown)
    axis = (kUp.cross(s.velocity).normalized() + 0.5 * axis).normalized();  // mostly rolling forwards
  s.angular_velocity = axis * random.uniform(0.0, most_spin);

  if (!usable(body, physics, options, s)) return std::nullopt;
  return s;
}

std::optional<State> sample_touchdown(const Body& body, const SearchPhysics& physics,
                                      const StartOptions& options, RandomStream& random) {
  State drop = sample_touching(body, random);
  drop.velocity.z() = -random.uniform(0.1, 1.0);
  constexpr double kLongestDrop_s = 5.0;
  SimulationOptions brief = physics.simulation;
  brief.max_impacts = 300;  // a drop that chatters on is given up
  const Run run = simulate(body, drop, brief, kLongestDrop_s);
  if (run.status != RunStatus::rest) return std::nullopt;
  const double tilt = std::pow(10.0, random.uniform(-4.0, -1.0));
  State s;
  s.orientation =
      (rotation_exp(tilt * random.unit_vector()) * run.nodes.back().state.orientation).normalized();
  s.position.z() = -lowest_gap_m(body, s);
  s.velocity = Vec3(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2),
                    -0.06 * std::pow(1.0 / 0.06, random.uniform()));
  s.angular_velocity = Vec3(0.0, 0.0, random.uniform(-3.0, 3.0));
  if (!usable(body, physics, options, s)) return std::nullopt;
  return s;
}

namespace {

constexpr int kRefinements = 8;
constexpr double kOnTime_s = 1e-5;

// What came of a speed.
struct Seen : RootPoint {  // x is the speed, value the lateness
  State next;              // where the second mark was met
  Vec3 spin;               // on the way there
};

// A start whose speed along its heading is still sought.
struct Throw {
  State state;
  Vec3 heading;
  double sampled = 0.0;  // speed
  std::vector<Seen> seen = {};
  std::optional<Bracket> bracket = {};
  double trial = 0.0;           // speed to be looked at next; 0: none
  Vec3 carried = Vec3::Zero();  // velocity besides that along the heading

  Vec3 velocity(double speed) const { return carried + speed * heading; }
};

// Looks at the trial speeds of all throws side by side.
void look(const Problem& problem, Passages& passages, std::vector<Throw>& throws, const Progress* progress) {
  const double target = problem.target_s(0);
  std::vector<State> before;
  std::vector<std::size_t> owner;
  for (std::size_t i = 0; i < throws.size(); ++i) {
    if (throws[i].trial <= 0.0) continue;
    owner.push_back(i);
    before.push_back(throws[i].state);
    before.back().velocity = throws[i].velocity(throws[i].trial);
  }
  std::vector<Onset> onsets(before.size());
  passages.strike(before, onsets);
  std::vector<Departure> departures;
  for (const Onset& onset : onsets)
    departures.push_back({onset.hit, onset.after, problem.marks.durations_s[0], kLateShare * target});
  std::vector<Passage> arrivals(departures.size());
  passages.run(departures, arrivals, progress);
  for (std::size_t j = 0; j < owner.size(); ++j) {
    Throw& t = throws[owner[j]];
    const double speed = std::exchange(t.trial, 0.0);
    if (onsets[j].hit.approach_speed_m_s < problem.physics.least_onset_speed_m_s()) {
      t.bracket.reset();
      continue;
    }
    const bool hit = arrivals[j].hits();
    t.seen.push_back({{speed, hit ? arrivals[j].interval_s - target : kNever},
                      arrivals[j].onset.before,
                      onsets[j].after.angular_velocity});
  }
}

// The speed at which the second mark is met best; null if there is none.
const Seen* best_of(const Throw& t) {
  const Seen* best = nullptr;
  for (const Seen& p : t.seen)
    if (std::isfinite(p.value) && (!best || std::abs(p.value) < std::abs(best->value))) best = &p;
  return best;
}

double best_speed(const Throw& t) {
  const Seen* best = best_of(t);
  return best ? best->x : 0.0;
}

void choose_speeds(const Problem& problem, Passages& passages, const StartOptions& start,
                   std::vector<Throw>& throws, const Progress* progress) {
  const double least = start.least_speed_m_s, most = start.most_speed_m_s;
  for (int trial = 0; trial < 5; ++trial) {
    for (Throw& t : throws) {
      if (t.bracket) continue;
      const double sampled = t.sampled;
      const double speeds[] = {sampled, 0.5 * (sampled + most), 0.5 * (sampled + least), most, least};
      t.trial = speeds[trial];
    }
    look(problem, passages, throws, progress);
    for (Throw& t : throws) {
      if (t.bracket) continue;
      std::stable_sort(t.seen.begin(), t.seen.end(), [](const Seen& a, const Seen& b) { return a.x < b.x; });
      for (std::size_t i = 0; i + 1 < t.seen.size() && !t.bracket; ++i)
        if ((t.seen[i].value > 0.0) != (t.seen[i + 1].value > 0.0))
          t.bracket.emplace(t.seen[i], t.seen[i + 1]);
    }
  }
  for (int refinement = 0; refinement < kRefinements; ++refinement) {
    for (Throw& t : throws)
      if (t.bracket) t.trial = t.bracket->next();
    look(problem, passages, throws, progress);
    for (Throw& t : throws) {
      if (!t.bracket) continue;
      t.bracket->add(t.seen.back());
      if (std::abs(t.seen.back().value) <= kOnTime_s) t.bracket.reset();
    }
  }
}

// Throws that meet the second mark are thrown again so that they also come as far as its position is from the
// first one's, by their velocity along the ground, and face as they shall there, by their spin. The speed
// downwards then has to be chosen anew.
void steer_throws(const Problem& problem, const Body& body, Passages& passages, const StartOptions& start,
                  std::vector<Throw>& throws, const Progress* progress) {
  constexpr int kRounds = 3;
  constexpr double kFreely_m_s = 10.0, kFreely_rad_s = 1000.0, kSlowest_m_s = 0.05;
  const Aim aim(problem.marks, body, 1);
  if (!aim.any()) return;
  const double target = problem.target_s(0);
  const auto lost = [](const Throw& t) { return !best_of(t); };
  if (std::ranges::all_of(throws, lost)) return;
  std::erase_if(throws, lost);
  for (int round = 0; round < kRounds; ++round) {
    for (Throw& t : throws) {
      const Seen* best = best_of(t);
      if (!best) continue;  // lost by the round before
      const Vec3 velocity = t.velocity(best->x);
      Alignment before;
      before.add(problem.marks.constraints, 0, body, t.state);
      // A start may be changed as it likes: the units make its change cost next to nothing.
      Mat36 velocities = Mat36::Zero(), spins = Mat36::Zero();
      velocities.topLeftCorner<2, 2>() = kFreely_m_s * Mat2::Identity();
      spins.rightCols<3>() = kFreely_rad_s * Mat3::Identity();
      const Arrival arrival(best->next, best->spin, target, velocities, spins);
      const Vec6 y = aim.step(before, arrival, Vec6::Zero(), kNever, {}).y;
      t.carried = velocity + velocities * y;
      t.carried.z() = 0.0;
      t.state.angular_velocity += spins * y;
      t.heading = -kUp;
      t.sampled = std::max(-velocity.z(), kSlowest_m_s);
      t.seen.clear();
      t.bracket.reset();
    }
    choose_speeds(problem, passages, start, throws, progress);
  }
}

}  // namespace

void begin_candidates(const Problem& problem, int body_index, Passages& passages,
                      std::span<RandomStream> random, std::vector<Candidate>& out, const Progress* progress) {
  const Body& body = problem.bodies[static_cast<std::size_t>(body_index)];
  const Marks& marks = problem.marks;
  StartOptions start = start_options(body, marks, problem.physics.simulation.gravity_m_s2.norm());
  if (!problem.plan.on(Effect::pre_roll_flight)) start.clear_s = 0.0;
  const bool single = marks.size() == 1;
  std::vector<Throw> throws;
  for (RandomStream& r : random) {
    if (progress) progress->throw_if_cancelled();
    const auto sampled = single && marks.ending == Ending::rest
                             ? sample_touchdown(body, problem.physics, start, r)
                             : sample_start(body, problem.physics, start, r);
    if (sampled) throws.push_back({*sampled, sampled->velocity.normalized(), sampled->velocity.norm()});
  }
  std::vector<State> states;
  bool any = single;
  if (!single) {
    choose_speeds(problem, passages, start, throws, progress);
    if (problem.plan.constrains()) steer_throws(problem, body, passages, start, throws, progress);
    for (const Throw& t : throws) any |= best_speed(t) > 0.0;
  }
  for (const Throw& t : throws) {
    State s = t.state;
    const double speed = single ? 0.0 : best_speed(t);
    if (any && !single) {
      if (speed == 0.0) continue;
      s.velocity = t.velocity(speed);
      constexpr double kTooFast = 2.0;  // the first impact takes some
      if (s.velocity.head<2>().norm() > kTooFast * problem.travel_budget_m_s(body_index, 0)) continue;
      if (!flies_before(body, problem.physics, start, s)) continue;
    }
    states.push_back(s);
  }
  std::vector<Onset> onsets(states.size());
  passages.strike(states, onsets);
  for (const Onset& onset : onsets) {
    Candidate candidate;
    candidate.onset = onset;
    candidate.body = body_index;
    candidate.constrain(problem, 0);
    out.push_back(candidate);
  }
}

}  // namespace ifa
