#include "ifa/forward/root.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace ifa {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

struct Counted {
  std::vector<RootPoint> calls;

  template <class F>
  auto of(F f) {
    return [this, f](double x) -> std::optional<double> {
      const std::optional<double> value = f(x);
      if (value) calls.push_back({x, *value});
      return value;
    };
  }
};

TEST(CloseIn, FindsTheRootOfASmoothFunction) {
  const auto cubic = [](double x) { return x * x * x - 0.3; };
  Counted counted;
  close_in({0.0, cubic(0.0)}, {1.0, cubic(1.0)}, counted.of(cubic), 1e-12, 50);
  EXPECT_LE(std::abs(counted.calls.back().value), 1e-12);
  EXPECT_NEAR(counted.calls.back().x, std::cbrt(0.3), 1e-11);
  EXPECT_LT(counted.calls.size(), 15u);  // order 1.44; halving needs 40
}

TEST(CloseIn, ALineTakesOneValue) {
  Counted counted;
  close_in({0.0, -1.0}, {2.0, 3.0}, counted.of([](double x) { return 2.0 * x - 1.0; }), 1e-12, 50);
  EXPECT_EQ(counted.calls.size(), 1u);
  EXPECT_EQ(counted.calls.back().x, 0.5);
}

// Where a value jumps over zero nothing better than the two sides exists; every value stays between the ends.
TEST(CloseIn, ClosesInOnAJump) {
  for (const double low : {-1e-3, -1.0, -100.0}) {
    Counted counted;
    const auto jump = [&](double x) { return x < 0.37 ? low : 2.0; };
    close_in({0.0, low}, {1.0, 2.0}, counted.of(jump), 1e-9, 60);
    EXPECT_EQ(counted.calls.size(), 60u);
    for (const RootPoint& p : counted.calls) EXPECT_TRUE(p.x > 0.0 && p.x < 1.0);
    EXPECT_NEAR(counted.calls.back().x, 0.37, 1e-3) << low;
  }
}

TEST(CloseIn, HalvesNextToInfinity) {
  Counted counted;
  const auto f = [](double x) { return x < 0.6 ? x - 0.5 : kInfinite; };
  close_in({0.0, -0.5}, {1.0, kInfinite}, counted.of(f), 1e-12, 60);
  EXPECT_NEAR(counted.calls.back().x, 0.5, 1e-11);
  EXPECT_EQ(counted.calls.front().x, 0.5 * (0.0 + 1.0));
}

TEST(CloseIn, TakesDescendingFunctionsToo) {
  Counted counted;
  close_in({0.0, 0.5}, {1.0, -0.5}, counted.of([](double x) { return 0.5 - x * x; }), 1e-12, 60);
  EXPECT_NEAR(counted.calls.back().x, std::sqrt(0.5), 1e-11);
}

TEST(CloseIn, StopsWhereUndefinedAndAtTheLimit) {
  int calls = 0;
  close_in(
      {0.0, -1.0}, {1.0, 1.0},
      [&](double) -> std::optional<double> {
        ++calls;
        return std::nullopt;
      },
      1e-12, 60);
  EXPECT_EQ(calls, 1);
  Counted counted;
  close_in({0.0, -1.0}, {1.0, 1.0}, counted.of([](double x) { return x < 0.123456 ? -1.0 : 1.0; }), 1e-12, 5);
  EXPECT_EQ(counted.calls.size(), 5u);
}

TEST(FindRoot, TriesUntilTheSignChanges) {
  Counted counted;
  const auto f = counted.of([](double x) { return x * x - 2.0; });
  const auto seen = find_root(f, {0.5, 1.0, 1.2, 3.0, 1e9}, 1e-10, 50);
  EXPECT_NEAR(seen.back().x, std::sqrt(2.0), 1e-9);
  for (const RootPoint& p : counted.calls) EXPECT_NE(p.x, 1e9);  // not needed any more
  for (std::size_t i = 1; i < seen.size(); ++i)
    EXPECT_GE(std::abs(seen[i - 1].value), std::abs(seen[i].value));
  EXPECT_EQ(seen.size(), counted.calls.size());
}

TEST(FindRoot, GivesTheBestWhereThereIsNoRoot) {
  const auto seen =
      find_root([](double x) -> std::optional<double> { return x + 10.0; }, {3.0, 1.0, 2.0}, 1e-9, 50);
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_EQ(seen.back().x, 1.0);
}

TEST(FindRoot, SkipsUndefinedAndInfiniteValues) {
  const auto f = [](double x) -> std::optional<double> {
    if (x < 0.0) return std::nullopt;
    return x > 5.0 ? kInfinite : x - 1.0;
  };
  for (const RootPoint& p : find_root(f, {-1.0, 6.0, 0.0}, 1e-9, 60)) EXPECT_TRUE(std::isfinite(p.value));
  EXPECT_NEAR(find_root(f, {-1.0, 6.0, 0.0}, 1e-9, 60).back().x, 1.0, 1e-9);
  EXPECT_TRUE(
      find_root([](double) { return std::optional<double>(kInfinite); }, {1.0, 2.0}, 1e-9, 60).empty());
  EXPECT_TRUE(find_root([](double) { return std::optional<double>(); }, {1.0, 2.0}, 1e-9, 60).empty());
  EXPECT_TRUE(find_root(f, {}, 1e-9, 60).empty());
}

TEST(FindRoot, StopsAtATrialThatIsOne) {
  Counted counted;
  const auto seen = find_root(counted.of([](double x) { return x - 2.0; }), {1.0, 2.0, 3.0}, 1e-9, 50);
  EXPECT_EQ(counted.calls.size(), 2u);
  EXPECT_EQ(seen.back().x, 2.0);
}

}  // namespace
}  // namespace ifa
