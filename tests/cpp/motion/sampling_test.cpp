// Random states against the closed-form distributions they are to have, by Kolmogorov and Smirnov's test.
// The seed is fixed, so a test passes always or never.
#include "ifa/motion/sampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <vector>

namespace ifa {
namespace {

constexpr std::size_t kSamples = 20000;
constexpr double kDegree = std::numbers::pi / 180.0;
// sqrt(n) times the largest distance of the empirical from the true CDF stays below 1.95 with probability
// 0.999 (Kolmogorov's distribution); a wrong distribution grows with sqrt(n) = 141.
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

std::function<double(double)> uniform_cdf(double low, double high) {
  return [=](double x) { return std::clamp((x - low) / (high - low), 0.0, 1.0); };
}

// No two corners alike, principal axes far from those of the vertices.
Body shard() {
  Body::Definition d;
  d.vertices_m = {{0.02, 0.0, -0.01}, {-0.01, 0.013, 0.0}, {-0.004, -0.02, 0.003}, {0.001, 0.002, 0.03}};
  d.radius_m = 0.001;
  d.mass_kg = 0.02;
  d.inertia_kg_m2 << 3e-6, 4e-7, -2e-7, 4e-7, 2.5e-6, 3e-7, -2e-7, 3e-7, 2e-6;
  return Body::make(d);
}

std::vector<State> sample(const Body& body, const SamplingOptions& options, std::size_t n = kSamples,
                          std::uint64_t first = 0, int threads = 2, std::uint64_t seed = 2026) {
  std::vector<State> states(n);
  sample_states(body, options, seed, first, states, threads);
  return states;
}

std::vector<double> each(const std::vector<State>& states, const std::function<double(const State&)>& value) {
  std::vector<double> out;
  for (const State& s : states) out.push_back(value(s));
  return out;
}

std::array<double, 13> numbers(const State& s) {
  const auto &x = s.position, &v = s.velocity, &w = s.angular_velocity;
  const Quat& q = s.orientation;
  return {x.x(), x.y(), x.z(), q.w(), q.x(), q.y(), q.z(), v.x(), v.y(), v.z(), w.x(), w.y(), w.z()};
}

bool same_bytes(const State& a, const State& b) {
  const auto x = numbers(a), y = numbers(b);
  return std::memcmp(x.data(), y.data(), sizeof x) == 0;
}

TEST(Sampling, TheLowestPointTouchesTheGround) {
  const Body body = shard();
  for (const State& s : sample(body, {}, 1000)) {
    EXPECT_EQ(s.position.x(), 0.0);
    EXPECT_EQ(s.position.y(), 0.0);
    double lowest = 1.0;
    for (const Vec3& p : body.principal_vertices())
      lowest = std::min(lowest, (s.position + s.orientation.toRotationMatrix() * p).z());
    EXPECT_NEAR(lowest, body.radius_m(), 1e-17 * 4);  // a few roundings of lengths below 0.03 m
  }
}

TEST(Sampling, SpeedsAndSpinsAreUniformBetweenTheirBounds) {
  const SamplingOptions options{30.0 * kDegree, 1.0, 1.5, 5.0, 9.0};
  const auto states = sample(shard(), options);
  const auto speeds = each(states, [](const State& s) { return s.velocity.norm(); });
  const auto spins = each(states, [](const State& s) { return s.angular_velocity.norm(); });
  EXPECT_LT(kolmogorov_statistic(speeds, uniform_cdf(1.0, 1.5)), kKolmogorovLimit);
  EXPECT_LT(kolmogorov_statistic(spins, uniform_cdf(5.0, 9.0)), kKolmogorovLimit);
}

// The density over the sphere is proportional to the cosine of the angle to straight down, so the share
// within an angle a of it is sin^2 a / sin^2 cone.
TEST(Sampling, DirectionsAreCosineWeightedWithinTheCone) {
  for (const double cone : {10.0 * kDegree, 30.0 * kDegree, 80.0 * kDegree, 90.0 * kDegree}) {
    const auto states = sample(shard(), {cone, 0.5, 4.0, 0.0, 20.0});
    const auto angles = each(states, [](const State& s) {
      return std::atan2(std::hypot(s.velocity.x(), s.velocity.y()), -s.velocity.z());
    });
    const double widest = std::sin(cone);
    EXPECT_LT(kolmogorov_statistic(
                  angles, [widest](double a) { return std::pow(std::min(std::sin(a) / widest, 1.0), 2); }),
              kKolmogorovLimit);
    EXPECT_LE(*std::max_element(angles.begin(), angles.end()), cone + 1e-15);  // rounding of atan2
    const auto azimuths =
        each(states, [](const State& s) { return std::atan2(s.velocity.y(), s.velocity.x()); });
    EXPECT_LT(kolmogorov_statistic(azimuths, uniform_cdf(-std::numbers::pi, std::numbers::pi)),
              kKolmogorovLimit);
  }
}

// Uniform orientations map each axis to a uniform direction, whose every component is uniform on [-1, 1]
// (Archimedes); so are those of the spin's direction.
TEST(Sampling, OrientationsAndSpinAxesAreUniform) {
  const auto states = sample(shard(), {});
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const auto entries =
          each(states, [=](const State& s) { return s.orientation.toRotationMatrix()(row, column); });
      EXPECT_LT(kolmogorov_statistic(entries, uniform_cdf(-1.0, 1.0)), kKolmogorovLimit);
    }
    const auto axis = each(states, [=](const State& s) { return s.angular_velocity.normalized()[row]; });
    EXPECT_LT(kolmogorov_statistic(axis, uniform_cdf(-1.0, 1.0)), kKolmogorovLimit);
  }
}

