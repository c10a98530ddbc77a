#include "ifa/forward/select.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

using Soundness = std::pair<int, int>;

Soundness soundness(const Candidate& c) { return {c.violations, c.stretched}; }

// Candidates that can be told apart by `from.interval_s`.
class Select : public ::testing::Test {
 protected:
  Candidate candidate(double rank, int parent, int start, double speed_m_s = 1.0, int body = 0) {
    Candidate c;
    c.log_weight = rank;
    c.parent = parent;
    c.start = start;
    c.body = body;
    c.onset.after.velocity.z() = speed_m_s;
    c.from.interval_s = static_cast<double>(++made_);
    return c;
  }

  std::vector<Candidate> random_candidates(RandomStream& random, int n, int parents, int starts, int bodies) {
    std::vector<Candidate> all;
    for (int i = 0; i < n; ++i) {
      const int parent = static_cast<int>(random.uniform(0.0, parents));
      all.push_back(candidate(random.uniform(-20.0, 0.0), parent, parent % starts,
                              std::pow(10.0, random.uniform(-1.0, 0.5)),
                              static_cast<int>(random.uniform(0.0, bodies))));
      all.back().outlook = random.uniform(-5.0, 0.0);
      all.back().violations = static_cast<int>(random.uniform(0.0, 3.0));
      all.back().stretched = static_cast<int>(random.uniform(0.0, 2.0));
    }
    return all;
  }

  Level chosen(std::vector<Candidate> all, std::size_t room, std::size_t batches = 4, bool even = false) {
    return select(std::move(all), problem_, room, batches, even);
  }

  static std::vector<Candidate> batch(const Level& level, std::size_t i) {
    const auto from = static_cast<std::ptrdiff_t>(i == 0 ? 0 : level.batch_ends[i - 1]);
    return {level.candidates.begin() + from,
            level.candidates.begin() + static_cast<std::ptrdiff_t>(level.batch_ends[i])};
  }

  static std::vector<double> names(const std::vector<Candidate>& all) {
    std::vector<double> names;
    for (const Candidate& c : all) names.push_back(c.from.interval_s);
    return names;
  }

  int made_ = 0;
  Marks marks_;
  SearchPhysics physics_;
  std::vector<Body> bodies_{3, sample::ball(0.02, 0.03)};
  Problem problem_{bodies_, physics_, marks_};
};

TEST_F(Select, BatchesAreFullDisjointAndComplete) {
  for (std::uint64_t i = 0; i < 60; ++i) {
    RandomStream random(31, i);
    const int n = 1 + static_cast<int>(random.uniform(0.0, 300.0));
    const auto all = random_candidates(random, n, 1 + n / 5, 1 + n / 20, 3);
    const std::size_t room = 10 + i, count = static_cast<std::size_t>(n);
    for (const bool even : {false, true}) {
      const Level level = chosen(all, room, 4, even);
      EXPECT_EQ(level.candidates.size(), std::min(count, 4 * room));
      const auto kept = names(level.candidates);
      EXPECT_EQ(std::set(kept.begin(), kept.end()).size(), kept.size());
      ASSERT_EQ(level.batch_ends.size(), std::min<std::size_t>(4, (count + room - 1) / room));
      for (std::size_t b = 0; b < level.batch_ends.size(); ++b) {
        EXPECT_EQ(level.batch_ends[b], std::min(count, (b + 1) * room));
        const auto own = batch(level, b);
        EXPECT_TRUE(std::ranges::is_sorted(own, {}, &Candidate::body));  // side by side
      }
      EXPECT_EQ(names(chosen(all, room, 4, even).candidates), kept);  // again
    }
  }
  EXPECT_TRUE(chosen({}, 10).candidates.empty());
  EXPECT_TRUE(chosen({}, 10).batch_ends.empty());
}

// With families small enough to be no reason, none that is kept is less sound than one that is not, whatever
// the ranks say.
TEST_F(Select, SoundOnesComeFirst) {
  for (std::uint64_t i = 0; i < 40; ++i) {
    RandomStream random(32, i);
    auto all = random_candidates(random, 150, 150, 150, 3);
    for (std::size_t c = 0; c < all.size(); ++c) all[c].parent = all[c].start = static_cast<int>(c);
    const Level level = chosen(all, 30, 4, i % 2 == 0);
    Soundness worst{0, 0};
    for (std::size_t b = 0; b < 4; ++b) {
      const auto own = batch(level, b);
      const auto [best_own, worst_own] = std::ranges::minmax(own, {}, soundness);
      EXPECT_GE(soundness(best_own), worst);
      worst = soundness(worst_own);
    }
  }
}

