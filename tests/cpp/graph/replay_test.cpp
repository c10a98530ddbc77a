// Edges simulated again against the nodes that they lead to.
#include "ifa/graph/replay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "folders.hpp"
#include "ifa/graph/build.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::message_of;

struct Sample {
  std::string name;
  Body body;
  std::uint64_t simulations;
};

std::vector<Sample> bodies() {
  return {{"cube", sample::box({0.016, 0.016, 0.016}, 0.005), 100},
          {"slab", sample::box({0.05, 0.03, 0.008}, 0.01, {0.3, 0.6, 1e-4, 1e-4}), 100},
          {"ball", sample::ball(0.02, 0.03, {0.6, 0.3, 1e-3, 1e-3}), 8},
          {"coin", sample::coin(), 8}};
}

class Replayed : public ::testing::TestWithParam<Events> {};

// Every edge and every ending of a database; what is stored of them in single precision agrees to 24 bits.
TEST_P(Replayed, EveryEdgeLeadsToTheNextNode) {
  Recipe recipe;
  recipe.physics.hearing.events = GetParam();
  for (const Sample& s : bodies()) {
    SCOPED_TRACE(s.name);
    const sample::TemporaryFolder folder;
    const Database database = build_database(s.body, recipe, folder.path(), s.simulations, 2);
    const Nodes& nodes = database.nodes();
    ASSERT_GT(nodes.size(), s.simulations / 2);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      SCOPED_TRACE("node " + std::to_string(i));
      Record record;
      const Passage passage = replay_edge(database, i, record);
      EXPECT_EQ(record.nodes.front().state.velocity, onset_of(nodes, i).velocity);
      EXPECT_EQ(passage.hits() || passage.onset.hit.approach_speed_m_s > 0.0, (nodes.flags[i] & kEdge) != 0);
      EXPECT_EQ(passage.next == Next::dubious, (nodes.flags[i] & kDubious) != 0);
      if (nodes.flight_s[i] > 0.0f) {
        const double interval_s =
            static_cast<double>(nodes.delay_s[i]) + static_cast<double>(nodes.flight_s[i]);
        EXPECT_NEAR(passage.interval_s, interval_s, 2e-7 * interval_s);
        const double height_m = static_cast<double>(nodes.take_off[10 * i + 9]);
        EXPECT_NEAR(state_before_last_flight(record).position.z(), height_m, 2e-7 * height_m);
      }
      const Onset onset = replay_onset(database, i);
      EXPECT_LE(state_difference(s.body, onset.after, onset_of(nodes, i)), kReplayTolerance);
      // A discrete event is its first impact, and its amplitude that impact's impulse.
      if (nodes.delay_s[i] == 0.0f) {
        const double impulse_n_s = onset.hit.impulse_n_s.norm();
        EXPECT_NEAR(static_cast<double>(nodes.amplitude[i]), impulse_n_s, 2e-6 * impulse_n_s);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Replayed, ::testing::Values(Events::audible, Events::contact));

// The same database, but that one number of one onset is changed where the file is.
class Tampered : public ::testing::Test {
 protected:
  Database with_onset(std::size_t node, std::size_t column, double factor) {
    build_database(bodies()[0].body, {}, folder_.path(), 20, 1);
    const Database database = Database::open(folder_.path());
    for (const ArrayInfo& a : database.files().arrays()) {
      if (a.name != "onset") continue;
      std::string bytes = sample::content(folder_.path() / a.file);
      double value;
      char* const at = bytes.data() + sizeof(double) * (11 * node + column);
      std::memcpy(&value, at, sizeof value);
      value *= factor;
      std::memcpy(at, &value, sizeof value);
      std::filesystem::remove(folder_.path() / a.file);  // `database` keeps what it has
      sample::put(folder_.path() / a.file, bytes);
    }
    return Database::open(folder_.path());
  }

  sample::TemporaryFolder folder_;
};

TEST_F(Tampered, AnEdgeThatLeadsElsewhereIsRefused) {
  constexpr std::size_t kNode = 1, kVelocityZ = 7;
  const Database database = with_onset(kNode, kVelocityZ, 1.0 + 1e-4);
  ASSERT_EQ(database.nodes().simulation[0], database.nodes().simulation[kNode + 1]);
  Record record;
  for (const std::size_t i : {kNode - 1, kNode}) {  // the edge that leads there, and the one from there
    const std::string why = message_of<ReplayError>([&] { replay_edge(database, i, record); });
    EXPECT_TRUE(why.starts_with(folder_.path().string() + ": node " + std::to_string(i) + " (simulation 0)"))
        << why;
  }
  EXPECT_THROW(replay_onset(database, kNode), ReplayError);
  EXPECT_NO_THROW(replay_edge(database, kNode + 1, record));
  EXPECT_THROW(database.check(1), FileError);
}

TEST_F(Tampered, RoundingIsNotRefused) {
  const Database database = with_onset(1, 7, 1.0 + 1e-9);
  Record record;
  EXPECT_NO_THROW(replay_edge(database, 0, record));
}

TEST_F(Tampered, AFirstOnsetIsComparedWithItsSample) {
  EXPECT_THROW(replay_onset(with_onset(0, 7, 1.0 + 1e-4), 0), ReplayError);
}

TEST(Replay, WhatHasNoEdgeIsRefused) {
  const sample::TemporaryFolder folder;
  Recipe recipe;
  recipe.until_s = 0.1;  // before dice rest
  const Database database = build_database(bodies()[0].body, recipe, folder.path(), 20, 1);
  Record record;
  std::size_t cut = 0;
  for (std::size_t i = 0; i < database.nodes().size(); ++i) {
    if (database.nodes().flags[i] & (kEdge | kTerminal)) continue;
    EXPECT_THROW(replay_edge(database, i, record), ArgumentError);
    ++cut;
  }
  EXPECT_GT(cut, 10u);
  EXPECT_THROW(replay_edge(database, database.nodes().size(), record), ArgumentError);
}

TEST(Replay, DifferenceIsThatOfTheLargestPart) {
  const Body body = sample::box({0.02, 0.02, 0.02}, 0.005);
  const double radius = std::sqrt(3.0) * 0.01;
  State a;
  a.position = {3.0, 4.0, 0.5};
  a.velocity = {3.0, 0.0, 0.0};
  a.angular_velocity = {0.0, 1.0 / radius, 0.0};  // with the velocity: 4 m/s
  EXPECT_EQ(state_difference(body, a, a), 0.0);
  State b = a;
  b.position.x() = 7.0;  // where on the plane is of no account
  EXPECT_EQ(state_difference(body, a, b), 0.0);
  b.orientation.coeffs() *= -1.0;  // the same orientation
  EXPECT_EQ(state_difference(body, a, b), 0.0);
  b.position.z() += 1e-5 * radius;
  EXPECT_NEAR(state_difference(body, a, b), 1e-5, 1e-13);  // rounding of the height
  b.orientation = b.orientation * Quat(Eigen::AngleAxisd(2e-5, Vec3::UnitX()));
  EXPECT_NEAR(state_difference(body, a, b), 2e-5, 1e-14);  // the sine for the angle
  b.velocity.z() = 4.0 * 3e-5;
  EXPECT_NEAR(state_difference(body, a, b), 3e-5, 1e-13);  // the faster one's speed
  b.angular_velocity.z() = 4.0 * 4e-5 / radius;
  EXPECT_NEAR(state_difference(body, a, b), 4e-5, 1e-8);
}

}  // namespace
}  // namespace ifa