// The correlation of n independent pairs has the standard deviation 1 / sqrt(n); 4 of them is one failure in
// 16,000.
TEST(Sampling, SpeedSpinDirectionAndOrientationAreIndependent) {
  const auto states = sample(shard(), {});
  const std::vector<std::vector<double>> variables = {
      each(states, [](const State& s) { return s.velocity.norm(); }),
      each(states, [](const State& s) { return s.angular_velocity.norm(); }),
      each(states, [](const State& s) { return std::pow(s.velocity.normalized().z(), 2); }),
      each(states, [](const State& s) { return s.orientation.toRotationMatrix()(2, 2); }),
      each(states, [](const State& s) { return s.angular_velocity.normalized().z(); })};
  const double n = static_cast<double>(kSamples);
  const auto mean = [&](const std::vector<double>& x) {
    double sum = 0.0;
    for (const double value : x) sum += value;
    return sum / n;
  };
  const auto covariance = [&](const std::vector<double>& x, const std::vector<double>& y) {
    const double mx = mean(x), my = mean(y);
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += (x[i] - mx) * (y[i] - my);
    return sum / n;
  };
  for (std::size_t a = 0; a < variables.size(); ++a)
    for (std::size_t b = a + 1; b < variables.size(); ++b) {
      const auto &x = variables[a], &y = variables[b];
      EXPECT_LT(std::abs(covariance(x, y)) / std::sqrt(covariance(x, x) * covariance(y, y)),
                4.0 / std::sqrt(n))
          << a << ", " << b;
    }
}

TEST(Sampling, ASampleDependsOnItsSeedAndNumberOnly) {
  const Body body = shard();
  const auto all = sample(body, {}, 100);
  for (const int threads : {1, 2, 3, 7}) {
    const auto again = sample(body, {}, 100, 0, threads);
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_TRUE(same_bytes(all[i], again[i])) << threads;
  }
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{63}, std::size_t{99}})
    EXPECT_TRUE(same_bytes(all[i], sample(body, {}, 1, i)[0])) << i;
  EXPECT_FALSE(same_bytes(all[0], sample(body, {}, 1, 0, 1, 2027)[0]));
  EXPECT_FALSE(same_bytes(all[0], all[1]));
}

TEST(Sampling, TheLastSampleOfASeedIsThere) {
  const std::uint64_t last = ~std::uint64_t{0};
  const State s = sample(shard(), {}, 1, last)[0];
  EXPECT_NEAR(s.orientation.norm(), 1.0, 1e-15);  // a few roundings
}

TEST(Sampling, StopsWhenCancelled) {
  Progress progress;
  progress.cancel();
  std::vector<State> states(10);
  EXPECT_THROW(sample_states(shard(), {}, 0, 0, states, 2, &progress), Cancelled);
}

}  // namespace
}  // namespace ifa
