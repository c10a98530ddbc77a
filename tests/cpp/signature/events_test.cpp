#include "ifa/signature/events.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

Hit hit(double time_s, double impulse_n_s, double speed_m_s = 1.0) {
  Hit h;
  h.time_s = time_s;
  h.impulse_n_s = impulse_n_s * Vec3(0.0, 0.6, 0.8);
  h.approach_speed_m_s = speed_m_s;
  return h;
}

TEST(EventBuilder, HitIsAudibleFromTheAudibleSpeedOn) {
  const EventBuilder builder({}, 0.0);
  EXPECT_TRUE(builder.audible(hit(0, 1, 0.05)));
  EXPECT_FALSE(builder.audible(hit(0, 1, std::nextafter(0.05, 0.0))));
  HearingOptions quiet;
  quiet.audible_speed_m_s = 0.2;
  EXPECT_FALSE(EventBuilder(quiet, 0.0).audible(hit(0, 1, 0.19)));
}

TEST(EventBuilder, OneHitIsADiscreteEvent) {
  EventBuilder builder({}, 0.0);
  builder.begin(hit(1.5, 2.0));
  const Event e = builder.event();
  EXPECT_EQ(e.time_s, 1.5);
  EXPECT_EQ(e.length_s, 0.0);
  EXPECT_NEAR(e.amplitude, 2.0, 1e-15);
  EXPECT_EQ(e.centroid_s, 0.0);
  EXPECT_EQ(e.hits, 1);
}

TEST(EventBuilder, ChainsToTheLastHitNotToTheFirst) {
  EventBuilder builder({}, 0.0);
  builder.begin(hit(1.0, 3.0));
  for (const double gap : {0.009, 0.018, 0.027}) {
    EXPECT_TRUE(builder.chains(1.0 + gap));
    EXPECT_FALSE(builder.chains(1.0 + gap + 0.0011));
    builder.add(hit(1.0 + gap, 4.0));
  }
  const Event e = builder.event();
  EXPECT_EQ(e.hits, 4);
  EXPECT_EQ(e.time_s, 1.0);
  EXPECT_NEAR(e.length_s, 0.027, 1e-15);  // longer than the merge gap: continuous
  EXPECT_NEAR(e.amplitude, std::sqrt(9.0 + 3 * 16.0), 1e-14);
  EXPECT_NEAR(e.centroid_s, 4.0 * (0.009 + 0.018 + 0.027) / 15.0, 1e-15);
}

TEST(EventBuilder, ChainShorterThanTheMergeGapIsDiscrete) {
  EventBuilder builder({}, 0.0);
  builder.begin(hit(0.0, 1.0));
  builder.add(hit(0.0099, 1.0));
  EXPECT_EQ(builder.event().length_s, 0.0);
  builder.add(hit(0.0101, 1.0));
  EXPECT_NEAR(builder.event().length_s, 0.0101, 1e-17);
}

TEST(EventBuilder, MergeGapIsAnOption) {
  HearingOptions hearing;
  hearing.merge_gap_s = 0.030;
  EventBuilder builder(hearing, 0.0);
  builder.begin(hit(0.0, 1.0));
  EXPECT_TRUE(builder.chains(0.0299));
  EXPECT_FALSE(builder.chains(0.0301));
}

TEST(EventBuilder, InsideAMarkedSpanAnyGapChains) {
  EventBuilder builder({}, 0.2);
  builder.begin(hit(1.0, 1.0));
  EXPECT_TRUE(builder.chains(1.15));
  EXPECT_TRUE(builder.chains(1.1999));
  EXPECT_FALSE(builder.chains(1.2001));  // as the verifier has it: beyond the span only a hit nearby chains
  builder.add(hit(1.195, 1.0));
  EXPECT_TRUE(builder.chains(1.2049));  // on from its last hit
  EXPECT_FALSE(builder.chains(1.2051));
}

TEST(EventBuilder, ChainsOnBeyondASpanByTheMergeGap) {
  EventBuilder builder({}, 0.0151);
  builder.begin(hit(0.3946, 1.0));
  EXPECT_FALSE(builder.judged_gap_s(0.4091).has_value());  // inside the span
  builder.add(hit(0.4091, 1.0));
  for (const double next : {0.4142, 0.4241}) {
    ASSERT_TRUE(builder.judged_gap_s(next).has_value());
    EXPECT_TRUE(builder.chains(next));
    builder.add(hit(next, 1.0));
  }
  EXPECT_NEAR(*builder.judged_gap_s(0.4342), 0.0101, 1e-12);
  EXPECT_FALSE(builder.chains(0.4342));
  EXPECT_EQ(builder.event().hits, 4);
  EXPECT_NEAR(builder.event().loose_s, 0.0145, 1e-12);
  EXPECT_NEAR(builder.event().gap_s, 0.0099, 1e-12);
}

