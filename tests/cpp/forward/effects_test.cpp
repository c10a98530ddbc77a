// Effects that are off do not run, those that are on do, and what is on but not called for changes no byte.
#include "ifa/solution/plan.hpp"

#include <gtest/gtest.h>

#include "ifa/base/error.hpp"
#include "solutions.hpp"

namespace ifa {
namespace {

using sample::expect_same_bytes;
using sample::marks_at;

Body ball() { return sample::ball(0.02, 0.03, {0.7, 0.3, 5e-5, 5e-5}); }

// Bounces of a ball with restitution 0.7, to 1 %: as a listener would mark them.
Marks bounces(Ending ending = Ending::open) {
  return marks_at({0.3, 0.7, 0.98, 1.176, 1.315, 1.411}, ending);
}

Solution solve(const Body& body, const Marks& marks, std::initializer_list<std::pair<Effect, bool>> forced,
               int threads = 2) {
  SolveOptions options = sample::first_rung(0, threads);
  for (const auto& [effect, on] : forced) options.forced[index_of(effect)] = on;
  return solve_forward(body, marks, options, nullptr);
}

void expect_counted(const Solution& s) {
  for (std::size_t e = 0; e < kEffects; ++e)
    EXPECT_TRUE(s.plan.on(static_cast<Effect>(e)) || s.effect_runs.runs[e] == 0) << kEffectNames[e];
}

std::uint64_t runs(const Solution& s, Effect e) { return s.effect_runs.runs[index_of(e)]; }

// Two marks that call for all effects of marks, and what is left of these where each is forced off.
TEST(SolveEffects, OffMeansThatNothingOfItRuns) {
  Marks marks = marks_at({0.3, 0.5});
  marks.amplitudes = {1.0, 0.8};
  marks.durations_s[1] = 0.1;
  marks.centroids_s[1] = 0.03;
  marks.constraints.positions = {{0, {0.0, 0.0}}, {1, {0.05, 0.0}}};
  marks.constraints.orientations = {{kAtRest, kUp, kUp}};
  const Marks plain = marks_at({0.3, 0.5}, Ending::open);
  Body::Definition rounded = sample::box({0.02, 0.014, 0.01}, 0.005).definition();
  rounded.radius_m = 0.001;
  const Body box = Body::make(rounded);
  for (std::size_t e = 0; e < kEffects; ++e) {
    const auto effect = static_cast<Effect>(e);
    const bool of_the_hull = effect == Effect::circular_edges;
    const bool of_contact = effect == Effect::sustained_contact;
    const Body& body = of_the_hull ? sample::coin() : box;
    const Marks& asked = of_the_hull || of_contact ? plain : marks;
    const bool needed = make_plan(body, asked, {}).on(effect);
    const Solution with = needed ? solve(body, asked, {}) : solve(body, asked, {{effect, true}});
    EXPECT_EQ(needed, effect != Effect::material_fit) << kEffectNames[e];
    EXPECT_GT(runs(with, effect), 0u) << kEffectNames[e];
    const Solution without = solve(body, asked, {{effect, false}});
    EXPECT_EQ(runs(without, effect), 0u) << kEffectNames[e];
    EXPECT_TRUE(without.plan[effect].forced);
    for (const Solution& s : {with, without}) expect_counted(s);
  }
}

TEST(SolveEffects, ABallWithSixMarksNeedsFew) {
  const Solution s = solve(ball(), bounces(), {});
  EXPECT_TRUE(s.plausible);
  sample::expect_honest(ball(), bounces(), s);
  expect_counted(s);
  for (const Effect e :
       {Effect::spin_coupling, Effect::sustained_contact, Effect::circular_edges, Effect::settling_to_rest,
        Effect::amplitude_matching, Effect::length_matching, Effect::centroid_matching,
        Effect::orientation_constraints, Effect::position_constraints, Effect::material_fit})
    EXPECT_FALSE(s.plan.on(e)) << kEffectNames[index_of(e)];
  for (const Effect e : {Effect::friction, Effect::rounding, Effect::pre_roll_flight, Effect::retiming})
    EXPECT_GT(runs(s, e), 0u) << kEffectNames[index_of(e)];
}

// Effects that find nothing to do leave every byte as it is.
TEST(SolveEffects, OnWithoutNeedIsTheSameMotion) {
  for (const Body& body : {ball(), sample::cube()}) {
    const Marks marks = bounces();
    const Solution plain = solve(body, marks, {});
    for (const Effect e :
         {Effect::amplitude_matching, Effect::length_matching, Effect::centroid_matching,
          Effect::orientation_constraints, Effect::position_constraints, Effect::circular_edges}) {
      const Solution forced = solve(body, marks, {{e, true}});
      EXPECT_TRUE(forced.plan.on(e));
      expect_same_bytes(plain, forced);
    }
    EXPECT_GT(runs(solve(body, marks, {{Effect::amplitude_matching, true}}), Effect::amplitude_matching), 0u);
  }
}

TEST(SolveEffects, CountsDoNotDependOnThreads) {
  const Marks marks = bounces(Ending::rest);
  const Solution one = solve(ball(), marks, {}, 1);
  for (const int threads : {2, 5}) {
    const Solution many = solve(ball(), marks, {}, threads);
    expect_same_bytes(one, many);
    for (std::size_t e = 0; e < kEffects; ++e)
      EXPECT_EQ(one.effect_runs.runs[e], many.effect_runs.runs[e]) << kEffectNames[e];
  }
}

// The motion starts with the first contact: no time before its mark.
TEST(SolveEffects, WithoutPreRollItBeginsAtTheFirstMark) {
  const Solution s = solve(ball(), bounces(), {{Effect::pre_roll_flight, false}});
  EXPECT_EQ(s.motion->start_s(), bounces().times_s.front());
  EXPECT_EQ(s.motion->hits().front().time_s, s.motion->start_s());
  EXPECT_TRUE(s.plausible);
}

// Simulated time is the motion's, and every mark is met all the same.
TEST(SolveEffects, WithoutRetimingTheMotionIsAsSimulated) {
  const Marks marks = bounces();
  const Solution s = solve(ball(), marks, {{Effect::retiming, false}});
  EXPECT_EQ(s.motion->time().simulated_s, s.motion->time().motion_s);
  ASSERT_TRUE(s.succeeded);
  for (const EventReport& e : s.events) {
    EXPECT_EQ(e.retime, 1.0);
    EXPECT_LE(std::abs(e.error_retimed_s), 1e-3);
  }
  const std::vector<double> onsets = sample::onsets_of(*s.motion, Events::audible);
  ASSERT_EQ(onsets.size(), marks.size());
  for (std::size_t k = 0; k < marks.size(); ++k) EXPECT_NEAR(onsets[k], marks.times_s[k], 1e-3);
}

TEST(SolveEffects, SettlingIsForcedOnAndOff) {
  const Marks open = bounces(), rest = bounces(Ending::rest);
  const Body soft = sample::ball(0.02, 0.03, {0.7, 0.3, 2e-3, 2e-3});  // it does not roll for long
  const Solution shown = solve(soft, open, {{Effect::settling_to_rest, true}});
  EXPECT_TRUE(shown.succeeded);  // what comes after the last mark is not extra
  EXPECT_GT(runs(shown, Effect::settling_to_rest), 0u);
  const double end_s = shown.motion->end_s();
  EXPECT_LT(
      (shown.motion->sample({end_s})[0].position - shown.motion->sample({end_s - 0.05})[0].position).norm(),
      0.05 * 0.01);  // slower than 0.01 m/s: at rest
  const Solution as_open = solve(ball(), rest, {{Effect::settling_to_rest, false}});
  expect_same_bytes(as_open, solve(ball(), open, {}));
}

// Without sustained contact a body flies from mark to mark.
TEST(SolveEffects, WithoutContactThereIsOnlyFlight) {
  const Body body = sample::cube();
  const Solution s = solve(body, bounces(), {{Effect::sustained_contact, false}});
  expect_counted(s);
  for (const Node& node : s.motion->nodes()) EXPECT_EQ(node.phase, Phase::flight);
}

// After the last mark only the event itself is watched: of a discrete one, 10.5 ms. Today's whole tail would
// be up to half a second for each passage.
TEST(SolveEffects, ASingleMarkTakesAStart) {
  for (const Body& body : {ball(), sample::cube(), sample::box({0.04, 0.02, 0.01}, 0.01)})
    for (const Ending ending : {Ending::open, Ending::rest}) {
      const Marks marks = marks_at({0.4}, ending);
      const Solution s = solve(body, marks, {});
      EXPECT_TRUE(s.plausible);
      sample::expect_honest(body, marks, s);
      expect_counted(s);
      EXPECT_TRUE(ending == Ending::rest || s.simulated_s < 8 * 0.02);  // one group, no search
      expect_same_bytes(s, solve(body, marks, {}, 1));
      // The whole search, which more takes ask for, tries all starts.
      SolveOptions options = sample::first_rung();
      options.takes = 2;
      const Solution searched = solve_forward(body, marks, options, nullptr);
      EXPECT_LE(s.simulated_s, searched.simulated_s * (1.0 + 1e-12));  // summed in another order
      if (ending == Ending::open) {
        EXPECT_LT(s.simulated_s, 0.1 * searched.simulated_s);
      }
    }
}

// Where nothing must come after the last mark, only its event is watched: each of 480 starts for 10.5 ms,
// longer where hits chain on. (To the next hit it takes ten times as long.)
TEST(SolveEffects, NothingBeyondTheLastMarkIsSearched) {
  const Marks marks = marks_at({0.3}, Ending::open);
  SolveOptions options = sample::first_rung();
  options.takes = 2;  // so that all starts are tried
  const Solution open = solve_forward(sample::cube(), marks, options, nullptr);
  EXPECT_TRUE(open.plausible);
  EXPECT_LT(open.simulated_s, 480 * 0.02);
  EXPECT_GT(open.simulated_s, 100 * 0.0105);
  options.forced[index_of(Effect::settling_to_rest)] = true;
  EXPECT_GT(solve_forward(sample::cube(), marks, options, nullptr).simulated_s, 5.0 * open.simulated_s);
}

TEST(SolveEffects, ReuseKnowsWhatWasForced) {
  const Solution first = solve(ball(), bounces(), {{Effect::friction, false}});
  SolveOptions options = sample::first_rung();
  options.reuse = first.kept;
  EXPECT_THROW(solve_forward(ball(), bounces(), options, nullptr), ArgumentError);
  options.forced[index_of(Effect::friction)] = false;
  EXPECT_TRUE(solve_forward(ball(), bounces(), options, nullptr).plausible);
}

}  // namespace
}  // namespace ifa
