// Paths of a database made motions: what was simulated comes out as it was, splices hit the poses they aim
// at, images move as bodies do.
#include "ifa/graph/realise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "folders.hpp"
#include "ifa/graph/build.hpp"
#include "ifa/graph/graph.hpp"
#include "ifa/graph/replay.hpp"
#include "ifa/graph/solve.hpp"
#include "ifa/rigid/flight.hpp"
#include "ifa/signature/signature_of.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

Body die() {
  Material material;
  material.friction = 0.25;
  return sample::box({0.016, 0.016, 0.016}, 0.005, material);
}

class Realising : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new sample::TemporaryFolder();
    database_ = new Database(build_database(die(), Recipe{}, folder_->path() / "d6", 1500, 2));
    graph_ = new ContactGraph(ContactGraph::of(*database_, 0.0, 2));
  }
  static void TearDownTestSuite() {
    delete graph_;
    delete database_;
    delete folder_;
  }

  // The marks that a simulation of the database would have made, from its `first` node over `count` events.
  static Marks marks_of(std::uint32_t first, std::size_t count) {
    const Nodes& nodes = database_->nodes();
    Marks marks;
    double time_s = 0.4;
    for (std::uint32_t i = first; i < first + count; ++i) {
      marks.times_s.push_back(time_s);
      marks.durations_s.push_back(nodes.length_s[i]);
      marks.centroids_s.push_back(nodes.length_s[i] > 0.0f ? nodes.centroid_s[i] : std::nan(""));
      marks.amplitudes.push_back(nodes.amplitude[i]);
      time_s += static_cast<double>(nodes.delay_s[i]) + static_cast<double>(nodes.flight_s[i]);
    }
    marks.ending = (nodes.flags[first + count - 1] & kTerminal) != 0 ? Ending::rest : Ending::open;
    return marks;
  }

  static sample::TemporaryFolder* folder_;
  static Database* database_;
  static ContactGraph* graph_;
};
sample::TemporaryFolder* Realising::folder_ = nullptr;
Database* Realising::database_ = nullptr;
ContactGraph* Realising::graph_ = nullptr;

// The last `count` nodes of a simulation that are discrete and lead on by flights, to rest.
std::vector<std::uint32_t> simple_endings(const Nodes& nodes, std::uint32_t count) {
  std::vector<std::uint32_t> firsts;
  for (std::uint32_t i = 0; i + count <= nodes.size(); ++i) {
    bool good = (nodes.flags[i + count - 1] & (kTerminal | kDubious)) == kTerminal;
    for (std::uint32_t k = 0; good && k < count; ++k)
      good = nodes.simulation[i + k] == nodes.simulation[i] && (nodes.flags[i + k] & kDubious) == 0 &&
             nodes.length_s[i + k] == 0.0f;
    if (good) firsts.push_back(i);
  }
  return firsts;
}

TEST_F(Realising, ASimulationsOwnMarksAreMetByItself) {
  const auto firsts = simple_endings(database_->nodes(), 5);
  ASSERT_GT(firsts.size(), 20u);
  for (std::size_t n = 0; n < 20; ++n) {
    const Marks marks = marks_of(firsts[n], 5);
    const Solution s = solve_graph(*graph_, marks, {}, nullptr);
    EXPECT_TRUE(s.plausible);
    EXPECT_NEAR(s.score, 1.0, 1e-6);  // the marks are sums of float32 seconds
    for (const EventReport& e : s.events) EXPECT_LT(e.excess, 1e-9);
    EXPECT_NEAR(s.search_log_weight, 0.0, 1e-6);
  }
}