TEST(EventBuilder, SlipDoesNotBridgeTheGapBetweenHits) {
  EventBuilder builder({}, 0.02);
  builder.begin(hit(1.0, 1.0));
  builder.add(Load{1.0, 0.02, 0.1, 1.0});
  EXPECT_EQ(builder.last_s(), 1.02);
  EXPECT_NEAR(*builder.judged_gap_s(1.021), 0.021, 1e-12);
  EXPECT_FALSE(builder.chains(1.021));
}

TEST(EventBuilder, TellsWhichHitsOnlyTheSpanHolds) {
  EventBuilder builder({}, 0.2);
  builder.begin(hit(1.0, 1.0));
  builder.add(hit(1.009, 1.0));  // chains by itself
  EXPECT_EQ(builder.event().loose_s, 0.0);
  builder.add(hit(1.1, 1.0));
  builder.add(hit(1.105, 1.0));
  EXPECT_NEAR(builder.event().loose_s, 0.1, 1e-12);  // rounding of 1.1 - 1.0
  EXPECT_NEAR(builder.event().gap_s, 0.009, 1e-12);  // of those that chain by themselves
}

TEST(EventBuilder, AudibleSlipUnderLoadAddsTheForcesTimeIntegral) {
  EventBuilder builder({}, 0.2);
  builder.begin(hit(1.0, 3.0));
  // 5 N for 40 ms from 1.1 s on; how it is cut into steps does not matter
  for (const int steps : {1, 4, 40}) {
    EventBuilder cut({}, 0.2);
    cut.begin(hit(1.0, 3.0));
    for (int i = 0; i < steps; ++i) cut.add(Load{1.1 + 0.04 * i / steps, 0.04 / steps, 0.2 / steps, 0.06});
    const Event e = cut.event();
    EXPECT_NEAR(e.amplitude, 3.2, 1e-14) << steps;
    EXPECT_NEAR(e.length_s, 0.14, 1e-14);
    EXPECT_NEAR(e.centroid_s, 0.2 * 0.12 / 3.2, 1e-14);
    EXPECT_EQ(e.hits, 1);
  }
}

TEST(EventBuilder, SilentContactAddsNothing) {
  EventBuilder builder({}, 0.2);
  builder.begin(hit(1.0, 3.0));
  builder.add(Load{1.01, 0.001, 0.1, 0.049});  // slower than the audible slip
  builder.add(Load{1.02, 0.001, 0.0, 1.0});    // without load
  builder.add(Load{1.30, 0.001, 0.1, 1.0});    // after the span
  EXPECT_NEAR(builder.event().amplitude, 3.0, 1e-15);
  EXPECT_EQ(builder.event().length_s, 0.0);
  EXPECT_EQ(builder.last_s(), 1.0);
}

TEST(EventBuilder, BeginForgetsTheLastEvent) {
  EventBuilder builder({}, 0.0);
  builder.begin(hit(1.0, 3.0));
  builder.add(hit(1.005, 4.0));
  builder.begin(hit(2.0, 0.5));
  EXPECT_EQ(builder.event().hits, 1);
  EXPECT_NEAR(builder.event().amplitude, 0.5, 1e-16);
  EXPECT_EQ(builder.event().time_s, 2.0);
  EXPECT_FALSE(builder.chains(2.0101));
}

HearingOptions contact() {
  HearingOptions hearing;
  hearing.events = Events::contact;
  return hearing;
}

TEST(ContactEvent, AnImpactOfAnySpeedCounts) {
  const EventBuilder builder(contact(), 0.0);
  EXPECT_TRUE(builder.audible(hit(0, 1, 1e-9)));
}

TEST(ContactEvent, OneBounceIsDiscrete) {
  EventBuilder builder(contact(), 0.0);
  builder.begin(hit(1.5, 2.0));
  EXPECT_TRUE(builder.chains(1.5099));
  EXPECT_FALSE(builder.chains(1.5101));
  const Event e = builder.event();
  EXPECT_EQ(e.time_s, 1.5);
  EXPECT_EQ(e.length_s, 0.0);
  EXPECT_NEAR(e.amplitude, 2.0, 1e-15);
  EXPECT_EQ(e.hits, 1);
}

