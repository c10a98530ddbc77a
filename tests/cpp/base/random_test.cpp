// Philox against the published known answers; the distributions against their closed-form CDFs by
// Kolmogorov and Smirnov's test. Seeds are fixed, so a test passes always or never.
#include "ifa/base/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace ifa {
namespace {

using Words4 = std::array<std::uint32_t, 4>;

constexpr int kSamples = 50000;
// sqrt(n) times the largest distance of the empirical from the true CDF stays below 1.95 with
// probability 0.999 (Kolmogorov's distribution); a wrong distribution grows with sqrt(n) = 224.
constexpr double kKolmogorovLimit = 1.95;

double kolmogorov_statistic(std::vector<double> samples, const std::function<double(double)>& cdf) {
  std::sort(samples.begin(), samples.end());
  const double n = static_cast<double>(samples.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double p = cdf(samples[i]);
    largest = std::max({largest, p - static_cast<double>(i) / n, static_cast<double>(i + 1) / n - p});
  }
  return std::sqrt(n) * largest;
}

std::vector<double> draw(const std::function<double(RandomStream&)>& sample) {
  std::vector<double> samples(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    RandomStream stream(2026, static_cast<std::uint64_t>(i));  // one stream for each, as the solver does
    samples[static_cast<std::size_t>(i)] = sample(stream);
  }
  return samples;
}

double uniform_cdf(double x) { return std::clamp(x, 0.0, 1.0); }
double symmetric_cdf(double x) { return std::clamp(0.5 * (x + 1.0), 0.0, 1.0); }  // uniform on [-1, 1]

// The known-answer vectors of philox4x32-10 published with the paper's reference implementation.
TEST(Philox, KnownAnswers) {
  EXPECT_EQ(philox4x32_10({0, 0, 0, 0}, {0, 0}),
            (Words4{0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u}));
  EXPECT_EQ(philox4x32_10({~0u, ~0u, ~0u, ~0u}, {~0u, ~0u}),
            (Words4{0x408f276du, 0x41c83b0eu, 0xa20bc7c6u, 0x6d5451fdu}));
  EXPECT_EQ(philox4x32_10({0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u}, {0xa4093822u, 0x299f31d0u}),
            (Words4{0xd16cfe09u, 0x94fdccebu, 0x5001e420u, 0x24126ea1u}));
}

// The bytes of a solve depend on this mapping of words to doubles: it may never change.
TEST(RandomStream, FirstDrawsAreTheKnownWords) {
  RandomStream stream(0, 0);
  EXPECT_EQ(stream.uniform(), static_cast<double>(0xe169c58d6627e8d5ull >> 11) * 0x1.0p-53);
  EXPECT_EQ(stream.uniform(), static_cast<double>(0x9b00dbd8bc57ac4cull >> 11) * 0x1.0p-53);
  RandomStream keyed(0x299f31d0a4093822ull, 0x0370734413198a2eull);
  const Words4 words = philox4x32_10({0, 0, 0x13198a2eu, 0x03707344u}, {0xa4093822u, 0x299f31d0u});
  EXPECT_EQ(keyed.uniform(),
            static_cast<double>(((std::uint64_t{words[1]} << 32) | words[0]) >> 11) * 0x1.0p-53);
}

TEST(RandomStream, UniformFillsTheHalfOpenUnitInterval) {
  const auto samples = draw([](RandomStream& s) { return s.uniform(); });
  EXPECT_GE(*std::min_element(samples.begin(), samples.end()), 0.0);
  EXPECT_LT(*std::max_element(samples.begin(), samples.end()), 1.0);
  EXPECT_LT(kolmogorov_statistic(samples, uniform_cdf), kKolmogorovLimit);
}

TEST(RandomStream, UniformMapsToItsBounds) {
  const auto samples = draw([](RandomStream& s) { return s.uniform(-3.0, 5.0); });
  EXPECT_LT(kolmogorov_statistic(samples, [](double x) { return uniform_cdf((x + 3.0) / 8.0); }),
            kKolmogorovLimit);
}

TEST(RandomStream, SuccessiveDrawsOfOneStreamAreUniform) {
  RandomStream stream(7, 11);
  std::vector<double> samples(kSamples);
  for (double& sample : samples) sample = stream.uniform();
  EXPECT_LT(kolmogorov_statistic(samples, uniform_cdf), kKolmogorovLimit);
}

TEST(RandomStream, NormalHasTheNormalDistribution) {
  const auto samples = draw([](RandomStream& s) { return s.normal(); });
  const auto cdf = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
  EXPECT_LT(kolmogorov_statistic(samples, cdf), kKolmogorovLimit);
}

// Archimedes: each component of a uniform direction is uniform on [-1, 1].
TEST(RandomStream, UnitVectorIsUniformOnTheSphere) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto samples = draw([axis](RandomStream& s) { return s.unit_vector()[axis]; });
    EXPECT_LT(kolmogorov_statistic(samples, symmetric_cdf), kKolmogorovLimit) << "axis " << axis;
  }
  RandomStream stream(1, 2);
  for (int i = 0; i < 1000; ++i) EXPECT_NEAR(stream.unit_vector().norm(), 1.0, 1e-15);  // a few roundings
}

// Under the uniform (Haar) measure every column of the rotation matrix is a uniform direction and the
// angle has the density (1 - cos) / pi on [0, pi].
TEST(RandomStream, RotationIsUniform) {
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      const auto entries =
          draw([=](RandomStream& s) { return s.rotation().toRotationMatrix()(row, column); });
      EXPECT_LT(kolmogorov_statistic(entries, symmetric_cdf), kKolmogorovLimit)
          << "entry " << row << ", " << column;
    }
  }
  const auto angles = draw([](RandomStream& s) {
    const Quat q = s.rotation();
    return 2.0 * std::atan2(q.vec().norm(), std::abs(q.w()));
  });
  const auto cdf = [](double angle) { return (angle - std::sin(angle)) / std::numbers::pi; };
  EXPECT_LT(kolmogorov_statistic(angles, cdf), kKolmogorovLimit);
}

TEST(RandomStream, RotationIsAUnitQuaternion) {
  RandomStream stream(3, 4);
  for (int i = 0; i < 1000; ++i) EXPECT_NEAR(stream.rotation().norm(), 1.0, 1e-15);  // a few roundings
}

// Neighbouring streams and seeds are what the solver uses side by side. The correlation of n
// independent pairs has the standard deviation 1 / sqrt(n); 4 of them is one failure in 16,000.
TEST(RandomStream, NeighbouringStreamsAndSeedsAreUncorrelated) {
  const auto correlation = [](RandomStream a, RandomStream b) {
    double sum = 0.0;
    for (int i = 0; i < kSamples; ++i) sum += (a.uniform() - 0.5) * (b.uniform() - 0.5) * 12.0;
    return sum / kSamples;
  };
  const double limit = 4.0 / std::sqrt(static_cast<double>(kSamples));
  EXPECT_LT(std::abs(correlation({5, 0}, {5, 1})), limit);
  EXPECT_LT(std::abs(correlation({5, 0}, {6, 0})), limit);
  EXPECT_LT(std::abs(correlation({5, 6}, {6, 5})), limit);
}

}  // namespace
}  // namespace ifa
