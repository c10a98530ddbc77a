// Effects of the engine that are off, forced on, or as a body needs them.
#include "ifa/rigid/effects.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "ifa/base/effects.hpp"
#include "ifa/base/error.hpp"
#include "ifa/rigid/batch.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using Counts = std::array<std::uint64_t, 5>;  // of the engine's effects

// How often the code of each ran in `work`, on this thread.
template <class Work>
Counts counted(const Work& work) {
  const EffectCounts before = effect_counts;
  work();
  Counts counts;
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = effect_counts.runs[i] - before.runs[i];
  return counts;
}

std::uint64_t of(const Counts& counts, Effect effect) { return counts[static_cast<std::size_t>(effect)]; }

std::vector<State> throws(const Body& body, int n, double spin_rad_s = 30.0) {
  std::vector<State> states;
  for (int i = 0; i < n; ++i) {
    RandomStream random(17, static_cast<std::uint64_t>(i));
    states.push_back(sample::random_state(body, random, 0.05, 1.0, spin_rad_s));
  }
  return states;
}

struct Batch {
  std::vector<SampleStatus> status;
  std::vector<double> end_s, position, spin;
  std::vector<std::int32_t> hits;
  Counts counts;

  Batch(const Body& body, const std::vector<State>& states, std::string_view set = "",
        const SimulationOptions& simulation = {})
      : status(states.size()),
        end_s(states.size()),
        position(3 * states.size()),
        spin(3 * states.size()),
        hits(states.size()) {
    BatchOutputs out;
    out.status = status, out.end_time_s = end_s, out.position_m = position, out.angular_velocity_rad_s = spin,
    out.hit_count = hits;
    BatchOptions options;
    options.simulation = simulation;
    options.until_s = 3.0;
    options.threads = 1;  // all on this thread, whose counters are read
    options.instruction_set = set;
    const Body* const bodies[1] = {&body};
    counts = counted([&] { simulate_batch(bodies, states, options, out); });
  }
};

Body cube(const Material& material = {}) { return sample::box({0.02, 0.02, 0.02}, 0.01, material); }
Body brick(const Material& material = {}) { return sample::box({0.01, 0.02, 0.04}, 0.02, material); }

EngineEffects without(EngineEffects effects, bool EngineEffects::*effect) {
  effects.*effect = false;
  return effects;
}

TEST(Effects, NeededFollowFromTheBody) {
  EXPECT_EQ(needed_effects(sample::ball(0.02, 0.03)), (EngineEffects{false, true, true, false}));
  EXPECT_EQ(needed_effects(cube()), (EngineEffects{false, true, false, false}));
  EXPECT_EQ(needed_effects(brick(sample::ideal(0.5, 0.0))), (EngineEffects{true, false, false, false}));
  EXPECT_EQ(needed_effects(brick({0.5, 0.0, 1e-5, 0.0})), (EngineEffects{true, true, false, false}));
  EXPECT_EQ(needed_effects(sample::coin()), (EngineEffects{true, true, true, true}));
}

TEST(Effects, CountsAreThoseOfTheEffectsOfTheBodyForAnyInstructionSet) {
  for (const Body& body : {sample::ball(0.02, 0.03), cube(), brick(), sample::coin(),
                           sample::rod(0.1, 0.004, 0.02), brick(sample::ideal(0.5, 0.0))}) {
    const EngineEffects needed = needed_effects(body);
    const std::vector<State> states = throws(body, 40);
    const Batch scalar(body, states, "scalar");
    EXPECT_EQ(of(scalar.counts, Effect::spin_coupling) > 0, needed.spin_coupling);
    EXPECT_EQ(of(scalar.counts, Effect::friction) > 0, needed.friction);
    EXPECT_EQ(of(scalar.counts, Effect::rounding) > 0, needed.rounding);
    EXPECT_EQ(of(scalar.counts, Effect::circular_edges) > 0, needed.circular_edges);
    EXPECT_GT(of(scalar.counts, Effect::sustained_contact), 0u);
    for (const std::string_view set : instruction_sets())
      EXPECT_EQ(Batch(body, states, set).counts, scalar.counts) << set;
  }
}

TEST(Effects, CodeOfAnEffectThatIsOffDoesNotRun) {
  const Body coin = sample::coin();
  const std::vector<State> states = throws(coin, 40);
  struct Case {
    Effect effect;
    bool EngineEffects::*field;
  };
  for (const auto& [effect, field] :
       {Case{Effect::spin_coupling, &EngineEffects::spin_coupling},
        Case{Effect::friction, &EngineEffects::friction}, Case{Effect::rounding, &EngineEffects::rounding},
        Case{Effect::circular_edges, &EngineEffects::circular_edges}}) {
    const Body body = with_effects(coin, without({}, field));
    const Batch batch(body, states);
    EXPECT_EQ(of(batch.counts, effect), 0u);
    EXPECT_EQ(std::ranges::count(batch.counts, 0u), 1);  // and that of the others does
    EXPECT_EQ(std::ranges::count(batch.status, SampleStatus::failed), 0);
  }
}

