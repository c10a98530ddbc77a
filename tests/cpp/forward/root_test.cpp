#include "ifa/forward/root.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <vector>

#include "ifa/base/random.hpp"

namespace ifa {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Where it looked, in turn, until a value is within `enough` of 0 or the ends meet up to rounding. Every
// point must lie between the two ends that have been seen nearest to the sign change.
std::vector<RootPoint> seek(const std::function<double(double)>& f, double low, double high, double enough,
                            int most) {
  Bracket bracket({low, f(low)}, {high, f(high)});
  const bool above = f(low) > 0.0;
  std::vector<RootPoint> seen;
  while (static_cast<int>(seen.size()) < most && high - low > 1e-12) {
    const double x = bracket.next(), value = f(x);
    EXPECT_TRUE(low < x && x < high) << low << " " << x << " " << high;
    ((value > 0.0) == above ? low : high) = x;
    bracket.add({x, value});
    seen.push_back({x, value});
    EXPECT_EQ(bracket.width(), high - low);
    if (std::abs(value) <= enough) break;
  }
  return seen;
}

TEST(Bracket, FindsTheRootOfASmoothFunction) {
  const auto seen = seek([](double x) { return x * x * x - 0.3; }, 0.0, 1.0, 1e-12, 50);
  EXPECT_LE(std::abs(seen.back().value), 1e-12);
  EXPECT_NEAR(seen.back().x, std::cbrt(0.3), 1e-11);
  EXPECT_LT(seen.size(), 15u);  // order 1.44; halving needs 40
}

TEST(Bracket, ALineTakesOneValue) {
  const auto seen = seek([](double x) { return 2.0 * x - 1.0; }, 0.0, 2.0, 1e-12, 50);
  EXPECT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen.back().x, 0.5);
}

TEST(Bracket, TakesDescendingFunctionsToo) {
  const auto seen = seek([](double x) { return 0.5 - x * x; }, 0.0, 1.0, 1e-12, 60);
  EXPECT_NEAR(seen.back().x, std::sqrt(0.5), 1e-11);
}

// Where a value jumps over zero nothing better than the two sides exists.
TEST(Bracket, ClosesInOnAJump) {
  for (const double low : {-1e-3, -1.0, -100.0}) {
    const auto seen = seek([&](double x) { return x < 0.37 ? low : 2.0; }, 0.0, 1.0, 1e-9, 60);
    EXPECT_NEAR(seen.back().x, 0.37, 1e-3) << low;
  }
}

TEST(Bracket, HalvesNextToInfinity) {
  const auto seen = seek([](double x) { return x < 0.6 ? x - 0.5 : kInfinite; }, 0.0, 1.0, 1e-12, 60);
  EXPECT_NEAR(seen.back().x, 0.5, 1e-11);
  const auto gap = seek([](double x) { return x < 0.6 ? -1.0 : kInfinite; }, 0.0, 1.0, 0.0, 30);
  EXPECT_NEAR(gap.back().x, 0.6, 1e-8);  // 2^-30
  EXPECT_EQ(gap.front().x, 0.5);
}

// A secant would step by a millionth of the bracket. It steps by a thousandth at least, and an end that stays
// is weighed half as much each time, which makes up for the factor of a million in 20 values; each time the
// other end is reached, that begins anew.
TEST(Bracket, DoesNotStickToAnEnd) {
  const auto seen = seek([](double x) { return x < 0.7 ? -1e-3 : 1e3; }, 0.0, 1.0, 0.0, 200);
  EXPECT_NEAR(seen.front().x, 1e-3, 1e-15);
  EXPECT_NEAR(seen.back().x, 0.7, 1e-3);
}

// Whatever the function does, the sign change stays enclosed (seek checks that) and the bracket shrinks.
TEST(Bracket, ConvergesOnAnything) {
  for (std::uint64_t i = 0; i < 300; ++i) {
    RandomStream random(5, i);
    const double root = random.uniform(0.05, 0.95), noise = random.uniform() < 0.5 ? 0.3 : 0.0;
    const double gap = random.uniform(0.0, 0.2), scale = std::pow(10.0, random.uniform(-3.0, 3.0));
    const double power = random.uniform(0.3, 3.0);
    const auto f = [&](double x) {
      if (x > root + gap) return kInfinite;
      const double d = x - root;
      return scale * std::copysign(std::pow(std::abs(d), power), d) * (1.0 + noise * std::sin(300.0 * x));
    };
    const auto seen = seek(f, 0.0, 1.0, 0.0, 90);
    EXPECT_NEAR(seen.back().x, root, 1e-6) << i;
  }
}

}  // namespace
}  // namespace ifa
