// The paper's search against enumeration on small graphs, and on marks made from a simulation.
#include "ifa/graph/branch_and_bound.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "folders.hpp"
#include "ifa/base/random.hpp"
#include "ifa/graph/build.hpp"
#include "ifa/signature/factors.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

constexpr std::uint32_t kEvents = 5;        // of a simulation
constexpr std::size_t kAllChildren = 1000;  // more than there are nodes

const Body& cube() {
  static const Body body = sample::box({0.016, 0.016, 0.016}, 0.005);
  return body;
}

// Take-offs so much alike that many splices are possible.
NodeColumns random_nodes(int simulations, std::uint64_t seed) {
  RandomStream random(seed, 0);
  NodeColumns c;
  for (int n = 0; n < simulations * static_cast<int>(kEvents); ++n) {
    const Vec3 up = (Vec3(kUp) + 0.04 * random.unit_vector()).normalized();
    const Vec3 velocity = Vec3(0.3, 0.0, 0.5) + 0.1 * random.uniform() * random.unit_vector();
    const Vec3 spin = Vec3(5.0, 1.0, 0.0) + random.uniform() * random.unit_vector();
    for (const Vec3& v : {up, velocity, spin})
      for (int a = 0; a < 3; ++a) c.take_off.push_back(static_cast<float>(v[a]));
    c.take_off.push_back(static_cast<float>(random.uniform(0.008, 0.01)));
    for (const float x : {0.0f, 0.0f, 1.0f, 20.0f, 0.0f, 0.0f}) c.change.push_back(x);
    for (const double x : {0.009, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0}) c.onset.push_back(x);
    c.energy_j.push_back(random.uniform() < 0.2 ? 0.0f : 1.0f);
    const bool last = n % static_cast<int>(kEvents) == static_cast<int>(kEvents) - 1;
    c.delay_s.push_back(0.0f);
    c.flight_s.push_back(last ? 0.0f : static_cast<float>(random.uniform(0.08, 0.16)));
    c.amplitude.push_back(static_cast<float>(random.uniform(0.5, 1.5)));
    c.length_s.push_back(random.uniform() < 0.2 ? 0.02f : 0.0f);
    c.centroid_s.push_back(0.5f * c.length_s.back());
    c.flags.push_back(last ? kTerminal : random.uniform() < 0.1 ? kEdge | kDubious : kEdge);
  }
  return c;
}

Marks marks_of(std::vector<double> times_s, bool loud, Ending ending) {
  Marks m;
  m.times_s = std::move(times_s);
  m.durations_s.assign(m.times_s.size(), 0.0);
  m.centroids_s.assign(m.times_s.size(), std::nan(""));
  if (loud)
    for (std::size_t k = 0; k < m.times_s.size(); ++k)
      m.amplitudes.push_back(1.0 - 0.1 * static_cast<double>(k));
  m.ending = ending;
  return m;
}

using Forbidden = std::function<bool(std::uint32_t from, std::uint32_t to)>;

// The same search, with no trees, no bounds and no memory: every sub-path is gone.
class Enumeration {
 public:
  Enumeration(const NodeColumns& c, const Targets& targets, std::size_t depth, std::size_t keep,
              Forbidden forbidden)
      : c_(c),
        nodes_(view_of(c)),
        targets_(targets),
        depth_(depth),
        keep_(keep),
        forbidden_(std::move(forbidden)) {}

  double best() {
    double best = -INFINITY;
    for (std::uint32_t root = 0; root + 1 < c_.size(); ++root) {
      if (c_.flags[root] != kEdge) continue;
      const double time = log_time_factor(flight(root), targets_.intervals_s[0]);
      if (time <= -10.0 || !ends_well(root + 1, 1)) continue;
      loudness_ = static_cast<double>(c_.amplitude[root]);
      std::vector<std::uint32_t> path{root, root + 1};
      double log = time + sound(root, 0) + sound(root + 1, 1);
      while (path.size() < targets_.size()) {
        const std::size_t from = path.size();
        best_sub_.clear();
        best_log_ = -INFINITY;
        go(path, log, std::min(from + depth_, targets_.size()));
        if (best_sub_.empty()) break;
        for (std::size_t k = from; k < std::min(from + keep_, best_sub_.size()); ++k) {
          log += edge(path.back(), best_sub_[k], k);
          path.push_back(best_sub_[k]);
        }
      }
      if (path.size() == targets_.size()) best = std::max(best, log);
    }
    return best;
  }

