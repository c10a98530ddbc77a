// What a solve says of its rungs, and the sizes inside them.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "ifa/base/error.hpp"
#include "solutions.hpp"

namespace ifa {
namespace {

using sample::cube;
using sample::expect_honest;
using sample::expect_same_bytes;
using sample::first_rung;
using sample::marks_at;
using sample::of_a_throw;

void expect_stage(const Stage& stage, const Solution& best) {
  EXPECT_EQ(stage.score, best.score);
  EXPECT_EQ(stage.succeeded, best.succeeded);
  EXPECT_EQ(stage.plausible, best.plausible);
}

TEST(History, IsTheBestOfTheRungsSoFar) {
  const Body body = cube();
  std::size_t most = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Marks marks = of_a_throw(body, seed, 6);
    SolveOptions climbing;
    climbing.seed = seed;
    climbing.time_budget_s = 600.0;  // until it is plausible
    const Solution s = solve_forward(body, marks, climbing, nullptr);
    ASSERT_FALSE(s.history.empty());
    expect_stage(s.history.back(), s);
    most = std::max(most, s.history.size());
    double last_s = 0.0;
    std::optional<Solution> best;
    for (const Stage& stage : s.history) {
      EXPECT_GT(stage.time_s, last_s);
      last_s = stage.time_s;
      SolveOptions alone = climbing;
      alone.rung = stage.rung;
      Solution own = solve_forward(body, marks, alone, nullptr);
      ASSERT_EQ(own.history.size(), 1u);
      if (!best || better(own, *best)) best = std::move(own);
      expect_stage(stage, *best);
    }
    for (const Solution& other : s.others) EXPECT_TRUE(other.history.empty());
  }
  EXPECT_GT(most, 1u);  // some had to climb
}

TEST(Proposals, MoreOfThemAreMoreSimulatedAndAsHonest) {
  const Body body = cube();
  const Marks marks = marks_at({0.2, 0.32, 0.41, 0.47}, Ending::open);
  const auto with = [&](int roots, int variants) {
    SolveOptions options = first_rung();
    options.proposals = {roots, variants};
    Solution s = solve_forward(body, marks, options, nullptr);
    expect_honest(body, marks, s);
    return s;
  };
  EXPECT_LT(with(1, 0).simulated_s, with(3, 4).simulated_s);
  EXPECT_LT(with(3, 4).simulated_s, with(8, 16).simulated_s);
  expect_same_bytes(with(3, 4), solve_forward(body, marks, first_rung(), nullptr));
}

TEST(Proposals, SenselessOnesAreRefused) {
  SolveOptions options = first_rung();
  options.proposals.roots = 0;
  EXPECT_THROW(solve_forward(cube(), marks_at({0.2, 0.3}), options, nullptr), ArgumentError);
  options.proposals = {1, -1};
  EXPECT_THROW(solve_forward(cube(), marks_at({0.2, 0.3}), options, nullptr), ArgumentError);
}

}  // namespace
}  // namespace ifa
