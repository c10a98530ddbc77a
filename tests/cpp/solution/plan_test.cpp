// Which effects scenes call for, and why.
#include "ifa/solution/plan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ifa/base/error.hpp"
#include "sample_bodies.hpp"
#include "sample_marks.hpp"

namespace ifa {
namespace {

using sample::cube;
using sample::marks_at;

Body ball(const Material& material = {}) { return sample::ball(0.02, 0.03, material); }

// Six marks that ask for everything that marks can ask for.
Marks full() {
  Marks m = marks_at({0.2, 0.4, 0.6, 0.8, 0.9, 1.0}, Ending::rest);
  m.amplitudes.assign(6, 1.0);
  m.durations_s[5] = 0.2;
  m.centroids_s[5] = 0.1;
  m.constraints.positions = {{2, {0.1, 0.0}}};
  m.constraints.orientations = {{kAtRest, kUp, kUp}};
  return m;
}

struct Case {
  Effect effect;
  Body body;
  Marks marks;
  PlanOptions options;
  bool on;
  std::string because;
};

TEST(Plan, SaysWhichEffectsAreOnAndWhy) {
  const Marks six = marks_at({0.2, 0.4, 0.6, 0.8, 0.9, 1.0}, Ending::open);
  const Marks rest = marks_at({0.2, 0.4, 0.6, 0.8, 0.9, 1.0}, Ending::rest);
  const Marks one = marks_at({0.2}, Ending::open);
  Marks spanned = six, heard_one = one;
  spanned.durations_s[2] = 0.1;
  heard_one.amplitudes = {1.0};
  PlanOptions contact, fit, graph;
  contact.events = Events::contact;
  fit.fit_material = true;
  graph.graph = true;
  using enum Effect;
  const std::vector<Case> cases = {
      {spin_coupling, sample::box({0.01, 0.02, 0.03}, 0.01), six, {}, true, "the body's moments differ"},
      {spin_coupling, cube(), six, {}, false, "its moments are equal"},
      {spin_coupling, ball(), six, {}, false, "the body is a ball: its moments are equal"},
      {friction, ball(), six, {}, true, "the material has friction"},
      {friction, ball(sample::ideal(0.5, 0.0)), six, {}, false, "the material has no friction"},
      {rounding, ball(), six, {}, true, "the hull is rounded by 20 mm"},
      {rounding, cube(), six, {}, false, "the hull is not rounded"},
      {circular_edges, sample::coin(), six, {}, true, "the hull has circular edges"},
      {circular_edges, cube(), six, {}, false, "the hull has no circular edges"},
      {sustained_contact, cube(), six, {}, true, "the body may rock, slide or roll from mark to mark"},
      {sustained_contact, ball(), rest, {}, true, "the body comes to rest in it"},
      {sustained_contact, ball(), spanned, {}, true, "a mark has a duration"},
      {sustained_contact, ball(), six, contact, true, "contact makes the events"},
      {sustained_contact, ball(), six, graph, true, "the database was simulated with it"},
      {sustained_contact, cube(), one, {}, false, "nothing is asked after the only mark"},
      {sustained_contact,
       ball(),
       six,
       {},
       false,
       "the body is a ball: it never leaves the ground that it stays on, and the ending is open"},
      {pre_roll_flight, cube(), six, {}, true, "lead_in_s is 0.5"},
      {settling_to_rest, cube(), rest, {}, true, "the body shall come to rest after the last mark"},
      {settling_to_rest, cube(), six, {}, false, "the ending is open"},
      {amplitude_matching, cube(), full(), {}, true, "the marks have amplitudes"},
      {amplitude_matching, cube(), six, {}, false, "the marks have no amplitudes"},
      {amplitude_matching, cube(), heard_one, {}, false, "a single mark has no other to be louder than"},
      {length_matching, cube(), full(), {}, true, "1 of 6 marks have a duration"},
      {length_matching, cube(), six, {}, false, "no mark has a duration"},
      {centroid_matching, cube(), full(), {}, true, "1 of 6 marks have a centroid"},
      {centroid_matching, cube(), spanned, {}, false, "no mark has a centroid"},
      {orientation_constraints, cube(), full(), {}, true, "an orientation is asked for"},
      {orientation_constraints, cube(), six, {}, false, "no orientation is asked for"},
      {position_constraints, cube(), full(), {}, true, "a position is asked for"},
      {position_constraints, cube(), six, {}, false, "no position is asked for"},
      {retiming, cube(), six, {}, true, "every interval is brought to its marks"},
      {retiming, cube(), one, {}, false, "a single mark has no interval"},
      {material_fit, cube(), six, fit, true, "the material is to be fitted"},
      {material_fit, cube(), six, {}, false, "the material is given"},
  };
  for (const Case& c : cases) {
    const Plan plan = make_plan(c.body, c.marks, c.options);
    const PlannedEffect& planned = plan[c.effect];
    const std::string name(kEffectNames[index_of(c.effect)]);
    EXPECT_EQ(planned.on, c.on) << name << ": " << c.because;
    EXPECT_EQ(planned.because, c.because) << name;
    EXPECT_FALSE(planned.forced) << name;
  }
}

TEST(Plan, EachEffectCanBeForced) {
  const Body body = sample::coin();
  const Marks marks = full();
  for (std::size_t e = 0; e < kEffects; ++e)
    for (const bool on : {false, true}) {
      PlanOptions options;
      const auto effect = static_cast<Effect>(e);
      options.forced[e] = on;
      if (effect == Effect::sustained_contact) options.forced[index_of(Effect::settling_to_rest)] = false;
      const Plan plan = make_plan(body, marks, options);
      EXPECT_EQ(plan.on(effect), on) << kEffectNames[e];
      EXPECT_TRUE(plan[effect].forced);
      EXPECT_TRUE(plan.same_forced(plan));
      EXPECT_FALSE(plan.same_forced(make_plan(body, marks, {})));
    }
}

// What the search is given of the marks.
TEST(Plan, LeavesOutWhatIsOff) {
  const Body body = cube();
  const auto seen_without = [&](Effect effect) {
    PlanOptions options;
    options.forced[index_of(effect)] = false;
    return make_plan(body, full(), options).seen(full());
  };
  EXPECT_TRUE(seen_without(Effect::amplitude_matching).amplitudes.empty());
  EXPECT_TRUE(std::isnan(seen_without(Effect::centroid_matching).centroids_s[5]));
  EXPECT_EQ(seen_without(Effect::length_matching).durations_s[5], 0.2);  // the span excuses hits all the same
  EXPECT_TRUE(seen_without(Effect::position_constraints).constraints.positions.empty());
  EXPECT_TRUE(seen_without(Effect::orientation_constraints).constraints.orientations.empty());
  const Marks open = seen_without(Effect::settling_to_rest);
  EXPECT_EQ(open.ending, Ending::open);
  EXPECT_TRUE(open.constraints.orientations.empty());  // it was asked of rest
  validate(open);
}

TEST(Plan, NamesWhatCannotBeForced) {
  struct Refused {
    Effect effect;
    bool on;
    Body body;
    bool graph;
  };
  using enum Effect;
  const std::vector<Refused> cases = {{rounding, false, ball(), false},
                                      {sustained_contact, false, cube(), false},
                                      {material_fit, true, cube(), true},
                                      {retiming, false, cube(), true},
                                      {sustained_contact, false, cube(), true},
                                      {friction, false, cube(), true},
                                      {spin_coupling, true, cube(), true},
                                      {rounding, false, sample::rod(0.1, 0.005, 0.01), false},
                                      {circular_edges, false, sample::coin(), true}};
  for (const Refused& c : cases) {
    PlanOptions options;
    options.graph = c.graph;
    options.forced[index_of(c.effect)] = c.on;
    const std::string name(kEffectNames[index_of(c.effect)]);
    try {
      make_plan(c.body, full(), options);
      ADD_FAILURE() << name << " was not refused";
    } catch (const ArgumentError& e) {
      EXPECT_EQ(std::string(e.what()).rfind(name + ": ", 0), 0u) << e.what();
    }
  }
  EXPECT_THROW(effect_named("gravity"), ArgumentError);
  for (std::size_t e = 0; e < kEffects; ++e) EXPECT_EQ(index_of(effect_named(kEffectNames[e])), e);
}

}  // namespace
}  // namespace ifa
