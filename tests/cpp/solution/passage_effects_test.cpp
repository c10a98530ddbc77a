// Passages of bodies and simulations that have effects off.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "ifa/base/effects.hpp"
#include "ifa/motion/motion.hpp"
#include "ifa/rigid/effects.hpp"
#include "sample_bodies.hpp"
#include "solution/passages.hpp"

namespace ifa {
namespace {

Body slab() { return sample::box({0.05, 0.03, 0.008}, 0.01, {0.4, 0.5, 1e-4, 1e-4}); }
Body uncoupled() { return with_effects(slab(), {false, true, true, true}); }

std::vector<Departure> departures(const Body& body, const SearchPhysics& physics, int count,
                                  double fall_m_s = 2.0, double spin_rad_s = 20.0) {
  std::vector<Departure> out;
  for (int i = 0; i < count; ++i) {
    RandomStream random(23, static_cast<std::uint64_t>(i));
    State s = sample::random_state(body, random, 0.0, 1.5, spin_rad_s);
    s.velocity.z() = -fall_m_s * random.uniform(0.25, 1.0);
    const Onset onset = strike(body, physics, s);
    out.push_back({onset.hit, onset.after, 0.0, 2.0});
  }
  return out;
}

std::vector<Passage> run_all(const Body& body, const SearchPhysics& physics,
                             const std::vector<Departure>& from) {
  Passages passages(body, physics);
  std::vector<Passage> out(from.size());
  passages.run(from, out, nullptr);
  return out;
}

void expect_same(const State& a, const State& b) {
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.orientation.coeffs(), b.orientation.coeffs());
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.angular_velocity, b.angular_velocity);
}

// Searched, recorded and exported: one motion, in flight with a constant spin.
TEST(PassageEffects, ConstantSpinInTheSearchIsThatOfTheMotion) {
  const Body body = uncoupled();
  for (const bool sustained : {true, false}) {
    SearchPhysics physics = sample::physics_of(Events::audible);
    physics.simulation.sustained_contact = sustained;
    const std::vector<Departure> from = departures(body, physics, 40);
    const std::vector<Passage> searched = run_all(body, physics, from);
    for (std::size_t i = 0; i < from.size(); ++i) {
      Record record;
      const Passage recorded = record_passage(body, physics, from[i], record);
      if (sustained) {
        EXPECT_EQ(recorded.next, searched[i].next);
      }
      EXPECT_EQ(recorded.interval_s, searched[i].interval_s);
      expect_same(recorded.end, searched[i].end);

      record.nodes.push_back({recorded.interval_s, recorded.end, record.nodes.back().phase});
      const Motion motion(body, sample::downwards(), record.nodes, record.hits, {});
      for (std::size_t k = 0; k + 1 < record.nodes.size(); ++k) {
        const Node &a = record.nodes[k], &b = record.nodes[k + 1];
        if (a.phase != Phase::flight || b.time_s - a.time_s < 1e-6) continue;
        EXPECT_EQ(a.state.angular_velocity, b.state.angular_velocity);
        for (const double share : {0.3, 1.0 - 1e-9}) {
          const double t = share * (b.time_s - a.time_s);
          const State s = motion.sample({a.time_s + t}).front();
          const Vec3& spin = a.state.angular_velocity;
          const Quat turned =
              Quat(Eigen::AngleAxisd(t * spin.norm(), spin.normalized())) * a.state.orientation;
          EXPECT_LT(sample::angle_between(s.orientation, turned), 1e-13);
          EXPECT_EQ(s.angular_velocity, spin);
        }
        // To where the simulation went: 1e-9 of an interval of at most 0.5 s at 100 rad/s is 5e-8 rad.
        const State last = motion.sample({a.time_s + (1.0 - 1e-9) * (b.time_s - a.time_s)}).front();
        EXPECT_LT(sample::angle_between(last.orientation, b.state.orientation), 1e-7);
        EXPECT_LT((last.position - b.state.position).norm(), 1e-8);
      }
    }
  }
}

// Backwards too: where the flight is followed to, something touches the ground.
TEST(PassageEffects, FlightBeforeTheFirstContactHasTheSameSpin) {
  const Body body = uncoupled();
  int touched = 0;
  for (int i = 0; i < 40; ++i) {
    RandomStream random(29, static_cast<std::uint64_t>(i));
    State s = sample::random_state(body, random, 0.0, 1.0, 100.0);
    s.velocity.z() = -random.uniform(0.2, 1.5);
    const double clear = clear_before(body, s, sample::downwards(), 0.3);
    Flight flight(body);
    flight.start(s, sample::downwards());
    for (int k = 1; k < 20; ++k) EXPECT_GT(sample::lowest(body, flight.at(-clear * k / 20.0)), -1e-12);
    if (clear == 0.3) continue;
    touched += clear > 0.01 ? 1 : 0;
    EXPECT_NEAR(sample::lowest(body, flight.at(-clear)), 0.0, 1e-12);
  }
  EXPECT_GT(touched, 5);
}

// What is a hit before contact begins is the same; the rest is given up there, and no step is made.
TEST(PassageEffects, WithoutSustainedContactAPassageEndsWhereThatBegins) {
  const Body body = slab();
  const SearchPhysics on = sample::physics_of(Events::audible);
  SearchPhysics off = on;
  off.simulation.sustained_contact = false;
  const std::vector<Departure> from = departures(body, on, 60, 0.3, 3.0);  // too slow to go on for long
  const std::vector<Passage> whole = run_all(body, on, from);
  const EffectCounts before = effect_counts;
  const std::vector<Passage> cut = run_all(body, off, from);
  constexpr auto kSustained = static_cast<std::size_t>(Effect::sustained_contact);
  EXPECT_EQ(effect_counts.runs[kSustained], before.runs[kSustained]);
  int late = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    EXPECT_NE(cut[i].next, Next::rest);
    if (!cut[i].hits()) {
      EXPECT_EQ(cut[i].next, Next::dubious);  // what comes of the contact is not known
      ++late;
      EXPECT_LE(cut[i].interval_s, whole[i].interval_s);
      Record record;
      record_passage(body, on, from[i], record);
      const auto begins = std::ranges::find(record.nodes, Phase::contact, &Node::phase);
      ASSERT_NE(begins, record.nodes.end());
      EXPECT_EQ(cut[i].interval_s, begins->time_s);
      expect_same(cut[i].end, begins->state);
    } else {
      EXPECT_EQ(cut[i].next, whole[i].next);
      EXPECT_EQ(cut[i].interval_s, whole[i].interval_s);
      expect_same(cut[i].onset.after, whole[i].onset.after);
    }
  }
  EXPECT_GT(late, 5);
  EXPECT_LT(late, 60);
}

}  // namespace
}  // namespace ifa
