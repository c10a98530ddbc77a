// The paper's search as a whole: from marks to a motion.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <thread>

#include "folders.hpp"
#include "ifa/graph/build.hpp"
#include "ifa/graph/solve.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

class BranchAndBoundSolve : public ::testing::Test {
 protected:
  static const ContactGraph& graph() {
    static const sample::TemporaryFolder folder;
    static const ContactGraph made = ContactGraph::of(
        build_database(sample::box({0.016, 0.016, 0.016}, 0.005), {}, folder.path(), 400, 2), 0.0, 2);
    return made;
  }

  // The last events of simulations, down to rest; their intervals are `slower` times as long.
  static std::vector<Marks> endings(std::size_t events, std::size_t count, double slower) {
    const auto& nodes = graph().briefs().nodes;
    std::vector<Marks> found;
    for (std::size_t end = 0; end < nodes.size() && found.size() < count; ++end) {
      if (nodes[end].flags != kTerminal || end + 1 < events) continue;
      Marks m;
      double at_s = 0.0;
      bool whole = true;
      for (std::size_t i = end + 1 - events; i <= end; ++i) {
        whole = whole && (i == end || usable_edge(nodes[i]));
        m.times_s.push_back(at_s);
        at_s += slower * interval_s(nodes[i], nodes[i]);
        m.durations_s.push_back(static_cast<double>(nodes[i].length_s));
        m.centroids_s.push_back(nodes[i].length_s > 0.0f ? static_cast<double>(nodes[i].centroid_s)
                                                         : std::nan(""));
        m.amplitudes.push_back(static_cast<double>(nodes[i].amplitude));
      }
      if (whole) found.push_back(m);
    }
    EXPECT_EQ(found.size(), count);
    return found;
  }

  static GraphOptions options() {
    GraphOptions o;
    o.search = GraphSearch::branch_and_bound;
    o.time_budget_s = 60.0;  // never reached, so that what is found does not depend on the machine
    return o;
  }
};

TEST_F(BranchAndBoundSolve, ASimulationIsFoundAndFlown) {
  for (const Marks& marks : endings(5, 10, 1.0)) {
    const Solution s = solve_graph(graph(), marks, options(), nullptr);
    EXPECT_TRUE(s.succeeded);
    EXPECT_TRUE(s.plausible);
    // Times are stored as float32, and events measured anew.
    EXPECT_GT(s.score, 1.0 - 1e-3);
    EXPECT_EQ(s.rung, 0);
    EXPECT_EQ(s.search_log_bound, 0.0);
  }
}

// What the search asked about is what is then flown: a path that it returns whole goes all the way.
TEST_F(BranchAndBoundSolve, WholePathsCanBeFlown) {
  std::size_t whole = 0;
  for (Marks& marks : endings(5, 12, 1.04)) {
    marks.amplitudes.clear();
    const Solution s = solve_graph(graph(), marks, options(), nullptr);
    if (!s.succeeded) continue;
    ++whole;
    EXPECT_EQ(s.events.size(), marks.size());
    EXPECT_EQ(s.missed_hits, 0);
    // 4 % slower costs f_t = exp(-0.16) an edge, and the simulation itself is always to be had at that price.
    EXPECT_GE(s.score, 0.3);
  }
  EXPECT_EQ(whole, 12u);
}

TEST_F(BranchAndBoundSolve, ASingleMarkAndABadRung) {
  Marks one;
  one.times_s = {0.5};
  one.durations_s = {0.0};
  one.centroids_s = {std::nan("")};
  EXPECT_TRUE(solve_graph(graph(), one, options(), nullptr).succeeded);
  GraphOptions second = options();
  second.rung = 1;
  EXPECT_EQ(sample::message_of<ArgumentError>([&] { solve_graph(graph(), one, second, nullptr); }),
            "rung: branch and bound has a single one, got 1");
}

TEST_F(BranchAndBoundSolve, TreesAreMadeOnceForAllThreads) {
  const ContactGraph copy = graph();
  std::array<const NodeTrees*, 8> seen{};
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < seen.size(); ++t)
    threads.emplace_back([&, t] { seen[t] = &(t % 2 == 0 ? graph() : copy).trees(); });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(std::set(seen.begin(), seen.end()).size(), 1u);
}

}  // namespace
}  // namespace ifa