  // To event k; -infinity: none.
  double edge(std::uint32_t from, std::uint32_t to, std::size_t k) const {
    if (!ends_well(to, k)) return -INFINITY;
    double log = sound(to, k);
    if (to == from + 1) {
      if (c_.flags[from] != kEdge) return -INFINITY;
      return log + log_time_factor(flight(from), targets_.intervals_s[k - 1]);
    }
    if (to == 0 || c_.flags[to - 1] != kEdge || c_.flight_s[from] == 0.0f || forbidden_(from, to))
      return -INFINITY;
    const Splice s = splice(take_off_of(nodes_, from), region_of(nodes_, from, cube()),
                            take_off_of(nodes_, to - 1), flight(to - 1));
    if (s.log_velocity <= -10.0 || s.log_orientation <= -10.0) return -INFINITY;
    if (!keeps_energy(nodes_, from, to, s, cube(), sample::kGravity)) return -INFINITY;
    return log + s.log_weight() + log_time_factor(flight(to - 1), targets_.intervals_s[k - 1]);
  }

  void set_loudness(double of_first) { loudness_ = of_first; }
  double sound(std::uint32_t node, std::size_t k) const {
    return log_sound(brief_of(nodes_, node), targets_, k, loudness_);
  }

 private:
  double flight(std::uint32_t i) const { return static_cast<double>(c_.flight_s[i]); }
  bool ends_well(std::uint32_t node, std::size_t k) const {
    if ((c_.flags[node] & kDubious) != 0) return false;
    if (k + 1 < targets_.size()) return (c_.flags[node] & kEdge) != 0;
    return !targets_.rest || (c_.flags[node] & kTerminal) != 0;
  }
  void go(std::vector<std::uint32_t>& path, double log, std::size_t horizon) {
    if (path.size() == horizon) {
      if (log > best_log_) {
        best_log_ = log;
        best_sub_ = path;
      }
      return;
    }
    for (std::uint32_t to = 0; to < c_.size(); ++to) {
      const double more = edge(path.back(), to, path.size());
      if (more == -INFINITY) continue;
      path.push_back(to);
      go(path, log + more, horizon);
      path.pop_back();
    }
  }

  const NodeColumns& c_;
  Nodes nodes_;
  const Targets& targets_;
  std::size_t depth_, keep_;
  Forbidden forbidden_;
  double loudness_ = 1.0;
  std::vector<std::uint32_t> best_sub_;
  double best_log_ = -INFINITY;
};

GraphPath search(const NodeColumns& c, const Targets& targets, const BranchAndBoundOptions& options,
                 const FirstInfeasible& first_infeasible) {
  const Nodes nodes = view_of(c);
  const Briefs briefs(nodes);
  const NodeTrees trees(nodes, cube());
  return search_branch_and_bound({nodes, cube(), briefs, trees, sample::kGravity, 0.0}, targets, options,
                                 first_infeasible);
}

std::optional<std::size_t> all_feasible(const GraphPath&) { return std::nullopt; }

BranchAndBoundOptions thorough(std::size_t depth, std::size_t keep) {
  BranchAndBoundOptions options;
  options.depth = depth;
  options.keep = keep;
  options.children = kAllChildren;
  options.early_exit_score.reset();
  return options;
}

constexpr double kRounding = 1e-9;  // sums of a dozen doubles of size 10

class AgainstEnumeration : public ::testing::TestWithParam<int> {};