TEST(Effects, AsNeededAreTheSameBits) {
  for (const Body& body :
       {sample::ball(0.02, 0.03), brick(), sample::coin(), brick(sample::ideal(0.5, 0.0))}) {
    const Body same = with_effects(body, needed_effects(body));
    const std::vector<State> states = throws(body, 40);
    const Batch a(body, states), b(same, states);
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.spin, b.spin);
    EXPECT_EQ(a.end_s, b.end_s);
    EXPECT_EQ(a.counts, b.counts);
  }
}

TEST(Effects, MassMaterialAndOtherEffectsStay) {
  const Body coin = sample::coin({0.4, 0.2, 1e-5, 2e-5});
  const Body plain = with_effects(coin, {false, false, false, false});
  EXPECT_EQ(plain.mass_kg(), coin.mass_kg());
  EXPECT_EQ(plain.inertia_kg_m2(), coin.inertia_kg_m2());
  EXPECT_EQ(plain.principal_inertia(), coin.principal_inertia());
  EXPECT_EQ(plain.material().friction, 0.2);
  EXPECT_EQ(plain.contact_material().friction, 0.0);
  EXPECT_EQ(plain.contact_material().rolling_friction_m, 0.0);
  EXPECT_EQ(plain.contact_material().spin_friction_m, 0.0);
  EXPECT_EQ(plain.contact_material().restitution, 0.4);
  EXPECT_EQ(plain.radius_m(), 0.0);
  EXPECT_TRUE(plain.rings().empty());
  ASSERT_EQ(plain.vertices().size(), 2u * kCornersOfRing);
  const Ring& edge = coin.rings().front();
  for (const Vec3& v : plain.vertices()) {
    EXPECT_NEAR(v.head<2>().norm(), edge.radius_m, 1e-15);
    EXPECT_NEAR(std::abs(v.z()), std::abs(edge.centre_m.z()), 1e-15);
  }
  // A fit's materials keep what is off.
  const Body other = plain.with_material({0.6, 0.9, 1e-4, 1e-4});
  EXPECT_EQ(other.contact_material().friction, 0.0);
  EXPECT_FALSE(other.couples_spin());
}

TEST(Effects, RoundingCannotBeOffWithoutAVolume) {
  for (const Body& body : {sample::ball(0.02, 0.03), sample::rod(0.1, 0.004, 0.02)})
    EXPECT_THROW(with_effects(body, without({}, &EngineEffects::rounding)), ArgumentError);
}

// An isotropic body's series is of a constant spin.
TEST(SpinCoupling, ForcedOnAgreesWithConstantSpinForIsotropicBodies) {
  for (const Body& body : {cube(), sample::ball(0.02, 0.03)}) {
    const Body forced = with_effects(body, {true, true, true, true});
    ASSERT_TRUE(forced.couples_spin());
    RandomStream random(5, 0);
    Flight fast(body), series(forced);
    for (int i = 0; i < 100; ++i) {
      const State s = sample::random_state(body, random, 0.1, 2.0, i == 0 ? 0.0 : 300.0);
      fast.start(s, sample::downwards());
      series.start(s, sample::downwards());
      // Angles of up to 150 rad, each piece of 1.5 rad rounded once: 100 times 1e-16, and the angle's own
      // 3e-14.
      for (const double t : {-0.5, 0.01, 0.5}) {
        EXPECT_LT(sample::angle_between(fast.at(t).orientation, series.at(t).orientation), 2e-13);
        EXPECT_LT((fast.at(t).angular_velocity - series.at(t).angular_velocity).norm(), 2e-13 * 300.0);
      }
      // The same contact: the root is as sharp as heights are, 1e-14 m, over the speed at which it comes.
      EXPECT_NEAR(fast.next_contact(1.0), series.next_contact(1.0), 1e-11);
    }
    // And so until the second hit at least, in every set: an impact passes differences on at most tenfold.
    const std::vector<State> states = throws(body, 40);
    for (const std::string_view set : instruction_sets()) {
      SimulationOptions options;
      options.max_impacts = 2;
      const Batch off(body, states, set, options), on(forced, states, set, options);
      EXPECT_EQ(of(off.counts, Effect::spin_coupling), 0u);
      EXPECT_GT(of(on.counts, Effect::spin_coupling), 0u);
      EXPECT_EQ(off.status, on.status);
      for (std::size_t i = 0; i < off.position.size(); ++i)
        EXPECT_NEAR(off.position[i], on.position[i], 1e-10);
      for (std::size_t i = 0; i < off.spin.size(); ++i) EXPECT_NEAR(off.spin[i], on.spin[i], 1e-8);
    }
  }
}

