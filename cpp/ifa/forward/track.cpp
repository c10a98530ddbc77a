#include "ifa/forward/track.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ifa/forward/closing.hpp"

namespace ifa {
namespace {

constexpr int kSteps = 2, kScattered = 5;
constexpr std::size_t kEach = 3, kNearest = 12;  // kept of each candidate, and of all
constexpr double kSpread = 0.4;                  // of the plausible region's radius, for the scattered ones
constexpr double kDifference = 0.03;             // of the plausible region's radius, for finite differences
constexpr double kEdge = 0.98;                   // of its radius: as far as a change goes
constexpr double kDamping = 1e-3;                // of the normal equations, whose residuals are of order 0.1
constexpr double kOnTimeWeight = 50.0;           // 1 % of an interval weighs as much as half a body's speed
constexpr double kSlowest_m_s = 0.1;             // speeds are compared to the motion's own, or to this

using Residuals = Eigen::Matrix<double, 10, 1>;
using Jacobian = Eigen::Matrix<double, 10, 6>;

// What is left to be done, in lateness and in the state modulo place and heading: the up vector, the velocity
// and the spin, all as the body sees them (design: orientation after the best yaw is the angle between up
// vectors).
Residuals residuals(const Trial& trial, const Onset& wanted, double target_s, double radius_m) {
  const State &a = trial.passage.onset.before, &b = wanted.before;
  const Quat to_a = a.orientation.conjugate(), to_b = b.orientation.conjugate();
  const double speed = std::max(b.velocity.norm(), kSlowest_m_s);
  const double spin = std::max(b.angular_velocity.norm(), speed / radius_m);
  Residuals r;
  r[0] = kOnTimeWeight * trial.lateness_s / target_s;
  r.segment<3>(1) = to_a * kUp - to_b * kUp;
  r.segment<3>(4) = (to_a * a.velocity - to_b * b.velocity) / speed;
  r.segment<3>(7) = (to_a * a.angular_velocity - to_b * b.angular_velocity) / spin;
  return r;
}

}  // namespace

std::vector<Trial> track(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                         const Onset& wanted, const Vec6& y, std::span<RandomStream> random) {
  const double target = trials.problem().target_s(k), radius = trials.body().bounding_radius_m();
  const auto residuals_of = [&](const Trial& t) { return residuals(t, wanted, target, radius); };

  struct Met {
    double cost;
    Trial trial;
  };
  std::vector<std::vector<Met>> met(candidates.size());  // the nearest first
  std::vector<Trial> made;
  const auto propose = [&](std::size_t i, const Vec6& p) {
    const Vec6 within = p.norm() > kEdge ? Vec6(p * (kEdge / p.norm())) : p;
    if (const auto t = trials.propose(candidates, i, within, kPlausible.excess)) made.push_back(*t);
  };
  const auto run = [&] {
    trials.run(candidates, k, made);
    for (const Trial& t : made)
      if (t.meets) met[t.candidate].push_back({residuals_of(t).squaredNorm(), t});
    for (auto& own : met) std::ranges::stable_sort(own, {}, &Met::cost);
  };

  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (const double share : {1.0, 0.5, 0.0}) propose(i, share * y);
    for (int j = 0; j < kScattered; ++j) propose(i, y + kSpread * random_change(1.0, random[i]));
  }
  run();
  for (int step = 0; step < kSteps; ++step) {
    made.clear();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (met[i].empty()) continue;
      for (int axis = 0; axis < 6; ++axis) {
        Vec6 p = met[i][0].trial.y;
        p[axis] += p[axis] > 0.0 ? -kDifference : kDifference;  // inwards
        propose(i, p);
      }
    }
    std::vector<Jacobian> jacobian(candidates.size(), Jacobian::Zero());
    std::vector<Trial> best(candidates.size());
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (!met[i].empty()) best[i] = met[i][0].trial;
    run();
    for (const Trial& t : made) {
      int axis;
      const Vec6 moved = t.y - best[t.candidate].y;
      moved.cwiseAbs().maxCoeff(&axis);
      if (t.meets)  // else that axis is left alone
        jacobian[t.candidate].col(axis) = (residuals_of(t) - residuals_of(best[t.candidate])) / moved[axis];
    }
    made.clear();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (met[i].empty()) continue;
      const Mat6 normal = jacobian[i].transpose() * jacobian[i] + kDamping * Mat6::Identity();
      const Vec6 change = -normal.ldlt().solve(jacobian[i].transpose() * residuals_of(best[i]));
      for (const double share : {1.0, 0.5, 0.2}) propose(i, best[i].y + share * change);
    }
    run();
  }

  std::vector<Met> all;
  for (const auto& own : met) {
    std::size_t taken = 0;
    for (const Met& m : own) {
      if (taken == kEach) break;
      if (ratio_of(m.trial.passage.interval_s, target) > 1.0 + kPlausible.retime) continue;
      all.push_back(m);
      ++taken;
    }
  }
  std::ranges::stable_sort(all, {}, &Met::cost);
  std::vector<Trial> nearest;
  for (std::size_t m = 0; m < std::min(all.size(), kNearest); ++m) nearest.push_back(std::move(all[m].trial));
  return nearest;
}

}  // namespace ifa
