#include "ifa/signature/events.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

}  // namespace
}  // namespace ifa
