// The k-d trees against a look at every point.
#include "ifa/graph/trees.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "ifa/base/random.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using Points = std::vector<TreePoint>;

// Powers of two, by which scaling is exact.
TreePoint typical_scales() {
  TreePoint s;
  for (std::size_t a = 0; a < kTreeDimensions; ++a) s[a] = std::ldexp(1.0f, static_cast<int>(a) - 6);
  return s;
}

TreePoint random_point(RandomStream& random, double spread) {
  TreePoint p;
  for (std::size_t a = 0; a < kTreeDimensions; ++a)
    p[a] = static_cast<float>(random.uniform(-spread, spread)) / typical_scales()[a];
  return p;
}

Points uniform(std::size_t n) {
  RandomStream random(1, 0);
  Points points;
  while (points.size() < n) points.push_back(random_point(random, 1.0));
  return points;
}

Points clustered(std::size_t n) {
  RandomStream random(2, 0);
  Points points;
  TreePoint centre{};
  while (points.size() < n) {
    if (points.size() % 100 == 0) centre = random_point(random, 1.0);
    points.push_back(random_point(random, 1e-3));
    for (std::size_t a = 0; a < kTreeDimensions; ++a) points.back()[a] += centre[a];
  }
  return points;
}

Points duplicates(std::size_t n) {
  Points points = uniform(n / 50);
  const Points once = points;
  while (points.size() < n) points.push_back(once[points.size() % once.size()]);
  return points;
}

std::vector<double> all_distances(const Points& points, const TreePoint& at, const TreePoint& scales) {
  std::vector<double> all;
  for (const TreePoint& p : points) {
    double sum = 0.0;
    for (std::size_t a = 0; a < kTreeDimensions; ++a)
      sum += std::pow(
          static_cast<double>(scales[a]) * (static_cast<double>(p[a]) - static_cast<double>(at[a])), 2);
    all.push_back(sum);
  }
  std::ranges::sort(all);
  return all;
}

TEST(ScaledTree, FindsWhatALookAtEveryPointFinds) {
  RandomStream random(3, 0);
  for (const Points& points :
       {uniform(2000), clustered(2000), duplicates(2000), Points(500, uniform(1)[0]), uniform(1), Points{}}) {
    const ScaledTree tree(points, typical_scales());
    for (int q = 0; q < 60; ++q) {
      const TreePoint at = q % 3 == 0 && !points.empty() ? points[0] : random_point(random, 1.2);
      TreePoint scales = typical_scales();
      for (float& s : scales) s *= static_cast<float>(std::exp(random.uniform(-2.0, 2.0)));
      if (q % 4 == 0) scales[11] = 0.0f;  // an axis of no account
      const std::vector<double> all = all_distances(points, at, scales);
      for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{5}, std::size_t{3000},
                                      std::numeric_limits<std::size_t>::max()}) {
        const auto found = tree.nearest(at, scales, count);
        ASSERT_EQ(found.size(), std::min(count, points.size()));
        std::vector<std::uint32_t> rows;
        for (std::size_t f = 0; f < found.size(); ++f) {
          EXPECT_NEAR(found[f].distance, all[f], 1e-12 * (1.0 + all[f]));  // rounding of a dozen doubles
          rows.push_back(found[f].index);
        }
        std::ranges::sort(rows);
        EXPECT_EQ(std::ranges::adjacent_find(rows), rows.end());
      }
    }
  }
}

// Changes along axes, so that the boxes about the plausible regions need no turning.
constexpr float kChange_m_s = 1.0f, kChange_rad_s = 20.0f;

NodeColumns random_nodes(std::size_t simulations) {
  RandomStream random(4, 0);
  NodeColumns c;
  for (std::size_t n = 0; n < 6 * simulations; ++n) {
    const Vec3 up = random.unit_vector(), velocity = random.unit_vector(), spin = 20.0 * random.unit_vector();
    for (const Vec3& v : {up, velocity, spin})
      for (int a = 0; a < 3; ++a) c.take_off.push_back(static_cast<float>(v[a]));
    c.take_off.push_back(0.01f);
    for (const float x : {0.0f, 0.0f, kChange_m_s, kChange_rad_s, 0.0f, 0.0f}) c.change.push_back(x);
    const bool last = n % 6 == 5, long_one = random.uniform() < 0.3;
    c.delay_s.push_back(long_one ? 0.02f : 0.0f);
    c.flight_s.push_back(last || random.uniform() < 0.1 ? 0.0f
                                                        : static_cast<float>(random.uniform(0.05, 0.3)));
    c.length_s.push_back(long_one ? 0.02f : 0.0f);
    c.centroid_s.push_back(long_one ? static_cast<float>(random.uniform(0.0, 0.02)) : 0.0f);
    c.amplitude.push_back(1.0f);
    c.flags.push_back(last ? kTerminal : random.uniform() < 0.1 ? kEdge | kDubious : kEdge);
  }
  return c;
}

