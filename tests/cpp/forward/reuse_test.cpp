#include <gtest/gtest.h>

#include <string>

#include "ifa/base/error.hpp"
#include "ifa/forward/kept.hpp"
#include "solutions.hpp"

namespace ifa {
namespace {

using sample::cube;
using sample::expect_honest;
using sample::expect_same_bytes;
using sample::first_rung;
using sample::marks_at;
using sample::of_a_throw;

SolveOptions reusing(const Solution& before, std::uint64_t seed = 0, int threads = 2) {
  SolveOptions options = first_rung(seed, threads);
  options.reuse = before.kept;
  return options;
}

Body roller() { return sample::box({0.03, 0.02, 0.012}, 0.01); }

Marks nudged(Marks marks, std::size_t k, double by_s) {
  marks.times_s[k] += by_s;
  return marks;
}

TEST(Reuse, ANudgedMarkIsMetWithLessWork) {
  const Body body = roller();
  int moves = 0, plausible = 0, less = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Marks marks = of_a_throw(body, seed, 8);
    const Solution first = solve_forward(body, marks, first_rung(), nullptr);
    if (!first.plausible) continue;
    for (std::size_t k = 1; k < marks.size(); ++k) {
      const Marks moved = nudged(marks, k, 0.002);
      if (k + 1 < marks.size() && moved.times_s[k + 1] - moved.times_s[k] < kMergeGap_s) continue;
      const Solution again = solve_forward(body, moved, reusing(first), nullptr);
      expect_honest(body, moved, again);
      for (const int threads : {1, 3})
        expect_same_bytes(again, solve_forward(body, moved, reusing(first, 0, threads), nullptr));
      ++moves;
      plausible += again.plausible;
      less += again.simulated_s < first.simulated_s;
    }
  }
  ASSERT_GE(moves, 8);
  EXPECT_GE(4 * plausible, 3 * moves);  // the smallest beam may miss some
  EXPECT_GE(2 * less, moves);           // but for the second mark, and where the ladder is climbed anew
}

TEST(Reuse, OfTheSameMarksIsPlausibleAgain) {
  const Body body = roller();
  int plausible = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Marks marks = of_a_throw(body, seed, 8);
    const Solution first = solve_forward(body, marks, first_rung(), nullptr);
    if (!first.plausible) continue;
    ++plausible;
    const Solution again = solve_forward(body, marks, reusing(first), nullptr);
    expect_honest(body, marks, again);
    EXPECT_TRUE(again.plausible);
    EXPECT_LT(again.simulated_s, 0.2 * first.simulated_s);  // only the last level is looked at again
  }
  EXPECT_GE(plausible, 2);
}

// Marks may be added, dropped and changed in all else; and one solve after another goes on from the last.
TEST(Reuse, GoesOnThroughAnEditingSession) {
  const Body body = roller();
  int edits = 0, succeeded = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Marks marks = of_a_throw(body, seed, 8);
    Solution last = solve_forward(body, marks, first_rung(), nullptr);
    const auto edit = [&](const Marks& to) {
      Solution next = solve_forward(body, to, reusing(last), nullptr);
      expect_honest(body, to, next);
      ++edits;
      succeeded += next.succeeded;
      last = std::move(next);
    };
    Marks shorter = marks;
    for (auto* values : {&shorter.times_s, &shorter.durations_s, &shorter.amplitudes, &shorter.centroids_s})
      values->pop_back();
    shorter.ending = Ending::open;
    edit(shorter);
    Marks longer = marks;
    longer.ending = Ending::open;
    edit(longer);
    edit(nudged(longer, longer.size() - 1, 0.002));
    Marks louder = longer;
    louder.amplitudes.back() *= 1.1;
    edit(louder);
    edit(marks);
  }
  EXPECT_GE(3 * succeeded, 2 * edits);  // the smallest beam may miss some
}

// A search that came to its end too early leaves what it reached to the one that is asked less.
TEST(Reuse, GoesOnFromASearchThatFailed) {
  const Body ball = sample::ball(0.02, 0.03, {0.4, 0.3, 1e-3, 1e-3});
  const Marks beyond_reach = marks_at({0.2, 0.3, 0.8}, Ending::open);
  const Solution failed = solve_forward(ball, beyond_reach, first_rung(), nullptr);
  ASSERT_EQ(failed.missed_hits, 1);
  const Marks within = marks_at({0.2, 0.3, 0.345}, Ending::open);
  const Solution s = solve_forward(ball, within, reusing(failed), nullptr);
  expect_honest(ball, within, s);
  EXPECT_TRUE(s.plausible);
  EXPECT_LT(s.simulated_s, failed.simulated_s);
}

TEST(Reuse, AfterChangingTheFirstMarkIsAFreshSolve) {
  const Body body = cube();
  const Marks marks = of_a_throw(body, 1, 5);
  const Solution first = solve_forward(body, marks, first_rung(), nullptr);
  Marks louder = marks;
  louder.amplitudes[0] *= 1.5;
  Marks silent = marks;
  silent.amplitudes.clear();
  for (const Marks& changed : {nudged(marks, 0, -0.01), louder, silent})
    expect_same_bytes(solve_forward(body, changed, reusing(first), nullptr),
                      solve_forward(body, changed, first_rung(), nullptr));
}

