#include "ifa/forward/repairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

// Marks with spans, unequal gaps and, now and then, amplitudes.
Marks random_marks(RandomStream& random, std::size_t n) {
  Marks marks;
  double time_s = random.uniform(0.0, 0.3);
  for (std::size_t k = 0; k < n; ++k) {
    const double gap_s = 0.012 * std::pow(30.0, random.uniform());
    marks.times_s.push_back(time_s);
    marks.durations_s.push_back(random.uniform() < 0.3 ? 0.9 * gap_s : 0.0);
    marks.centroids_s.push_back(std::numeric_limits<double>::quiet_NaN());
    time_s += gap_s;
  }
  if (random.uniform() < 0.5)
    for (std::size_t k = 0; k < n; ++k)
      marks.amplitudes.push_back(k > 0 && random.uniform() < 0.3 ? 0.0 : 1.0 + random.uniform());
  marks.ending = random.uniform() < 0.5 ? Ending::rest : Ending::open;
  return marks;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum;
}

// Whatever is proposed can be handed to a solve, changes one thing, by what it says, and costs more the
// larger it is.
TEST(Repairs, EveryProposalIsAValidRequestWithOneChange) {
  const double merge_gaps_s[] = {0.0, 0.010, 0.012};
  int lines_seen[6] = {};
  for (std::uint64_t sample = 0; sample < 200; ++sample) {
    RandomStream random(7, sample);
    const std::size_t n = 1 + static_cast<std::size_t>(random.uniform(0.0, 6.0));
    const double merge_gap_s = merge_gaps_s[sample % 3];
    Material material;
    material.restitution = random.uniform();
    material.friction = 2.0 * random.uniform();
    const Request request{sample::box({0.02, 0.02, 0.02}, 0.01, material), random_marks(random, n),
                          sample % 2 ? 1e-3 : 0.0, sample % 5 == 0};
    const auto mark = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(n)));
    const auto kind = static_cast<ConflictKind>(sample % 6);
    const auto lines =
        lines_for(request, {{mark, kind, "", ""}}, estimate(request.body, request.marks), merge_gap_s);
    for (const Line& line : lines) {
      ++lines_seen[static_cast<int>(line.kind)];
      if (request.fit_material) {  // it looks for these itself
        EXPECT_TRUE(line.kind != RepairKind::restitution && line.kind != RepairKind::friction);
      }
      ASSERT_FALSE(line.sizes.empty());
      EXPECT_TRUE(std::is_sorted(line.sizes.begin(), line.sizes.end()));
      double last = 0.0;
      for (const int size : line.sizes) {
        ASSERT_GT(size, 0);
        const Request to = changed(request, line, size);
        ASSERT_NO_THROW(validate(to.marks, std::max(merge_gap_s, kMergeGap_s)));
        EXPECT_GT(cost(request, line, size), last);
        last = cost(request, line, size);
        const double by = amount(request, line, size);
        const Material& is = to.body.material();
        const bool same_marks = to.marks.size() == n;
        EXPECT_EQ(same_marks, line.kind != RepairKind::drop);
        constexpr double kRounding = 1e-12;
        EXPECT_NEAR(same_marks ? difference(to.marks.times_s, request.marks.times_s) : 0.0,
                    line.kind == RepairKind::shift ? std::abs(by) : 0.0, kRounding);
        EXPECT_NEAR(to.energy_gain_j - request.energy_gain_j, line.kind == RepairKind::energy ? by : 0.0,
                    kRounding);
        EXPECT_NEAR(is.restitution - material.restitution, line.kind == RepairKind::restitution ? by : 0.0,
                    kRounding);
        EXPECT_NEAR(is.friction - material.friction, line.kind == RepairKind::friction ? by : 0.0, kRounding);
        EXPECT_EQ(to.marks.ending != request.marks.ending, line.kind == RepairKind::ending);
        EXPECT_FALSE(text_of(request, line, size).empty());
      }
    }
  }
  for (const int seen : lines_seen) EXPECT_GT(seen, 20);
}

Marks two_marks() {
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  return {{0.25, 0.5}, {0.0, 0.0}, {}, {unknown, unknown}, Ending::rest};
}

TEST(Repairs, SayWhatTheyDo) {
  const Request request{sample::ball(0.02, 0.01), two_marks(), 0.0, false};
  EXPECT_EQ(text_of(request, {RepairKind::shift, 1, 1, 0, 0, {}}, 18),
            "move mark 2 by 18 ms: 0.50 s -> 0.518 s");
  EXPECT_EQ(text_of(request, {RepairKind::shift, 0, -1, 0, 0, {}}, 50),
            "move mark 1 by -50 ms: 0.25 s -> 0.20 s");
  EXPECT_EQ(text_of(request, {RepairKind::drop, 1, 1, 0, 0, {}}, 1), "drop mark 2 (0.50 s)");
  EXPECT_EQ(text_of(request, {RepairKind::restitution, 0, 1, 0, 0, {}}, 12),
            "restitution 0.62 instead of 0.5");
  EXPECT_EQ(text_of(request, {RepairKind::friction, 0, -1, 0, 0, {}}, 25), "friction 0.05 instead of 0.3");
  EXPECT_EQ(text_of(request, {RepairKind::energy, 1, 1, 2e-3, 1.0, {}}, 1), "allow each contact to add 2 mJ");
  EXPECT_EQ(text_of(request, {RepairKind::ending, 1, 1, 0, 0, {}}, 1),
            "let it end open: ask for nothing after mark 2 (0.50 s)");
}

}  // namespace
}  // namespace ifa