TEST(NodeTrees, TheNearestAreThoseOfThePapersMetric) {
  const NodeColumns c = random_nodes(300);
  const Body body = sample::box({0.016, 0.016, 0.016}, 0.005);
  const NodeTrees trees(view_of(c), body);
  Marks marks;
  marks.times_s = {0.0, 0.1, 0.35, 0.5};
  marks.durations_s = {0.0, 0.0, 0.025, 0.0};
  marks.centroids_s = {std::nan(""), std::nan(""), 0.012, std::nan("")};
  const double ln2 = std::numbers::ln2;
  const auto number = [](float x) { return static_cast<double>(x); };
  for (const Ending ending : {Ending::rest, Ending::open}) {
    marks.ending = ending;
    const Targets targets(marks);
    for (std::uint32_t i = 0; i < 120; ++i) {
      for (std::size_t k = 1; k < marks.size(); ++k) {
        const double interval_s = targets.intervals_s[k - 1], flight_s = interval_s - number(c.delay_s[i]);
        std::vector<double> all;
        for (std::size_t m = 1; m < c.size(); ++m) {
          const std::size_t j = m - 1;
          if (c.flight_s[j] == 0.0f || c.flags[j] != kEdge) continue;
          const bool terminal = (c.flags[m] & kTerminal) != 0;
          if (k < 3 ? terminal : !terminal && ending == Ending::rest) continue;
          const auto offs = [&](int first) {
            Vec3 d;
            for (int a = 0; a < 3; ++a)
              d[a] = number(c.take_off[10 * j + static_cast<std::size_t>(first + a)]) -
                     number(c.take_off[10 * i + static_cast<std::size_t>(first + a)]);
            return d;
          };
          // Half widths: 7 % retiming and the like, paper section 5.4.
          double d = std::pow((number(c.flight_s[j]) - flight_s) / interval_s, 2) * 100.0 / ln2;
          d += std::pow(number(c.length_s[m]) - marks.durations_s[k], 2) * 7000.0 / ln2;
          if (k == 2) d += std::pow(number(c.centroid_s[m]) - marks.centroids_s[k], 2) * 7000.0 / ln2;
          d += offs(0).squaredNorm() / std::pow(std::min(flight_s, 0.2), 2) * 0.85 / ln2;
          const double a = 0.4 * number(kChange_m_s), b = a * std::tan(20.0 * std::numbers::pi / 180.0);
          d += offs(3).cwiseQuotient(Vec3(b, b, a)).squaredNorm() / ln2;
          const double e = 0.2 * number(kChange_rad_s), f = e * std::tan(10.0 * std::numbers::pi / 180.0);
          d += offs(6).cwiseQuotient(Vec3(e, f, f)).squaredNorm() / ln2;
          all.push_back(d);
        }
        std::ranges::sort(all);
        const auto found = trees.nearest(i, targets, k, 7);
        ASSERT_EQ(found.size(), 7u);
        // Scales and scaled coordinates are float32.
        for (std::size_t n = 0; n < 7; ++n) EXPECT_NEAR(found[n].distance, all[n], 1e-5 * (1.0 + all[n]));
      }
    }
  }
}

TEST(NodeTrees, NothingFliesToAMarkThatIsOver) {
  NodeColumns c = random_nodes(10);
  c.delay_s[0] = 0.2f;
  const Body body = sample::box({0.016, 0.016, 0.016}, 0.005);
  const NodeTrees trees(view_of(c), body);
  Marks marks;
  marks.times_s = {0.0, 0.1};
  marks.durations_s = {0.0, 0.0};
  marks.centroids_s = {std::nan(""), std::nan("")};
  EXPECT_TRUE(trees.nearest(0, Targets(marks), 1, 5).empty());
  const NodeColumns nothing;
  EXPECT_NO_THROW(NodeTrees(view_of(nothing), body));
}

}  // namespace
}  // namespace ifa