TEST(ContactEvent, GoesOnThroughSustainedContactWhateverItSlips) {
  // An impact of 3 N s, then 5 N for 40 ms; how it is cut into steps does not matter, nor that it rolls.
  for (const int steps : {1, 4, 40})
    for (const double slip_m_s : {0.0, 1.0}) {
      EventBuilder builder(contact(), 0.0);
      builder.begin(hit(1.0, 3.0));
      for (int i = 0; i < steps; ++i)
        builder.add(Load{1.0 + 0.04 * i / steps, 0.04 / steps, 0.2 / steps, slip_m_s});
      EXPECT_TRUE(builder.chains(1.0499));  // 10 ms from the end of contact, not from the impact
      EXPECT_FALSE(builder.chains(1.0501));
      const Event e = builder.event();
      EXPECT_NEAR(e.length_s, 0.04, 1e-14);  // rounding, as below
      EXPECT_NEAR(e.amplitude, 3.2, 1e-14);
      EXPECT_NEAR(e.centroid_s, 0.2 * 0.02 / 3.2, 1e-14);
      EXPECT_EQ(e.hits, 1);
    }
}

TEST(ContactEvent, ShortFlightsJoinAndTheLongestIsTold) {
  EventBuilder builder(contact(), 0.0);
  builder.begin(hit(1.0, 3.0));
  builder.add(Load{1.0, 0.02, 0.1, 0.0});
  EXPECT_EQ(builder.event().gap_s, 0.0);
  builder.add(hit(1.029, 4.0));                // after a flight of 9 ms
  builder.add(Load{1.029, 0.001, 0.0, 0.0});   // bears nothing: flies already
  builder.add(Load{1.0325, 0.002, 0.1, 0.0});  // touches again, too softly for an impact
  const Event e = builder.event();
  EXPECT_NEAR(e.gap_s, 0.009, 1e-12);
  EXPECT_EQ(e.loose_s, 0.0);
  EXPECT_NEAR(e.length_s, 0.0345, 1e-12);
  EXPECT_NEAR(e.amplitude, 5.0 + 0.2, 1e-14);
}

TEST(ContactEvent, ContactThatReturnsWithoutAnImpactAfterALongFlightShowsInTheGap) {
  // Nothing new begins without an impact; the gap says that the merge gap does not hold this.
  EventBuilder builder(contact(), 0.0);
  builder.begin(hit(1.0, 3.0));
  builder.add(Load{1.012, 0.001, 0.1, 0.0});
  EXPECT_NEAR(builder.event().gap_s, 0.012, 1e-12);
}

TEST(ContactEvent, AMarkedSpanExcusesNothing) {
  EventBuilder builder(contact(), 0.5);
  builder.begin(hit(1.0, 1.0));
  EXPECT_FALSE(builder.chains(1.0101));
  EXPECT_NEAR(*builder.judged_gap_s(1.0101), 0.0101, 1e-12);
  builder.add(Load{1.0, 0.6, 0.1, 1.0});  // and contact after the span is contact
  EXPECT_NEAR(builder.event().length_s, 0.6, 1e-12);
}

TEST(ContactEvent, RestIsClipped) {
  EventBuilder builder(contact(), 0.0);
  builder.begin(hit(1.0, 3.0));
  for (int i = 0; i < 100; ++i) builder.add(Load{1.0 + 1e-3 * i, 1e-3, 0.005, 0.0});
  builder.clip(1.0305);  // within a step, which counts in part
  Event e = builder.event();
  EXPECT_NEAR(e.length_s, 0.0305, 1e-12);
  EXPECT_NEAR(e.amplitude, 3.0 + 30.5 * 0.005, 1e-12);
  EXPECT_NEAR(e.centroid_s, 30.5 * 0.005 * 0.5 * 0.0305 / e.amplitude, 1e-12);
  builder.clip(1.0);  // dead at once
  EXPECT_EQ(builder.event().length_s, 0.0);
  EXPECT_NEAR(builder.event().amplitude, 3.0, 1e-14);
  builder.begin(hit(2.0, 1.0));  // the next one knows nothing of it
  builder.add(Load{2.0, 0.05, 0.1, 0.0});
  e = builder.event();
  EXPECT_NEAR(e.length_s, 0.05, 1e-12);
  EXPECT_NEAR(e.amplitude, 1.1, 1e-14);
}

// What is on the ground of a run, from its nodes and hits alone. The force of a step of contact comes from
// the change of momentum.
struct Grounded {
  double begin_s, end_s, impulse_n_s;
  bool hit;
};

