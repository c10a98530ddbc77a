#include <gtest/gtest.h>

#include "ifa/motion/difference.hpp"
#include "ifa/solution/solution.hpp"
#include "solutions.hpp"

namespace ifa {
namespace {

using sample::cube;
using sample::expect_honest;
using sample::expect_same_bytes;
using sample::first_rung;
using sample::marks_at;
using sample::of_a_throw;

std::vector<Solution> takes_of(const Body& body, const Marks& marks, SolveOptions options, int takes) {
  options.takes = takes;
  Solution s = solve_forward(body, marks, options, nullptr);
  std::vector<Solution> all = std::move(s.others);
  all.insert(all.begin(), std::move(s));
  return all;
}

// How many there are.
std::size_t expect_takes(const Body& body, const Marks& marks, int most) {
  const auto takes = takes_of(body, marks, first_rung(), most);
  for (std::size_t i = 0; i < takes.size(); ++i) {
    expect_honest(body, marks, takes[i]);
    EXPECT_TRUE(takes[i].plausible);
    EXPECT_TRUE(takes[i].others.empty());
    if (i > 1) {
      EXPECT_FALSE(better(takes[i], takes[i - 1]));  // after the solve's own motion, best first
    }
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GE(difference(*takes[i].motion, *takes[j].motion, marks.times_s.front(), marks.times_s.back()),
                kClearlyDifferent);
    }
  }
  EXPECT_TRUE(takes[0].kept);
  return takes.size();
}

TEST(Takes, ArePlausibleHonestAndClearlyDifferent) {
  const Body body = cube();
  const Marks roll = of_a_throw(body, 1, 5), toss = marks_at({0.2, 0.32, 0.41, 0.47}, Ending::open);
  EXPECT_EQ(expect_takes(body, toss, 5), 5u);
  EXPECT_GE(expect_takes(body, roll, 5), 2u);  // few come to rest just then
}

TEST(Takes, OfOneMarkDifferToTheEnd) {
  const Body body = cube();
  const Marks marks = marks_at({0.4}, Ending::open);
  const auto takes = takes_of(body, marks, first_rung(), 3);
  ASSERT_EQ(takes.size(), 3u);
  for (std::size_t i = 1; i < takes.size(); ++i)
    EXPECT_GE(difference(*takes[0].motion, *takes[i].motion, 0.4,
                         std::max(takes[0].motion->end_s(), takes[i].motion->end_s())),
              kClearlyDifferent);
}

TEST(Takes, AreTheSameForAnyNumberOfThreads) {
  const Body body = cube();
  const Marks marks = marks_at({0.2, 0.32, 0.41}, Ending::open);
  const auto one = takes_of(body, marks, first_rung(4, 1), 4);
  for (const int threads : {1, 2, 3}) {
    const auto more = takes_of(body, marks, first_rung(4, threads), 4);
    ASSERT_EQ(more.size(), one.size());
    for (std::size_t i = 0; i < one.size(); ++i) expect_same_bytes(one[i], more[i]);
  }
}

// More takes cannot make the best one worse.
TEST(Takes, BestIsAtLeastAsGoodAsTheOnlyOne) {
  const Body body = cube();
  const Marks marks = of_a_throw(body, 2, 6);
  const auto only = takes_of(body, marks, first_rung(), 1), three = takes_of(body, marks, first_rung(), 3);
  EXPECT_EQ(only.size(), 1u);
  EXPECT_FALSE(better(only[0], three[0]));
}

// A ball's bounces without spin leave little choice, and it looks the same from all sides: fewer takes than
// asked, in bounded time.
TEST(Takes, MayBeFewerThanAsked) {
  const Body ball = sample::ball(0.02, 0.03, {0.5, 0.3, 1e-3, 1e-3});
  const Marks marks = marks_at({0.1, 0.4, 0.55, 0.625}, Ending::open);
  const auto takes = takes_of(ball, marks, first_rung(), 1000);
  EXPECT_GE(takes.size(), 1u);
  EXPECT_LT(takes.size(), 1000u);
}

// Where none is plausible, the others need only succeed; where none succeeds, there are none.
TEST(Takes, OfMarksThatCannotBeMetThereIsOne) {
  const Body ball = sample::ball(0.02, 0.03, {0.4, 0.3, 1e-3, 1e-3});
  const auto takes = takes_of(ball, marks_at({0.2, 0.3, 0.8}, Ending::open), first_rung(), 3);
  EXPECT_EQ(takes.size(), 1u);
  EXPECT_FALSE(takes[0].succeeded);
}

}  // namespace
}  // namespace ifa