TEST(SpinCoupling, OffKeepsTheSpinAndNotTheAngularMomentum) {
  const Body body = brick(), off = with_effects(body, without({}, &EngineEffects::spin_coupling));
  RandomStream random(6, 0);
  Flight coupled(body), plain(off);
  for (int i = 0; i < 20; ++i) {
    const State s = sample::random_state(body, random, 0.1, 1.0, 60.0);
    const double t = 0.2;
    coupled.start(s, sample::downwards());
    plain.start(s, sample::downwards());
    const State with = coupled.at(t), constant = plain.at(t);
    const Vec3 axis = s.angular_velocity.normalized();
    const Quat turned = Quat(Eigen::AngleAxisd(t * s.angular_velocity.norm(), axis)) * s.orientation;
    EXPECT_LT(sample::angle_between(constant.orientation, turned), 1e-13);
    EXPECT_EQ(constant.angular_velocity, s.angular_velocity);
    // L = R I R^T w by its definition; conserved but for rounding where it is coupled.
    const Vec3 before = sample::angular_momentum(body, s);
    EXPECT_LT((sample::angular_momentum(body, with) - before).norm(), 1e-12 * before.norm());
    const Mat3 q = turned.toRotationMatrix();
    const Vec3 theory =
        q * body.principal_inertia().asDiagonal() * q.transpose() * s.angular_velocity - before;
    EXPECT_LT((sample::angular_momentum(body, constant) - before - theory).norm(), 1e-12 * before.norm());
    if (s.angular_velocity.norm() > 5.0) {
      EXPECT_GT(theory.norm(), 1e-3 * before.norm());
    }
  }
}

// Impacts know the true inertia: their impulses explain the change of both momenta, and take energy.
TEST(SpinCoupling, OffLeavesImpactsTrue) {
  const Body off = with_effects(brick(), without({}, &EngineEffects::spin_coupling));
  int impacts = 0;
  for (const State& start : throws(off, 20)) {
    const ifa::Run run = simulate(off, start, {}, 3.0);
    ASSERT_EQ(run.status, RunStatus::rest);
    for (std::size_t i = 1; i < run.nodes.size(); ++i) {
      const Node &a = run.nodes[i - 1], &b = run.nodes[i];
      if (a.time_s != b.time_s) {  // flight and contact
        if (a.phase == Phase::flight) {
          EXPECT_EQ(a.state.angular_velocity, b.state.angular_velocity);
        }
        continue;
      }
      const auto hit = std::ranges::find(run.hits, a.time_s, &Hit::time_s);
      if (hit == run.hits.end()) {  // from contact to flight
        EXPECT_EQ(a.state.velocity, b.state.velocity);
        continue;
      }
      ++impacts;
      const Vec3 push = off.mass_kg() * (b.state.velocity - a.state.velocity);
      EXPECT_LT((push - hit->impulse_n_s).norm(), 1e-12 * (1.0 + push.norm()));
      EXPECT_LE(sample::kinetic(off, b.state), sample::kinetic(off, a.state) * (1.0 + 1e-12));
      EXPECT_GE(hit->impulse_n_s.z(), 0.0);
    }
  }
  EXPECT_GT(impacts, 60);
}

// Between two steps of contact a constant spin changes the energy of its pose; what contact adds to that is
// none.
TEST(SpinCoupling, OffStillComesToRest) {
  for (const Body& body : {brick(), sample::coin(), sample::rod(0.1, 0.004, 0.02)}) {
    const Body off = with_effects(body, without({}, &EngineEffects::spin_coupling));
    const Batch batch(off, throws(off, 30, 10.0));
    EXPECT_EQ(of(batch.counts, Effect::spin_coupling), 0u);
    EXPECT_GT(of(batch.counts, Effect::sustained_contact), 0u);
    EXPECT_EQ(std::ranges::count(batch.status, SampleStatus::failed), 0);
    for (std::size_t i = 0; i < batch.status.size(); ++i) EXPECT_LT(std::abs(batch.position[3 * i + 2]), 0.2);
  }
}

