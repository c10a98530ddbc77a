#include "ifa/forward/takes.hpp"

#include <algorithm>
#include <set>

#include "ifa/motion/difference.hpp"
#include "ifa/solution/solution.hpp"

namespace ifa {
namespace {

constexpr std::size_t kMostSecond = 8;  // leaves made into motions in search of the best one
constexpr int kMostTried = 40;          // leaves made into motions for each take

}  // namespace

std::vector<Solution> best_takes(const Problem& problem, const Beam& beam, int takes, double lead_in_s,
                                 const std::vector<Solution>& before, const Progress* progress) {
  const Marks& marks = problem.marks;
  const auto solution_of = [&](const Found& found) {
    return make_solution(problem.bodies[static_cast<std::size_t>(found.body)], problem.physics, marks,
                         problem.plan, found, lead_in_s, progress);
  };
  std::vector<Solution> found;
  if (before.empty()) {
    found.push_back(solution_of(best_of(beam)));
    // Measured as a whole, a motion may turn out worse than its leaf promised.
    const std::size_t more = std::min(beam.leaves.size(), kMostSecond);
    for (std::size_t i = 1; i < more && !found.front().satisfies() && beam.leaves[i].violations == 0; ++i) {
      Solution other = solution_of(trace(beam, beam.leaves[i]));
      if (better(other, found.front())) found.front() = std::move(other);
    }
    if (takes == 1) return found;
  }
  const double from = marks.times_s.front();
  const auto different = [&](const Solution& a, const Solution& b) {
    const double to =
        marks.size() > 1 ? marks.times_s.back() : std::max(a.motion->end_s(), b.motion->end_s());
    return difference(*a.motion, *b.motion, from, to) >= kClearlyDifferent;
  };
  const Solution& best = before.empty() ? found.front() : before.front();
  const bool plausible = best.plausible, met = best.constraints_met();
  // Leaves of one start are alike: one of each.
  std::vector<const Leaf*> order;
  std::set<int> starts;
  const auto start_of = [&](const Leaf& leaf) {
    return beam.levels.back().candidates[static_cast<std::size_t>(leaf.candidate)].start;
  };
  for (const Leaf& leaf : beam.leaves)
    if (starts.insert(start_of(leaf)).second) order.push_back(&leaf);
  const std::size_t tries = std::min(order.size(), static_cast<std::size_t>(kMostTried * takes));
  for (std::size_t i = 0; i < tries && before.size() + found.size() < static_cast<std::size_t>(takes); ++i) {
    Solution solution = solution_of(trace(beam, *order[i]));
    if (!(plausible ? solution.plausible : solution.succeeded)) continue;
    if (met && !solution.constraints_met()) continue;
    const auto other = [&](const Solution& s) { return different(s, solution); };
    if (std::ranges::all_of(found, other) && std::ranges::all_of(before, other))
      found.push_back(std::move(solution));
  }
  return found;
}

}  // namespace ifa