// Fitted materials are the earlier solve's, and the motion says which it has.
TEST(Reuse, KeepsTheMaterialsOfAFit) {
  const Body ball = sample::ball(0.02, 0.03, {0.2, 0.3, 1e-4, 1e-4});
  const Marks marks = marks_at({0.1, 0.35, 0.5, 0.59}, Ending::open);  // gaps shrink by 0.6
  SolveOptions options = first_rung();
  options.fit_material = true;
  const Solution first = solve_forward(ball, marks, options, nullptr);
  options.reuse = first.kept;
  const Marks moved = nudged(marks, 3, 0.003);
  const Solution again = solve_forward(ball, moved, options, nullptr);
  expect_honest(ball, moved, again);
  EXPECT_TRUE(again.plausible);
  EXPECT_EQ(again.restitution, again.motion->body().material().restitution);
}

TEST(Reuse, OfAnythingElseIsAnArgumentError) {
  const Body body = cube();
  const Marks marks = marks_at({0.2, 0.32}, Ending::open);
  const Solution first = solve_forward(body, marks, first_rung(), nullptr);
  const auto message = [&](const Body& of, const SolveOptions& options) {
    try {
      solve_forward(of, marks, options, nullptr);
    } catch (const ArgumentError& e) {
      return std::string(e.what()).substr(0, 6);
    }
    return std::string("solved");
  };
  EXPECT_EQ(message(body, reusing(first)), "solved");
  EXPECT_EQ(message(body, reusing(first, 7)), "solved");  // another seed is another take on it
  EXPECT_EQ(message(sample::box({0.016, 0.016, 0.0161}, 0.005), reusing(first)), "reuse:");
  SolveOptions contact = reusing(first), gain = reusing(first), fit = reusing(first);
  contact.events = Events::contact;
  gain.energy_gain_j = 1e-3;
  fit.fit_material = true;
  for (const SolveOptions& options : {contact, gain, fit}) EXPECT_EQ(message(body, options), "reuse:");
}

// Each number of a body counts; its name does not.
TEST(CheckReuse, ComparesTheWholeBody) {
  const Body body = [] {
    Body::Definition d = sample::coin().definition();
    d.vertices_m = {{0.0, 0.0, 0.01}, {0.0, 0.0, -0.01}};  // beyond the rings: they count too
    return Body::make(d);
  }();
  const KeptSearch kept{{body}, {}, {}, {}, 0, {}};
  const auto same = [&](void (*change)(Body::Definition&)) {
    Body::Definition d = body.definition();
    change(d);
    try {
      check_reuse(kept, Body::make(d), {}, {});
    } catch (const ArgumentError&) {
      return false;
    }
    return true;
  };
  using D = Body::Definition;
  EXPECT_TRUE(same([](D& d) { d.name = "another"; }));
  EXPECT_FALSE(same([](D& d) { d.mass_kg *= 1.001; }));
  EXPECT_FALSE(same([](D& d) { d.inertia_kg_m2 *= 1.001; }));
  EXPECT_FALSE(same([](D& d) { d.radius_m *= 1.001; }));
  EXPECT_FALSE(same([](D& d) { d.vertices_m[0].z() *= 1.001; }));
  EXPECT_FALSE(same([](D& d) { d.vertices_m.pop_back(); }));
  EXPECT_FALSE(same([](D& d) { d.rings_m[1].radius_m *= 1.001; }));
  EXPECT_FALSE(same([](D& d) { d.rings_m[1].centre_m.z() *= 1.001; }));
  EXPECT_FALSE(same([](D& d) { d.rings_m[1].axis.x() += 0.001; }));
  EXPECT_FALSE(same([](D& d) { d.rings_m.pop_back(); }));
  EXPECT_FALSE(same([](D& d) { d.material.restitution *= 1.001; }));
  EXPECT_FALSE(same([](D& d) { d.material.friction *= 1.001; }));
  EXPECT_FALSE(same([](D& d) { d.material.rolling_friction_m *= 1.001; }));
  EXPECT_FALSE(same([](D& d) { d.material.spin_friction_m *= 1.001; }));
}

TEST(MarksInCommon, AreThoseTheSameInEveryRespect) {
  const Marks a = [] {
    Marks m = marks_at({0.1, 0.2, 0.3, 0.4});
    m.durations_s[2] = 0.05;
    m.centroids_s[2] = 0.02;
    m.amplitudes = {1.0, 0.5, 0.4, 0.3};
    return m;
  }();
  EXPECT_EQ(marks_in_common(a, a), 4u);
  Marks b = a;
  b.ending = Ending::open;
  EXPECT_EQ(marks_in_common(a, b), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    for (auto member : {&Marks::times_s, &Marks::durations_s, &Marks::amplitudes, &Marks::centroids_s}) {
      b = a;
      (b.*member)[k] = 0.011;
      EXPECT_EQ(marks_in_common(a, b), k);
      EXPECT_EQ(marks_in_common(b, a), k);
    }
  }
  b = a;
  b.amplitudes.clear();
  EXPECT_EQ(marks_in_common(a, b), 0u);
}

}  // namespace
}  // namespace ifa