// Every splice of the first transitions, realised: the flight begins where its event leaves and ends in the
// image of the pose that the other flight ended in.
TEST_F(Realising, ASpliceEndsInThePoseItAimsAt) {
  const Nodes& nodes = database_->nodes();
  const Transitions& t = graph_->transitions();
  const Realiser realiser(*database_, database_->physics(), graph_->images());
  int flown = 0, mirrored = 0;
  for (std::uint32_t i = 1; i < nodes.size() && flown < 200; ++i) {
    if (nodes.simulation[i - 1] != nodes.simulation[i] || (nodes.flags[i - 1] & (kEdge | kDubious)) != kEdge)
      continue;
    for (std::uint64_t m = t.first[i]; m < t.first[i + 1] && m < t.first[i] + 2; ++m) {
      const GraphPath path{{{i - 1, 0, false}, {i, 0, false}, {t.target[m], t.element[m], true}}, 0.0, 0.0};
      Marks marks = marks_of(i - 1, 2);
      marks.times_s.push_back(marks.times_s[1] + nodes.delay_s[i] + nodes.flight_s[t.target[m] - 1]);
      marks.durations_s.push_back(0.0);
      marks.centroids_s.push_back(std::nan(""));
      marks.amplitudes.clear();
      std::fill(marks.durations_s.begin(), marks.durations_s.end(), 0.0);
      marks.ending = Ending::open;
      const Realised r = realiser.realise(path, Targets(marks));
      if (r.failed_step) continue;
      ++flown;
      mirrored += !graph_->images()[t.element[m]].proper;
      const Onset& landed = r.found.links[2].onset;
      // Modulo heading and place, the pose is that of the target's own onset under the image: height and up.
      const State own = onset_of(nodes, t.target[m]);
      EXPECT_NEAR(landed.before.position.z(), own.position.z(), 1e-9);
      const Vec3 up = landed.before.orientation.conjugate() * kUp;
      const Vec3 aimed = graph_->images()[t.element[m]].map * (own.orientation.conjugate() * kUp);
      EXPECT_LT((up - aimed).norm(), 1e-8);  // 1e-10 rad of the connection, 1e-9 s of the landing's time
      // And no energy is gained on the way.
      const Link& link = r.found.links[1];
      EXPECT_LE(kinetic_energy(database_->body(), link.leave.after),
                kinetic_energy(database_->body(), link.onset.before) * (1.0 + 1e-12));
    }
  }
  EXPECT_EQ(flown, 200);
  EXPECT_GT(mirrored, 20);
}

TEST_F(Realising, HeldOutThrowsAreSolvedAndTheBoundHolds) {
  std::vector<State> starts(60);
  sample_states(die(), {}, 4242, 0, starts, 1);
  int solved = 0, tried = 0;
  for (const State& start : starts) {
    const Marks marks = signature_of(simulate(die(), start, {}, 30.0));
    if (marks.size() < 3 || marks.size() > 7) continue;
    ++tried;
    try {
      const Solution s = solve_graph(*graph_, marks, {}, nullptr);
      solved += s.succeeded;
      EXPECT_LE(s.search_log_weight, s.search_log_bound + 1e-3);  // float32 sums
    } catch (const NoMotionError&) {
    }
  }
  ASSERT_GT(tried, 5);
  EXPECT_GT(2 * solved, tried);  // of so small a database; nothing is known of the share but that it is large
}

TEST_F(Realising, TheSameBytesFromTheSameDatabase) {
  const Marks marks = signature_of(simulate(
      die(),
      [] {
        State s[1];
        sample_states(die(), {}, 99, 3, s, 1);
        return s[0];
      }(),
      {}, 30.0));
  const Solution a = solve_graph(*graph_, marks, {}, nullptr), b = solve_graph(*graph_, marks, {}, nullptr);
  const auto times = a.motion->dense_times();
  ASSERT_EQ(times, b.motion->dense_times());
  const auto x = a.motion->sample(times), y = b.motion->sample(times);
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_EQ(x[i].position, y[i].position);
}

TEST_F(Realising, WhatIsAskedWrongIsSaid) {
  GraphOptions options;
  options.rung = graph_rung_count();
  const Marks marks = marks_of(simple_endings(database_->nodes(), 2).at(0), 2);
  try {
    solve_graph(*graph_, marks, options, nullptr);
    FAIL();
  } catch (const ArgumentError& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, 5), "rung:");
  }
}

}  // namespace
}  // namespace ifa