std::vector<Grounded> grounded(const Body& body, const Run& run) {
  std::vector<Grounded> parts;
  for (const Hit& h : run.hits) parts.push_back({h.time_s, h.time_s, h.impulse_n_s.norm(), true});
  for (std::size_t i = 0; i + 1 < run.nodes.size(); ++i) {
    const Node &a = run.nodes[i], &b = run.nodes[i + 1];
    const double length = std::min(b.time_s, run.rest_s) - a.time_s;
    if (a.phase != Phase::contact || length <= 0.0) continue;
    const double whole = b.time_s - a.time_s;
    const double impulse =
        body.mass_kg() * (b.state.velocity.z() - a.state.velocity.z() + sample::kGravity * whole);
    // a body that lifts off within contact bears nothing; 1e-9 of its weight is rounding
    if (impulse < 1e-9 * body.mass_kg() * sample::kGravity * whole) continue;
    parts.push_back({a.time_s, a.time_s + length, impulse * length / whole, false});
  }
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Grounded& a, const Grounded& b) { return a.begin_s < b.begin_s; });
  return parts;
}

// Merged one after the other, as the paper's section 4 says.
std::vector<Event> merged(const std::vector<Grounded>& parts, double merge_gap_s) {
  std::vector<Event> events;
  double end = -1.0, squares = 0.0, force = 0.0;
  for (const Grounded& p : parts) {
    if (events.empty() || p.begin_s - end >= merge_gap_s) {
      events.push_back({});
      events.back().time_s = p.begin_s;
      squares = force = 0.0;
    }
    end = std::max(end, p.end_s);
    (p.hit ? squares : force) += p.hit ? p.impulse_n_s * p.impulse_n_s : p.impulse_n_s;
    Event& e = events.back();
    e.hits += p.hit;
    e.length_s = end - e.time_s < merge_gap_s ? 0.0 : end - e.time_s;
    e.amplitude = std::sqrt(squares) + force;
  }
  return events;
}

TEST(ContactEvent, AgreesWithMergedIntervalsOfSimulatedRuns) {
  RandomStream random(11, 0);
  int continuous = 0, discrete = 0;
  for (const double restitution : {0.15, 0.5}) {
    const Body body = sample::box({0.016, 0.02, 0.03}, 0.01, {restitution, 0.3});
    for (int k = 0; k < 20; ++k) {
      State state = sample::random_state(body, random, 0.0, 1.0, 20.0);
      state.velocity.z() = -1.0 - std::abs(state.velocity.z());
      const auto run = simulate(body, state, {}, 20.0);
      ASSERT_EQ(run.status, RunStatus::rest);

      EventSimulation simulation(body, {});
      std::vector<Load> loads;
      simulation.start(state, 0.0, nullptr, &loads);
      if (simulation.approach_speed() <= 0.0) continue;
      std::vector<Event> events;
      EventBuilder builder(contact(), 0.0);
      bool begun = false;
      for (;;) {
        const bool chains = begun && builder.chains(simulation.time_s());
        const Hit found = simulation.resolve();
        if (chains) {
          builder.add(found);
        } else {
          if (begun) events.push_back(builder.event());
          builder.begin(found);
        }
        begun = true;
        const auto stop = simulation.advance(20.0);
        for (const Load& load : loads) builder.add(load);
        loads.clear();
        if (stop != EventSimulation::Stop::impact) break;
      }
      builder.clip(simulation.rest_s());
      events.push_back(builder.event());

      const std::vector<Event> expected = merged(grounded(body, run), 0.010);
      ASSERT_EQ(events.size(), expected.size()) << restitution << " " << k;
      for (std::size_t i = 0; i < events.size(); ++i) {
        EXPECT_EQ(events[i].time_s, expected[i].time_s);
        EXPECT_EQ(events[i].hits, expected[i].hits);
        EXPECT_NEAR(events[i].length_s, expected[i].length_s, 1e-12);
        // A step ends with corrections (onto the ground, of the energy) that change the momentum but are no
        // load: up to 1 % of an event here.
        EXPECT_NEAR(events[i].amplitude / expected[i].amplitude, 1.0, 0.02) << restitution << " " << k;
        ++(events[i].length_s > 0.0 ? continuous : discrete);
      }
    }
  }
  EXPECT_GT(continuous, 40);  // the runs show both kinds
  EXPECT_GT(discrete, 40);
}

}  // namespace
}  // namespace ifa
