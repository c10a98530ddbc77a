// The layered programme against enumeration of all paths of small random graphs.
#include "ifa/graph/layered.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "ifa/base/random.hpp"
#include "ifa/signature/factors.hpp"

namespace ifa {
namespace {

struct Graph {
  NodeColumns nodes;
  TransitionColumns transitions;
};

// Simulations of six nodes; what the searches do not look at stays empty.
Graph random_graph(int simulations, int splices_each, std::uint64_t seed) {
  RandomStream random(seed, 0);
  Graph g;
  NodeColumns& c = g.nodes;
  for (int s = 0; s < simulations; ++s) {
    for (int e = 0; e < 6; ++e) {
      const bool last = e == 5;
      c.delay_s.push_back(0.0f);
      c.flight_s.push_back(last ? 0.0f : static_cast<float>(random.uniform(0.08, 0.16)));
      c.amplitude.push_back(static_cast<float>(random.uniform(0.5, 1.5)));
      c.length_s.push_back(random.uniform() < 0.2 ? 0.02f : 0.0f);
      c.centroid_s.push_back(0.5f * c.length_s.back());
      c.flags.push_back(last ? kTerminal : random.uniform() < 0.1 ? kEdge | kDubious : kEdge);
    }
  }
  const auto n = static_cast<std::uint32_t>(c.size());
  g.transitions.first.push_back(0);
  for (std::uint32_t i = 0; i < n; ++i) {
    std::vector<std::pair<std::uint16_t, std::uint32_t>> row;
    if (c.flight_s[i] > 0.0f)
      for (int m = 0; m < splices_each; ++m) {
        const auto target = static_cast<std::uint32_t>(random.uniform() * n);
        if (target == i + 1 || target % 6 == 0) continue;
        row.emplace_back(static_cast<std::uint16_t>(random.uniform(0.0, 3.0) / kCostUnit), target);
      }
    std::sort(row.begin(), row.end());
    for (const auto& [cost, target] : row) {
      g.transitions.cost.push_back(cost);
      g.transitions.target.push_back(target);
      g.transitions.element.push_back(0);
    }
    g.transitions.first.push_back(g.transitions.cost.size());
  }
  return g;
}

Nodes briefly(const NodeColumns& c) { return view_of(c); }

Transitions view(const TransitionColumns& t) { return {t.first, t.target, t.cost, t.element}; }

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

// The best log weight over all paths, edge by edge as the paper has it.
double best_by_enumeration(const Graph& g, const Targets& targets, const LayeredOptions& options) {
  const NodeColumns& c = g.nodes;
  double best = -INFINITY;
  std::function<void(std::uint32_t, std::size_t, double, double)> go = [&](std::uint32_t node, std::size_t k,
                                                                           double log, double loudness) {
    const bool last = k + 1 == targets.size();
    if ((c.flags[node] & kDubious) != 0) return;
    log += log_sound(brief_of(briefly(c), node), targets, k, loudness);
    if (last) {
      if (!targets.rest || (c.flags[node] & kTerminal) != 0) best = std::max(best, log);
      return;
    }
    if ((c.flags[node] & kEdge) == 0) return;
    const auto edge = [&](std::uint32_t to, double interval, double more) {
      const double wanted = targets.intervals_s[k];
      if (std::max(interval / wanted, wanted / interval) > options.most_retime) return;
      go(to, k + 1, log + more + log_time_factor(interval, wanted), loudness);
    };
    edge(node + 1, c.flight_s[node], 0.0);
    if (k == 0) return;  // paths begin with a simulated edge (paper section 5.5)
    for (auto m = g.transitions.first[node]; m < g.transitions.first[node + 1]; ++m)
      edge(g.transitions.target[m], c.flight_s[g.transitions.target[m] - 1],
           -kCostUnit * g.transitions.cost[m]);
  };
  for (std::uint32_t root = 0; root < c.size(); ++root) go(root, 0, 0.0, c.amplitude[root]);
  return best;
}

class LayeredAgainstAll : public ::testing::TestWithParam<int> {};

TEST_P(LayeredAgainstAll, FindsTheBestPathAndKnowsIt) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const Graph g = random_graph(12, 4, seed);
  const Briefs briefs(briefly(g.nodes));
  for (const bool loud : {false, true}) {
    for (const Ending ending : {Ending::rest, Ending::open}) {
      const Marks marks = marks_of({0.0, 0.11, 0.23, 0.33, 0.46}, loud, ending);
      const Targets targets(marks);
      LayeredOptions options;
      const auto paths = search_layers(briefs, view(g.transitions), targets, options);
      const double best = best_by_enumeration(g, targets, options);
      if (best == -INFINITY) {
        EXPECT_TRUE(paths.empty() || paths[0].steps.size() < targets.size());
        continue;
      }
      ASSERT_FALSE(paths.empty());
      ASSERT_EQ(paths[0].steps.size(), targets.size());
      // Sums of a dozen float32 numbers of size 10; and first events within 5 % count as one, which the bound
      // allows for.
      constexpr double kRounding = 1e-4;
      EXPECT_LE(paths[0].log_weight, best + kRounding);
      EXPECT_GE(paths[0].log_bound, best - kRounding);
      if (loud) continue;
      EXPECT_NEAR(paths[0].log_weight, best, kRounding);
      EXPECT_NEAR(paths[0].log_bound, paths[0].log_weight, kRounding);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, LayeredAgainstAll, ::testing::Range(1, 25));

TEST(Layered, APathIsWorthWhatItsEdgesAre) {
  const Graph g = random_graph(40, 6, 77);
  const Briefs briefs(briefly(g.nodes));
  const Targets targets(marks_of({0.0, 0.12, 0.22, 0.35}, true, Ending::rest));
  LayeredOptions options;
  options.paths = 20;
  const auto paths = search_layers(briefs, view(g.transitions), targets, options);
  ASSERT_GT(paths.size(), 5u);
  for (const GraphPath& path : paths) {
    double log = 0.0;
    const double loudness = g.nodes.amplitude[path.steps[0].node];
    for (std::size_t k = 0; k < path.steps.size(); ++k) {
      log += log_sound(briefs.nodes[path.steps[k].node], targets, k, loudness);
      if (k == 0) continue;
      const std::uint32_t from = path.steps[k - 1].node, to = path.steps[k].node;
      log += log_time_factor(g.nodes.flight_s[path.steps[k].spliced ? to - 1 : from],
                             targets.intervals_s[k - 1]);
      if (!path.steps[k].spliced) {
        EXPECT_EQ(to, from + 1);
        continue;
      }
      const auto begin = g.transitions.target.begin();
      const auto at = std::find(begin + static_cast<std::ptrdiff_t>(g.transitions.first[from]),
                                begin + static_cast<std::ptrdiff_t>(g.transitions.first[from + 1]), to);
      ASSERT_NE(at, begin + static_cast<std::ptrdiff_t>(g.transitions.first[from + 1]));
      log -= kCostUnit * g.transitions.cost[static_cast<std::size_t>(at - begin)];
    }
    EXPECT_NEAR(path.log_weight, log, 1e-4);  // float32 sums
  }
}

TEST(Layered, FewerStatesNeverHideWhatTheyMayHaveCost) {
  int dropped = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Graph g = random_graph(60, 8, seed);
    const Briefs briefs(briefly(g.nodes));
    const Targets targets(marks_of({0.0, 0.12, 0.22, 0.35, 0.45}, true, Ending::rest));
    LayeredOptions narrow, wide;
    narrow.most_states = 5;
    const auto all = search_layers(briefs, view(g.transitions), targets, wide);
    const auto few = search_layers(briefs, view(g.transitions), targets, narrow);
    if (all.empty() || few.empty() || few[0].steps.size() < targets.size()) continue;
    EXPECT_LE(few[0].log_weight, all[0].log_weight + 1e-4);
    EXPECT_GE(few[0].log_bound, all[0].log_weight - 1e-4);
    dropped += few[0].log_weight < all[0].log_weight - 1e-3;
  }
  EXPECT_GT(dropped, 0);  // else nothing was tried
}

// As if the others had never been made.
TransitionColumns cut_short(const TransitionColumns& all, std::size_t most) {
  TransitionColumns few;
  few.first.push_back(0);
  for (std::size_t i = 0; i + 1 < all.first.size(); ++i) {
    for (auto m = all.first[i]; m < std::min(all.first[i + 1], all.first[i] + most); ++m) {
      few.target.push_back(all.target[m]);
      few.cost.push_back(all.cost[m]);
      few.element.push_back(all.element[m]);
    }
    few.first.push_back(few.target.size());
  }
  return few;
}

TEST(Layered, FewerNeighboursAreTheBestOnes) {
  int missed = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Graph g = random_graph(30, 8, seed);
    const Briefs briefs(briefly(g.nodes));
    const Targets targets(marks_of({0.0, 0.12, 0.22, 0.35, 0.45}, true, Ending::rest));
    const auto all = search_layers(briefs, view(g.transitions), targets, {});
    for (const std::size_t most : {1u, 3u, 100u}) {
      LayeredOptions options;
      options.neighbours = most;
      const TransitionColumns few = cut_short(g.transitions, most);
      const auto got = search_layers(briefs, view(g.transitions), targets, options);
      const auto wanted = search_layers(briefs, view(few), targets, {});
      ASSERT_EQ(got.size(), wanted.size());
      if (got.empty()) continue;
      EXPECT_EQ(got[0].log_weight, wanted[0].log_weight);
      EXPECT_EQ(got[0].log_bound, wanted[0].log_bound);
      missed += got[0].log_weight < all[0].log_weight;
    }
  }
  EXPECT_GT(missed, 0);  // else nothing was left out
}

TEST(Layered, BannedSplicesAreNotUsed) {
  const Graph g = random_graph(30, 6, 5);
  const Briefs briefs(briefly(g.nodes));
  const Targets targets(marks_of({0.0, 0.12, 0.22, 0.35}, false, Ending::rest));
  LayeredOptions options;
  std::set<std::uint64_t> banned;
  for (int round = 0; round < 10; ++round) {
    const auto paths = search_layers(briefs, view(g.transitions), targets, options);
    ASSERT_FALSE(paths.empty());
    std::size_t before = banned.size();
    for (std::size_t k = 1; k < paths[0].steps.size(); ++k) {
      if (!paths[0].steps[k].spliced) continue;
      const auto key = splice_key(paths[0].steps[k - 1].node, paths[0].steps[k].node);
      EXPECT_FALSE(banned.contains(key));
      banned.insert(key);
    }
    options.banned.assign(banned.begin(), banned.end());
    if (banned.size() == before) break;
  }
  EXPECT_FALSE(banned.empty());
}

TEST(Layered, TheBestSuffixIsThatOfAScan) {
  const Graph g = random_graph(200, 0, 9);
  const Briefs briefs(briefly(g.nodes));
  const Targets targets(marks_of({0.0, 0.12, 0.22, 0.35}, true, Ending::rest));
  LayeredOptions options;
  const GraphPath suffix = best_suffix(briefs, targets, options.most_retime);
  EXPECT_NEAR(suffix.log_weight, best_by_enumeration(g, targets, options), 1e-9);  // sums of a dozen doubles
}

TEST(Layered, ASingleMarkTakesTheNodesThatFitIt) {
  const Graph g = random_graph(50, 0, 3);
  const Briefs briefs(briefly(g.nodes));
  for (const GraphPath& path : single_events(briefs, Targets(marks_of({0.5}, false, Ending::rest)), 10)) {
    EXPECT_EQ(g.nodes.flags[path.steps[0].node], kTerminal);
    EXPECT_EQ(path.log_weight, path.log_bound);
  }
}

}  // namespace
}  // namespace ifa
