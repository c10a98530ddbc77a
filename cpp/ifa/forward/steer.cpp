#include "ifa/forward/steer.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/forward/steepest.hpp"

namespace ifa {
namespace {

constexpr int kRealignments =
    8;  // of the placement, which moves with the pose; each costs less than the last
constexpr int kRounds = 2;
constexpr std::size_t kSteered = 4;  // anchors of each candidate in each round
constexpr double kLateWeight = 1e4;  // 1 % of an interval weighs as much as a change at the region's edge
constexpr double kAstray = 0.1;      // of the way between two positions: how far off its line others may be
constexpr double kLeastRise = 1e-3;  // of the height: what a ball or a balanced body takes to tip over
constexpr double kLiesOff = 0.7;     // rad; beyond it a body lies on, or falls to, another face
constexpr double kNear_m = 0.01;     // at least, where f_p halves

// d rotation / d rotation vector, in world axes (the left Jacobian of SO(3)).
Mat3 left_jacobian(const Vec3& turn) {
  const double angle = turn.norm();
  const Mat3 cross = cross_matrix(turn);
  if (angle < 1e-4) return Mat3::Identity() + 0.5 * cross;
  return Mat3::Identity() + (1.0 - std::cos(angle)) / (angle * angle) * cross +
         (angle - std::sin(angle)) / (angle * angle * angle) * cross * cross;
}

}  // namespace

Arrival::Arrival(const State& pose_then, const Vec3& spin, double interval_s, const Mat36& velocities,
                 const Mat36& spins)
    : pose(pose_then),
      position(interval_s * velocities.topRows<2>()),
      turn(interval_s * left_jacobian(interval_s * spin) * spins) {}

namespace {

template <class Offset>
Mat36 columns(Offset&& offset) {
  Mat36 m;
  for (int i = 0; i < 6; ++i) m.col(i) = offset(Vec6(Vec6::Unit(i)));
  return m;
}

}  // namespace

Arrival::Arrival(const State& pose_then, const Vec3& spin, double interval_s, const PlausibleRegion& region)
    : Arrival(pose_then, spin, interval_s, columns([&](const Vec6& y) { return region.velocity_offset(y); }),
              columns([&](const Vec6& y) { return region.spin_offset(y); })) {}

Aim::Aim(const Marks& marks, const Body& body, std::size_t mark) {
  const PositionConstraint *before = nullptr, *after = nullptr;  // the nearest
  for (const PositionConstraint& c : marks.constraints.positions) {
    if (c.mark == mark) position_ = {c.position_m, kPositionWeight};
    if (c.mark < mark && (!before || c.mark > before->mark)) before = &c;
    if (c.mark > mark && (!after || c.mark < after->mark)) after = &c;
  }
  if (!position_ && before && after) {
    const double from = marks.times_s[before->mark], to = marks.times_s[after->mark];
    const double share = (marks.times_s[mark] - from) / (to - from);
    const Vec2 way = after->position_m - before->position_m;
    const double spread = std::max(1.0, kAstray * way.norm() / kNear_m);
    position_ = {before->position_m + share * way, kPositionWeight / (spread * spread)};
  }
  for (const OrientationConstraint& c : marks.constraints.orientations)
    if (c.mark == mark)
      directions_.push_back({body.body_from_principal().conjugate() * c.body_direction.stableNormalized(),
                             c.direction.stableNormalized()});
}

Alignment Aim::with(Alignment alignment, const Vec2& position_m, const std::vector<Vec3>& directions) const {
  if (position_) alignment.add_position(position_m, position_->position_m, position_->weight);
  for (std::size_t i = 0; i < directions.size(); ++i)
    alignment.add_direction(directions[i], directions_[i].world);
  return alignment;
}

Aim::Step Aim::step(const Alignment& before, const Arrival& arrival, const Vec6& y, double radius,
                    const std::optional<Lateness>& lateness) const {
  const Vec2 position = arrival.pose.position.head<2>();
  std::vector<Vec3> directions, now;
  std::vector<Mat36> slopes;
  for (const Direction& d : directions_) {
    directions.push_back(arrival.pose.orientation * d.principal);
    slopes.push_back(-cross_matrix(directions.back()) * arrival.turn);
  }
  // Places and turns of the whole motion are free. With the placement held, the least sum of squares is that
  // of linear equations; a new placement can only lessen it further.
  Vec6 change = Vec6::Zero();
  Alignment then;
  for (int i = 0; i <= kRealignments; ++i) {
    now.clear();
    for (std::size_t d = 0; d < directions.size(); ++d)
      now.push_back((directions[d] + slopes[d] * change).normalized());
    then = with(before, position + arrival.position * change, now);
    if (i == kRealignments) break;
    const Placement placement = then.best();
    Mat6 normal = Mat6::Zero();
    Vec6 moment = Vec6::Zero();
    const auto add = [&](double weight, const auto& slope, const auto& off) {
      normal += weight * slope.transpose() * slope;
      moment += weight * slope.transpose() * off;
    };
    if (position_)
      add(position_->weight, arrival.position,
          Vec2(position - placement.turned_back(Vec2(position_->position_m - placement.shift_m))));
    for (std::size_t d = 0; d < directions.size(); ++d) {
      Vec3 wanted = directions_[d].world;
      wanted.head<2>() = placement.turned_back(Vec2(wanted.head<2>()));
      add(kOrientationWeight, slopes[d], Vec3(directions[d] - wanted));
    }
    if (lateness) {
      const Vec6 gradient = lateness->gradient_s / lateness->target_s;
      normal += kLateWeight * gradient * gradient.transpose();
      moment += kLateWeight * lateness->now_s / lateness->target_s * gradient;
    }
    double reluctance = 1.0;  // of excess, more where the step would leave the region
    for (int more = 0; more < 40; ++more, reluctance *= 2.0) {
      change = -(normal + reluctance * Mat6::Identity()).ldlt().solve(moment + reluctance * y);
      if ((y + change).norm() <= radius) break;
    }
  }
  const Vec6 to = y + change;
  return {to, to.squaredNorm() + then.cost() - before.cost()};
}

Vec3 turn_to(const Vec3& now, const Vec3& wanted) {
  const Vec3 goal = wanted.stableNormalized();
  const double own = now.head<2>().norm();
  Vec3 steep = goal;
  if (own > 0.0) steep.head<2>() = goal.head<2>().norm() / own * now.head<2>();
  return rotation_log(Quat::FromTwoVectors(now, steep));
}

namespace {

struct Tipping {
  double turn_rad;  // to how it shall lie
  double energy;    // above lying so; 1 is what may lift the body over any corner
};

Tipping tipping(const Problem& problem, const Candidate& candidate, const OrientationConstraint& asked) {
  const Body& body = problem.bodies[static_cast<std::size_t>(candidate.body)];
  const State& pose = candidate.onset.before;
  const Vec3 turn = turn_to(seen(body, pose, asked.body_direction.stableNormalized()), asked.direction);
  State goal = pose;
  goal.orientation = (rotation_exp(turn) * pose.orientation).normalized();
  goal.position.z() = 0.0;
  const double height_m = -lowest_gap_m(body, goal);
  const double weight_n = body.mass_kg() * problem.physics.simulation.gravity_m_s2.norm();
  const double barrier_j = weight_n * std::max(body.bounding_radius_m() - height_m, kLeastRise * height_m);
  const double energy_j =
      kinetic_energy(body, candidate.onset.after) + weight_n * std::max(0.0, pose.position.z() - height_m);
  return {turn.norm(), energy_j / barrier_j};
}

}  // namespace

double toll_at_rest(const Problem& problem, const Candidate& candidate, const Passage& passage) {
  double cost = 0.0;
  for (const OrientationConstraint& c : problem.marks.constraints.orientations) {
    if (c.mark != kAtRest) continue;
    if (passage.next == Next::rest) return std::log1p(-candidate.log_rest(problem, passage));
    const Tipping now = tipping(problem, candidate, c);
    cost += std::exp(-now.energy) * std::log1p(kOrientationWeight * now.turn_rad * now.turn_rad);
  }
  return cost;
}

bool lies_for_good(const Problem& problem, const Candidate& candidate) {
  constexpr double kTips = 0.5;  // a cube tips over an edge with 0.57 of what it takes over a corner
  return std::ranges::any_of(problem.marks.constraints.orientations, [&](const OrientationConstraint& c) {
    if (c.mark != kAtRest) return false;
    const Tipping now = tipping(problem, candidate, c);
    return now.energy < kTips && now.turn_rad > kLiesOff;
  });
}

std::vector<Anchor> steer(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                          const Tolerance& tolerance, std::span<const Anchor> anchors,
                          std::span<const Trial> seen) {
  const Problem& problem = trials.problem();
  const Marks& marks = problem.marks;
  const double target = problem.target_s(k), radius = std::sqrt(tolerance.excess);
  const Aim aim(marks, trials.body(), k + 1);
  if (!aim.any()) return {};
  std::vector<std::vector<Anchor>> own(candidates.size());
  std::vector<std::vector<Sample6>> samples(candidates.size());
  const auto sample = [&](const Trial& t) {
    if (std::isfinite(t.lateness_s)) samples[t.candidate].push_back({t.y, t.lateness_s});
  };
  for (const Trial& t : seen) sample(t);
  const auto sort_in = [&](std::span<const Anchor> more) {
    for (const Anchor& a : more) {
      sample(a.trial);
      if (a.trial.meets && ratio_of(a.trial.passage.interval_s, target) <= 1.0 + tolerance.retime)
        own[a.trial.candidate].push_back(a);
    }
  };
  sort_in(anchors);
  const auto step_from = [&](const Anchor& a) {
    const Candidate& c = candidates[a.trial.candidate];
    const Arrival arrival(a.trial.passage.onset.before, a.trial.after.angular_velocity, target,
                          trials.region(c.onset));
    std::optional<Aim::Lateness> lateness;
    if (const auto model = steepest(samples[a.trial.candidate]))
      lateness = {a.trial.lateness_s, target, model->slope * model->along};
    return aim.step(c.alignment, arrival, a.trial.y, radius, lateness);
  };
  std::vector<Anchor> found;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Anchor> proposals;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      std::vector<std::pair<double, Anchor>> steps;
      for (const Anchor& a : own[i]) {
        const Aim::Step step = step_from(a);
        Anchor next = a;
        next.trial.y = step.y;
        steps.emplace_back(
            step.cost - a.trial.excess - a.trial.log_factors(problem, k, candidates[i].first_amplitude),
            next);
      }
      std::ranges::stable_sort(steps, {}, &std::pair<double, Anchor>::first);
      for (std::size_t s = 0; s < std::min(steps.size(), kSteered); ++s) {
        const Anchor& next = steps[s].second;
        const auto trial = trials.propose(candidates, i, within(next.trial.y, tolerance), tolerance.excess);
        if (trial) proposals.push_back({*trial, next.along, next.slope_s});
      }
    }
    const auto more = run_anchors(trials, candidates, k, tolerance, std::move(proposals));
    sort_in(more);
    found.insert(found.end(), more.begin(), more.end());
  }
  return found;
}

}  // namespace ifa