// The rule of family sizes, from what was chosen alone: whoever was left out while a parent has more than its
// four, or a start more than its tenth, belongs to a full family itself.
TEST_F(Select, FewChildrenOfOneParentWhileThereAreOthers) {
  int crowded = 0, spread = 0;
  for (std::uint64_t i = 0; i < 60; ++i) {
    RandomStream random(33, i);
    const auto all = random_candidates(random, 200, 3 + static_cast<int>(i), 2 + static_cast<int>(i) / 3, 1);
    constexpr std::size_t kRoom = 40;
    const auto kept = batch(chosen(all, kRoom), 0);
    std::map<int, std::size_t> children, descendants;
    std::set<double> taken;
    for (const Candidate& c : kept) {
      ++children[c.parent];
      ++descendants[c.start];
      taken.insert(c.from.interval_s);
    }
    const auto most = [](const std::map<int, std::size_t>& families) {
      return std::ranges::max_element(families, {}, [](const auto& f) { return f.second; })->second;
    };
    if (most(children) <= kMostChildren && most(descendants) <= kRoom / 10 + 1) {
      ++spread;
      continue;
    }
    ++crowded;
    for (const Candidate& c : all)
      if (!taken.contains(c.from.interval_s)) {
        EXPECT_TRUE(children[c.parent] >= kMostChildren || descendants[c.start] >= kRoom / 10 + 1) << i;
      }
  }
  EXPECT_GT(crowded, 5);
  EXPECT_GT(spread, 5);
}

// Half by rank; the other half keeps the lively and the tired that the ranks alone would drop.
TEST_F(Select, HalfByRankHalfByEnergy) {
  std::vector<Candidate> all;
  for (int i = 0; i < 100; ++i) all.push_back(candidate(-0.01 * i, i, i));
  for (int i = 0; i < 3; ++i) all.push_back(candidate(-50.0 - i, 100 + i, 100 + i, 0.01));
  for (int i = 0; i < 3; ++i) all.push_back(candidate(-60.0 - i, 200 + i, 200 + i, 3.0));
  const auto kept = names(batch(chosen(all, 20), 0));
  for (int i = 1; i <= 10; ++i) EXPECT_TRUE(std::ranges::count(kept, i)) << i;
  // Bands take turns, so both rare ones are all kept: 3 + 3 of 10.
  for (int i = 101; i <= 106; ++i) EXPECT_TRUE(std::ranges::count(kept, i)) << i;
  EXPECT_EQ(kept.size(), 20u);
}

TEST_F(Select, EvenGivesEachBodyItsShare) {
  std::vector<Candidate> all;
  for (int body = 0; body < 3; ++body)
    for (int i = 0; i < 60; ++i) all.push_back(candidate(-30.0 * body - 0.1 * i, made_, made_, 1.0, body));
  const auto of_body = [](const std::vector<Candidate>& kept, int body) {
    return std::ranges::count(kept, body, &Candidate::body);
  };
  constexpr std::size_t kRoom = 30;
  const auto fair = batch(chosen(all, kRoom, 4, true), 0), plain = batch(chosen(all, kRoom, 4, false), 0);
  // Half of the room goes round in turn: a third of it for each.
  for (int body = 0; body < 3; ++body) EXPECT_GE(of_body(fair, body), 5);
  EXPECT_EQ(of_body(plain, 0), 30);  // of the same energy, only ranks decide
}

TEST_F(Select, ForgettingKeepsWhatHadItsTurn) {
  RandomStream random(34, 0);
  auto all = random_candidates(random, 100, 50, 20, 1);
  for (Candidate& c : all) c.unchanged = std::make_shared<const Passage>();
  Level level = chosen(all, 20);
  const auto before = names(level.candidates);
  level.forget(40);
  EXPECT_EQ(level.batch_ends, (std::vector<std::size_t>{20, 40}));
  EXPECT_EQ(names(level.candidates), std::vector<double>(before.begin(), before.begin() + 40));
  for (const Candidate& c : level.candidates) EXPECT_FALSE(c.unchanged);
}

}  // namespace
}  // namespace ifa