TEST_P(AgainstEnumeration, DepthAndWhatIsKeptAreThePapers) {
  const NodeColumns c = random_nodes(5, static_cast<std::uint64_t>(GetParam()));
  for (const bool loud : {false, true}) {
    for (const Ending ending : {Ending::rest, Ending::open}) {
      const Targets targets(marks_of({0.0, 0.11, 0.23, 0.33, 0.46}, loud, ending));
      for (const auto& [depth, keep] : {std::pair<std::size_t, std::size_t>{9, 9}, {3, 2}, {2, 1}, {1, 1}}) {
        SCOPED_TRACE("depth " + std::to_string(depth));
        Enumeration all(c, targets, depth, keep, [](auto, auto) { return false; });
        const double best = all.best();
        const GraphPath path = search(c, targets, thorough(depth, keep), all_feasible);
        if (best == -INFINITY) {
          EXPECT_LT(path.steps.size(), targets.size());
          continue;
        }
        ASSERT_EQ(path.steps.size(), targets.size());
        EXPECT_NEAR(path.log_weight, best, kRounding);
        EXPECT_EQ(path.log_bound, 0.0);
        all.set_loudness(static_cast<double>(c.amplitude[path.steps[0].node]));
        double log = all.sound(path.steps[0].node, 0);
        for (std::size_t k = 1; k < path.steps.size(); ++k) {
          log += all.edge(path.steps[k - 1].node, path.steps[k].node, k);
          EXPECT_EQ(path.steps[k].spliced, path.steps[k].node != path.steps[k - 1].node + 1);
          EXPECT_EQ(path.steps[k].element, 0);
        }
        EXPECT_NEAR(path.log_weight, log, kRounding);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, AgainstEnumeration, ::testing::Range(1, 9));

TEST(BranchAndBound, InfeasibleSplicesAreAskedAboutOnce) {
  const Forbidden forbidden = [](std::uint32_t from, std::uint32_t to) { return (from + to) % 3 != 0; };
  std::size_t refused = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const NodeColumns c = random_nodes(5, seed);
    const Targets targets(marks_of({0.0, 0.11, 0.23, 0.33}, false, Ending::rest));
    std::set<std::uint64_t> asked;
    const FirstInfeasible first_infeasible = [&](const GraphPath& path) -> std::optional<std::size_t> {
      for (std::size_t k = 1; k < path.steps.size(); ++k) {
        const std::uint32_t from = path.steps[k - 1].node, to = path.steps[k].node;
        if (!path.steps[k].spliced || !forbidden(from, to)) continue;
        EXPECT_TRUE(asked.insert(splice_key(from, to)).second);
        return k;
      }
      return std::nullopt;
    };
    const GraphPath path = search(c, targets, thorough(9, 9), first_infeasible);
    const double best = Enumeration(c, targets, 9, 9, forbidden).best();
    refused += asked.size();
    if (best == -INFINITY) {
      EXPECT_LT(path.steps.size(), targets.size());
      continue;
    }
    EXPECT_NEAR(path.log_weight, best, kRounding);
    for (std::size_t k = 1; k < path.steps.size(); ++k) {
      EXPECT_FALSE(path.steps[k].spliced && forbidden(path.steps[k - 1].node, path.steps[k].node));
    }
  }
  EXPECT_GT(refused, 20u);  // else little was tried
}

// All that is refused comes to an end, also where what was kept, or a simulated edge, is to blame.
TEST(BranchAndBound, WhatCannotBeGoneIsGivenUp) {
  const NodeColumns c = random_nodes(8, 3);
  const Targets targets(marks_of({0.0, 0.11, 0.23, 0.33, 0.45}, false, Ending::open));
  const auto steps_if_refused = [&](std::size_t step, std::size_t of_length) {
    const GraphPath path =
        search(c, targets, thorough(2, 1), [&](const GraphPath& p) -> std::optional<std::size_t> {
          return p.steps.size() >= of_length ? std::optional(step) : std::nullopt;
        });
    return path.steps.size();
  };
  for (const std::size_t step : {0, 1, 2, 3, 99}) EXPECT_EQ(steps_if_refused(step, 4), 2u);
  for (const std::size_t step : {0, 1, 2, 3, 4, 99}) EXPECT_EQ(steps_if_refused(step, 5), 3u);
}

TEST(BranchAndBound, RetimesNoMoreThanAsked) {
  int changed = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const NodeColumns c = random_nodes(8, seed);
    const Targets targets(marks_of({0.0, 0.11, 0.18, 0.33}, false, Ending::rest));
    BranchAndBoundOptions options = thorough(9, 9);
    const GraphPath any = search(c, targets, options, all_feasible);
    options.most_retime = 1.2;
    const GraphPath near = search(c, targets, options, all_feasible);
    for (std::size_t k = 1; k < near.steps.size(); ++k) {
      const Step& to = near.steps[k];
      const double ratio =
          static_cast<double>(c.flight_s[to.spliced ? to.node - 1 : near.steps[k - 1].node]) /
          targets.intervals_s[k - 1];
      EXPECT_LE(std::max(ratio, 1.0 / ratio), 1.2);
    }
    if (near.steps.size() == targets.size()) {
      EXPECT_LE(near.log_weight, any.log_weight);
    }
    changed += near.steps.size() != any.steps.size() || near.log_weight != any.log_weight;
  }
  EXPECT_GT(changed, 0);
}

TEST(BranchAndBound, WithoutTimeThereIsAFirstEdge) {
  const NodeColumns c = random_nodes(8, 3);
  const Targets targets(marks_of({0.0, 0.11, 0.23, 0.33, 0.45}, false, Ending::rest));
  BranchAndBoundOptions options;
  options.time_limit_s = 0.0;
  EXPECT_EQ(search(c, targets, options, all_feasible).steps.size(), 2u);
  const Targets never(marks_of({0.0, 30.0, 60.0}, false, Ending::rest));
  EXPECT_TRUE(search(c, never, options, all_feasible).steps.empty());
}

// What a simulation of the database does, from its node `first` to its end or `events` long.
Marks planted(const Nodes& nodes, std::size_t first, std::size_t events, Ending ending) {
  Marks m;
  double at_s = 0.0;
  for (std::size_t i = first; i < first + events; ++i) {
    m.times_s.push_back(at_s);
    const NodeBrief b = brief_of(nodes, i);
    at_s += interval_s(b, b);
    const bool long_one = b.length_s > 0.0f;
    m.durations_s.push_back(static_cast<double>(b.length_s));
    m.centroids_s.push_back(long_one ? static_cast<double>(b.centroid_s) : std::nan(""));
    m.amplitudes.push_back(static_cast<double>(b.amplitude));
  }
  m.ending = ending;
  return m;
}

TEST(BranchAndBound, FindsTheSimulationThatTheMarksAreOf) {
  const sample::TemporaryFolder folder;
  const Database database = build_database(cube(), {}, folder.path(), 300, 2);
  const Nodes& nodes = database.nodes();
  const Briefs briefs(nodes);
  const NodeTrees trees(nodes, cube());
  const SearchedGraph graph{nodes, cube(), briefs, trees, sample::kGravity, 0.0};
  std::size_t tried = 0;
  for (std::size_t i = 0; i + 1 < nodes.size() && tried < 20; ++i) {
    std::size_t events = 1;
    while (usable_edge(briefs.nodes[i + events - 1]) && events < 12) ++events;
    const std::size_t end = i + events - 1;
    if (events < 4 || (nodes.flags[end] & kDubious) != 0) continue;
    const bool rest = (nodes.flags[end] & kTerminal) != 0;
    if (!rest && events < 12) continue;
    ++tried;
    const Targets targets(planted(nodes, i, events, rest ? Ending::rest : Ending::open));
    std::set<std::uint32_t> roots, roots_without_exit;
    const auto noting = [](std::set<std::uint32_t>& to) {
      return [&to](const GraphPath& p) {
        to.insert(p.steps[0].node);
        return std::optional<std::size_t>();
      };
    };
    BranchAndBoundOptions options;
    const GraphPath path = search_branch_and_bound(graph, targets, options, noting(roots));
    ASSERT_EQ(path.steps.size(), events);
    for (std::size_t k = 0; k < events; ++k) {
      EXPECT_EQ(path.steps[k].node, i + k);
      EXPECT_FALSE(path.steps[k].spliced);
    }
    EXPECT_NEAR(path.log_weight, 0.0, 1e-9);  // differences of float32 times, squared
    EXPECT_EQ(roots.size(), 1u);              // its Score is good enough
    // An end that nothing else can beat is not looked for elsewhere either.
    options.early_exit_score.reset();
    EXPECT_EQ(search_branch_and_bound(graph, targets, options, noting(roots_without_exit)).log_weight,
              path.log_weight);
    i += events;
  }
  EXPECT_EQ(tried, 20u);
}

// Marks of no simulation: the first path is good enough, and not the best.
TEST(BranchAndBound, ExitsEarlyWhenAskedTo) {
  int better = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const NodeColumns c = random_nodes(8, seed);
    const Targets targets(marks_of({0.0, 0.11, 0.23, 0.33}, true, Ending::open));
    BranchAndBoundOptions options = thorough(9, 9);
    const GraphPath best = search(c, targets, options, all_feasible);
    options.early_exit_score = 0.3;
    const GraphPath first = search(c, targets, options, all_feasible);
    ASSERT_EQ(first.steps.size(), targets.size());
    EXPECT_LE(first.log_weight, best.log_weight);
    if (std::exp(best.log_weight / 24.0) >= 0.3) {
      EXPECT_GE(std::exp(first.log_weight / 24.0), 0.3);
    }
    better += best.log_weight > first.log_weight;
  }
  EXPECT_GT(better, 0);
}

}  // namespace
}  // namespace ifa