// On one point and on several: the sweeps end at 1e-12 of the speeds, or where they have stalled at 3e-5.
TEST(Friction, ForcedOnWithoutAnyAgreesWithTheSmoothSolution) {
  for (const Body& body :
       {brick(sample::ideal(0.5, 0.0)), sample::ball(0.02, 0.03, sample::ideal(0.6, 0.0))}) {
    const Body forced = with_effects(body, {!body.isotropic(), true, true, true});
    ASSERT_TRUE(forced.has_cone());
    const std::vector<State> states = throws(body, 60);
    SimulationOptions options;
    options.max_impacts = 1;
    for (const std::string_view set : instruction_sets()) {
      const Batch off(body, states, set, options), on(forced, states, set, options);
      EXPECT_EQ(of(off.counts, Effect::friction), 0u);
      EXPECT_GT(of(on.counts, Effect::friction), 0u);
      EXPECT_EQ(off.end_s, on.end_s);
      for (std::size_t i = 0; i < off.spin.size(); ++i) EXPECT_NEAR(off.spin[i], on.spin[i], 1e-9);
    }
  }
}

TEST(Friction, OffLeavesNormalImpulsesOnly) {
  const Body off = with_effects(brick({0.5, 0.6, 1e-4, 1e-4}), without({}, &EngineEffects::friction));
  ifa::Run run;
  for (const State& start : throws(off, 10)) {
    const Counts counts = counted([&] { run = simulate(off, start, {}, 1.0); });
    EXPECT_EQ(of(counts, Effect::friction), 0u);
    ASSERT_FALSE(run.hits.empty());
    for (const Hit& hit : run.hits) EXPECT_EQ(hit.impulse_n_s.head<2>().norm(), 0.0);
    // Nothing pushes it along the ground; a contact step may take what energy its own error would have added,
    // by scaling all velocities.
    bool contact = false;
    const Vec2 along = start.velocity.head<2>();
    for (const Node& node : run.nodes) {
      contact = contact || node.phase == Phase::contact;
      const Vec2 now = node.state.velocity.head<2>();
      EXPECT_LT(std::abs(now.x() * along.y() - now.y() * along.x()), 1e-12);
      EXPECT_LE(now.norm(), along.norm() * (1.0 + 1e-12));
      EXPECT_GE(now.norm(), along.norm() * (contact ? 0.99 : 1.0 - 1e-12));
    }
  }
}

// The same motion until contact would begin, and the end there.
TEST(SustainedContact, OffEndsASimulationWhereItWouldBegin) {
  const Body body = brick();
  SimulationOptions off;
  off.sustained_contact = false;
  for (const State& start : throws(body, 20)) {
    const ifa::Run whole = simulate(body, start, {}, 3.0);
    ifa::Run run;
    const Counts counts = counted([&] { run = simulate(body, start, off, 3.0); });
    EXPECT_EQ(of(counts, Effect::sustained_contact), 0u);
    EXPECT_EQ(run.status, RunStatus::contact);
    const auto begins = std::ranges::find(whole.nodes, Phase::contact, &Node::phase);
    ASSERT_NE(begins, whole.nodes.end());
    ASSERT_EQ(run.nodes.size(), static_cast<std::size_t>(begins - whole.nodes.begin()) + 1);
    EXPECT_EQ(run.nodes.back().time_s, begins->time_s);
    EXPECT_EQ(run.nodes.back().state.position, begins->state.position);
    EXPECT_EQ(run.nodes.back().state.angular_velocity, begins->state.angular_velocity);
  }
  const std::vector<State> states = throws(body, 40);
  const Batch scalar(body, states, "scalar", off);
  EXPECT_EQ(of(scalar.counts, Effect::sustained_contact), 0u);
  for (const SampleStatus status : scalar.status) EXPECT_EQ(status, SampleStatus::contact);
  for (const std::string_view set : instruction_sets()) {
    const Batch wide(body, states, set, off);
    EXPECT_EQ(wide.end_s, scalar.end_s);
    EXPECT_EQ(wide.position, scalar.position);
    EXPECT_EQ(wide.status, scalar.status);
  }
}

TEST(SustainedContact, OffAndTouchingAtTheStartEndsThere) {
  const Body body = cube();
  SimulationOptions off;
  off.sustained_contact = false;
  State lying;
  lying.position.z() = 0.01;
  const ifa::Run run = simulate(body, lying, off, 3.0);
  EXPECT_EQ(run.status, RunStatus::contact);
  EXPECT_EQ(run.nodes.back().time_s, 0.0);
  EXPECT_EQ(Batch(body, {lying}, "", off).status.front(), SampleStatus::contact);
}

}  // namespace
}  // namespace ifa
