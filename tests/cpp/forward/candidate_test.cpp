#include "ifa/forward/candidate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

Marks marks() {
  Marks m;
  m.times_s = {0.0, 0.3, 0.5};
  m.durations_s = {0.0, 0.05, 0.2};
  m.centroids_s = {std::nan(""), std::nan(""), std::nan("")};
  m.ending = Ending::rest;
  return m;
}

// Friction takes mu times the normal impulse: of the weight while in contact, and of each bounce, which turns
// a fall of g T / 2 round to e times that.
TEST(TravelBudget, IsWhatFrictionTakes) {
  const double e = 0.4, mu = 0.25, g = sample::kGravity;
  const std::vector<Body> bodies{sample::ball(0.02, 0.03, {e, mu, 0.0, 0.0})};
  SearchPhysics physics;
  physics.hearing.events = Events::contact;
  const Marks m = marks();
  const Problem problem{bodies, physics, m};
  const double rolled = 0.1;  // a constant
  const double last = mu * g * 0.2 + rolled;
  EXPECT_NEAR(problem.travel_budget_m_s(0, 2), last, 1e-12);
  const double bounce = 0.5 * (1.0 + e) * g * (0.5 - 0.3 - 0.05);
  EXPECT_NEAR(problem.travel_budget_m_s(0, 1), last + mu * (g * 0.05 + bounce), 1e-12);
  const double first = 0.5 * (1.0 + e) * g * 0.3;
  EXPECT_NEAR(problem.travel_budget_m_s(0, 0), last + mu * (g * 0.05 + bounce + first), 1e-12);
}

TEST(TravelBudget, KnowsNoLimitWhereContactMayBeSilent) {
  const std::vector<Body> bodies{sample::ball(0.02, 0.03)};
  SearchPhysics physics;
  Marks m = marks();
  EXPECT_EQ((Problem{bodies, physics, m}.travel_budget_m_s(0, 0)), kNever);
  physics.hearing.events = Events::contact;
  m.ending = Ending::open;
  EXPECT_EQ((Problem{bodies, physics, m}.travel_budget_m_s(0, 0)), kNever);
}

TEST(Candidate, PlausibleBeforeUnnoticedBeforeRank) {
  Candidate sound, stretched, violating;
  stretched.stretched = 1;
  violating.violations = 1;
  sound.log_weight = -9.0;
  EXPECT_TRUE(sound.sounder(stretched));
  EXPECT_TRUE(stretched.sounder(violating));
  EXPECT_FALSE(violating.sounder(stretched));
  EXPECT_FALSE(sound.sounder(sound));
  sound.outlook = -1.0;
  EXPECT_EQ(sound.rank(), -10.0);
}

}  // namespace
}  // namespace ifa
