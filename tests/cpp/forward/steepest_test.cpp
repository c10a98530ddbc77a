#include "ifa/forward/steepest.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <vector>

#include "ifa/base/random.hpp"

namespace ifa {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kRidge = 0.02;  // added to the squares of the coordinates

Vec6 random_point(RandomStream& random) {
  Vec6 y;
  for (int i = 0; i < 6; ++i) y[i] = random.uniform(-0.5, 0.5);
  return y;
}

std::vector<Sample6> samples_of(const Vec6& gradient, double middle, int n, RandomStream& random) {
  std::vector<Sample6> samples;
  for (int i = 0; i < n; ++i) {
    const Vec6 y = random_point(random);
    samples.push_back({y, middle + gradient.dot(y)});
  }
  return samples;
}

// Of the centred samples: eigenvalues ascending.
Eigen::SelfAdjointEigenSolver<Mat6> spread(const std::vector<Sample6>& samples) {
  Vec6 centre = Vec6::Zero();
  for (const Sample6& s : samples) centre += s.y / static_cast<double>(samples.size());
  Mat6 squares = Mat6::Zero();
  for (const Sample6& s : samples) squares += (s.y - centre) * (s.y - centre).transpose();
  return Eigen::SelfAdjointEigenSolver<Mat6>(squares);
}

// Of a linear function the model is off by what the ridge takes: along an axis of the samples' spread with
// square sum s, the share 0.02 / (s + 0.02). Ever more samples make it exact.
TEST(Steepest, IsExactOnLinearFunctionsUpToTheRidge) {
  for (std::uint64_t i = 0; i < 50; ++i) {
    RandomStream random(6, i);
    const Vec6 gradient = 3.0 * random_point(random);
    const double middle = random.uniform(-1.0, 1.0);
    for (const int n : {8, 30, 20000}) {
      const auto samples = samples_of(gradient, middle, n, random);
      const auto model = steepest(samples);
      ASSERT_TRUE(model);
      EXPECT_NEAR(model->along.norm(), 1.0, 1e-14);
      const Vec6 found = model->slope * model->along;
      const double share = kRidge / (spread(samples).eigenvalues()[0] + kRidge);
      EXPECT_LE((found - gradient).norm(), (share + 1e-12) * gradient.norm()) << n;
      EXPECT_NEAR(model->middle, middle, (share + 1e-12) * gradient.norm() * 1.3)
          << n;  // sqrt(6) / 2: a corner
      if (n == 20000) {
        EXPECT_NEAR(model->root(), -middle / gradient.norm(), 3e-5 * (1.0 + std::abs(model->root())));
      }
    }
  }
}

// Samples on both sides of each axis: in closed form.
TEST(Steepest, OfAStarIsKnown) {
  constexpr double kArm = 0.4;
  const Vec6 gradient{1.0, -2.0, 0.5, 0.0, 3.0, -1.0};
  std::vector<Sample6> samples;
  for (int i = 0; i < 6; ++i)
    for (const double side : {-kArm, kArm})
      samples.push_back({Vec6(side * Vec6::Unit(i)), 0.7 + side * gradient[i]});
  const auto model = steepest(samples);
  ASSERT_TRUE(model);
  const double kept = 2.0 * kArm * kArm / (2.0 * kArm * kArm + kRidge);
  EXPECT_NEAR(model->slope, kept * gradient.norm(), 1e-14);
  EXPECT_NEAR((model->along - gradient.normalized()).norm(), 0.0, 1e-14);
  EXPECT_NEAR(model->middle, 0.7, 1e-15);
  EXPECT_NEAR(model->root(), -0.7 / model->slope, 1e-15);
}

// Fewer samples than unknowns: nothing is known across them, and nothing is claimed. What is claimed within
// their span is the function's own gradient there, but for the ridge.
TEST(Steepest, FewSamplesGiveTheGradientWithinTheirSpan) {
  for (std::uint64_t i = 0; i < 100; ++i) {
    RandomStream random(7, i);
    const int n = 4 + static_cast<int>(i % 3), rank = n - 1;
    const Vec6 gradient = random_point(random);
    const auto samples = samples_of(gradient, 0.2, n, random);
    const auto model = steepest(samples);
    ASSERT_TRUE(model);
    const Vec6 found = model->slope * model->along;
    const auto axes = spread(samples);
    Vec6 expected = Vec6::Zero();
    for (int axis = 0; axis < 6; ++axis) {
      const Vec6 direction = axes.eigenvectors().col(axis);
      const double square = axes.eigenvalues()[axis];
      if (axis < 6 - rank) {
        EXPECT_NEAR(found.dot(direction), 0.0, 1e-12) << i;
      } else {
        expected += square / (square + kRidge) * gradient.dot(direction) * direction;
      }
    }
    EXPECT_NEAR((found - expected).norm(), 0.0, 1e-12) << i;
  }
}

TEST(Steepest, LeavesOutWhatIsNotFinite) {
  RandomStream random(8, 0);
  auto samples = samples_of(random_point(random), -0.4, 10, random);
  const auto clean = steepest(samples);
  samples.insert(samples.begin() + 3, {random_point(random), kInfinite});
  samples.push_back({random_point(random), std::nan("")});
  samples.push_back({random_point(random), -kInfinite});
  const auto model = steepest(samples);
  ASSERT_TRUE(clean && model);
  EXPECT_EQ(model->along, clean->along);
  EXPECT_EQ(model->slope, clean->slope);
  EXPECT_EQ(model->middle, clean->middle);
}

TEST(Steepest, SaysNothingFromTooFewOrFlatSamples) {
  RandomStream random(9, 0);
  const Vec6 gradient = random_point(random);
  EXPECT_FALSE(steepest({}));
  EXPECT_FALSE(steepest(samples_of(gradient, 0.0, 3, random)));
  EXPECT_TRUE(steepest(samples_of(gradient, 0.0, 4, random)));
  EXPECT_FALSE(steepest(samples_of(Vec6::Zero(), 0.5, 12, random)));  // flat
  std::vector<Sample6> infinite(12, {Vec6(Vec6::Ones()), kInfinite}), one(12, {Vec6(Vec6::Ones()), 1.0});
  EXPECT_FALSE(steepest(infinite));
  EXPECT_FALSE(steepest(one));  // all at one place
  auto three = samples_of(gradient, 0.0, 3, random);
  three.insert(three.end(), infinite.begin(), infinite.end());
  EXPECT_FALSE(steepest(three));
}

}  // namespace
}  // namespace ifa
