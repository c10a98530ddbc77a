// Transitions against a look at every pair of flights under every element of the symmetry group.
#include "ifa/graph/transitions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "ifa/graph/harvest.hpp"
#include "ifa/graph/weights.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

constexpr double kGain = 0.0;

struct Pair {
  double cost;
  std::uint32_t target;
};

// All targets of node i, each at its best element, best first.
std::vector<Pair> brute_force(const Nodes& nodes, const Body& body, const Images& images, std::size_t i) {
  std::vector<Pair> all;
  const TakeOffView from = take_off_of(nodes, i);
  const PlausibleRegion region = region_of(nodes, i, body);
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    if (j == i || !flies(nodes, j)) continue;
    double best = 1e300;
    const TakeOffView seen = take_off_of(nodes, j);
    for (std::size_t e = 0; e < images.size(); ++e) {
      const Splice s =
          splice(from, region, image(images.element(e, from.up, seen.up), seen), nodes.flight_s[j]);
      if (s.log_velocity > kLeastLogFactor && s.log_orientation > kLeastLogFactor &&
          keeps_energy(nodes, i, j + 1, s, body, sample::kGravity, kGain))
        best = std::min(best, -s.log_weight());
    }
    if (best < 1e300) all.push_back({best, static_cast<std::uint32_t>(j + 1)});
  }
  std::sort(all.begin(), all.end(), [](const Pair& a, const Pair& b) { return a.cost < b.cost; });
  return all;
}

NodeColumns harvested(const Body& body, std::size_t simulations) {
  return harvest(body, SearchPhysics{}, {}, 5, 0, simulations, 30.0);
}

// `every`: one node of so many is asked from.
void expect_exact(const Body& body, std::size_t simulations, std::size_t every, std::size_t most) {
  const NodeColumns columns = harvested(body, simulations);
  const Nodes nodes = view_of(columns);
  const Images images(Symmetry::of(body));
  const TransitionColumns made = make_transitions(nodes, body, images, sample::kGravity, kGain, most, 2);
  ASSERT_EQ(made.first.size(), nodes.size() + 1);
  ASSERT_EQ(made.first.back(), made.target.size());
  std::size_t compared = 0, cut = 0;
  for (std::size_t i = 0; i < nodes.size(); i += every) {
    const std::size_t begin = made.first[i], count = made.first[i + 1] - begin;
    if (!flies(nodes, i)) {
      EXPECT_EQ(count, 0u);
      continue;
    }
    const std::vector<Pair> all = brute_force(nodes, body, images, i);
    ASSERT_EQ(count, std::min(most, all.size())) << "node " << i;
    const TakeOffView from = take_off_of(nodes, i);
    std::map<std::uint32_t, int> times;
    for (std::size_t k = 0; k < count; ++k) {
      // Both are the same sums; what is stored has 16 bits, half a unit off at most.
      EXPECT_NEAR(made.cost[begin + k] * kCostUnit, all[k].cost, 0.51 * kCostUnit);
      const std::uint32_t target = made.target[begin + k];
      const TakeOffView seen = take_off_of(nodes, target - 1);
      const Splice s = splice(from, region_of(nodes, i, body),
                              image(images.element(made.element[begin + k], from.up, seen.up), seen),
                              nodes.flight_s[target - 1]);
      EXPECT_NEAR(-s.log_weight(), all[k].cost, 1e-9);  // of at most 20: rounding
      EXPECT_EQ(++times[target], 1);
    }
    compared += count;
    cut += all.size() > most;
  }
  EXPECT_GT(compared, 100u);  // else nothing was shown
  if (most < 100) {
    EXPECT_GT(cut, 0u);
  }
}

Body die() { return sample::box(Vec3::Constant(0.016), 0.005, {0.5, 0.25}); }
Body card() { return sample::box({0.089, 0.064, 0.0003}, 0.0018, {0.4, 0.3}); }

// Five corners: no symmetry but the identity.
Body lump() {
  Body::Definition d;
  d.vertices_m = {
      {0.01, 0, 0}, {-0.008, 0.004, 0}, {0, -0.009, 0.002}, {0.001, 0.002, 0.007}, {0, 0.003, -0.006}};
  d.mass_kg = 0.004;
  d.inertia_kg_m2 = Vec3(1.1e-7, 1.4e-7, 1.9e-7).asDiagonal();
  d.material = {0.5, 0.25};
  return Body::make(d);
}

TEST(Transitions, AreThoseOfADie) { expect_exact(die(), 600, 17, 1000); }
TEST(Transitions, AreTheBestOfADie) { expect_exact(die(), 600, 17, 5); }
TEST(Transitions, AreThoseOfACard) { expect_exact(card(), 300, 3, 1000); }
TEST(Transitions, AreTheBestOfACard) { expect_exact(card(), 300, 3, 4); }
TEST(Transitions, AreThoseOfABodyWithoutSymmetry) {
  ASSERT_EQ(Images(Symmetry::of(lump())).size(), 1u);
  expect_exact(lump(), 800, 3, 1000);
}
TEST(Transitions, AreThoseOfARod) { expect_exact(sample::rod(0.1, 0.003, 0.01), 120, 7, 1000); }
TEST(Transitions, AreThoseOfABall) { expect_exact(sample::ball(0.01, 0.01, {0.7, 0.2}), 60, 11, 1000); }

TEST(Transitions, AreTheSameForAnyNumberOfThreads) {
  const Body body = die();
  const NodeColumns columns = harvested(body, 200);
  const Images images(Symmetry::of(body));
  const auto made = [&](int threads) {
    return make_transitions(view_of(columns), body, images, sample::kGravity, kGain, 8, threads);
  };
  const TransitionColumns one = made(1), three = made(3);
  EXPECT_EQ(one.first, three.first);
  EXPECT_EQ(one.target, three.target);
  EXPECT_EQ(one.cost, three.cost);
  EXPECT_EQ(one.element, three.element);
}

TEST(Transitions, OfNothing) {
  const Body body = die();
  const Images images(Symmetry::of(body));
  const NodeColumns none;
  EXPECT_EQ(make_transitions(view_of(none), body, images, sample::kGravity, kGain, 8, 2).first,
            std::vector<std::uint64_t>{0});
  const NodeColumns some = harvested(body, 20);
  const auto made = make_transitions(view_of(some), body, images, sample::kGravity, kGain, 0, 2);
  EXPECT_EQ(made.first, std::vector<std::uint64_t>(some.size() + 1, 0));
}

TEST(Transitions, CanBeCancelled) {
  const Body body = die();
  const NodeColumns columns = harvested(body, 50);
  Progress progress;
  progress.cancel();
  EXPECT_THROW(make_transitions(view_of(columns), body, Images(Symmetry::of(body)), sample::kGravity, kGain,
                                8, 2, &progress),
               Cancelled);
}

}  // namespace
}  // namespace ifa
