// Signatures at their limits: solved, or one clear sentence that names the mark, before anything is
// simulated.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "held.hpp"
#include "ifa/base/error.hpp"
#include "ifa/forward/solve.hpp"
#include "sample_bodies.hpp"
#include "sample_marks.hpp"

namespace ifa {
namespace {

using sample::cube;
using sample::marks_at;

// The smallest search: its work is bounded, whatever the clock says.
Solution solved(const Body& body, const Marks& marks) {
  SolveOptions options;
  options.rung = 0;
  return solve_forward(body, marks, options, nullptr);
}

// What is wrong with the marks; progress tells that nothing was begun.
std::string complaint(const Marks& marks) {
  Progress progress;
  try {
    solve_forward(cube(), marks, {}, &progress);
  } catch (const ArgumentError& error) {
    EXPECT_EQ(progress.fraction(), 0.0);
    return error.what();
  }
  return "solved";
}

TEST(HardCase26, OneMark) {
  for (const Ending ending : {Ending::open, Ending::rest}) {
    const Solution s = solved(cube(), marks_at({0.4}, ending));
    EXPECT_TRUE(s.plausible);
    EXPECT_EQ(s.events[0].achieved_s, 0.4);
  }
}

TEST(HardCase26, TwoMarksAMicrosecondApart) {
  const std::string expected = "mark 2 (0.300001 s) is only 0.001 ms after mark 1 (0.30 s)";
  EXPECT_EQ(complaint(marks_at({0.3, 0.3 + 1e-6}, Ending::open)).substr(0, expected.size()), expected);
  EXPECT_EQ(complaint(marks_at({0.3, 0.3}, Ending::open)),
            "mark 2 (0.30 s) is at the same time as mark 1 (0.30 s)");
}

TEST(HardCase26, MarksOutOfOrder) {
  EXPECT_EQ(complaint(marks_at({0.2, 0.5, 0.4, 0.7}, Ending::rest)).substr(0, 45),
            "mark 3 (0.40 s) comes before mark 2 (0.50 s):");
}

TEST(HardCase26, NotANumberAndInfinity) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinite = HUGE_VAL;
  for (const double bad : {kNan, kInfinite, -kInfinite}) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string name = "mark " + std::to_string(k + 1);
      for (auto field : {&Marks::times_s, &Marks::durations_s, &Marks::amplitudes, &Marks::centroids_s}) {
        Marks marks = marks_at({0.2, 0.4, 0.6}, Ending::open);
        marks.amplitudes = {1.0, 0.8, 0.6};
        (marks.*field)[k] = bad;
        if (field == &Marks::centroids_s && std::isnan(bad)) continue;  // unknown
        EXPECT_EQ(complaint(marks).substr(0, name.size()), name);
      }
    }
  }
}

// A ball that loses nothing bounces every 0.2 s for ever.
TEST(HardCase26, FiveHundredMarks) {
  std::vector<double> times_s;
  for (int k = 0; k < 500; ++k) times_s.push_back(0.25 + 0.2 * k);
  const Body ball = sample::ball(0.02, 0.03, sample::ideal(1.0, 0.3));
  const Solution s = solved(ball, marks_at(times_s, Ending::open));
  EXPECT_TRUE(s.plausible);
  Held time("a mark, s after retiming", 1e-9), gap("an interval before retiming, relative", 1e-4);
  for (const EventReport& event : s.events) {
    time.see(std::abs(event.error_retimed_s));
    gap.see(std::abs(event.retime - 1.0));
  }
}

// A cube has no motion of 500 bounces: it is shown as far as it gets.
TEST(HardCase26, FiveHundredMarksThatNothingMeets) {
  std::vector<double> times_s;
  for (int k = 0; k < 500; ++k) times_s.push_back(0.25 + 0.2 * k);
  const Solution s = solved(cube(), marks_at(times_s, Ending::rest));
  EXPECT_FALSE(s.succeeded);
  EXPECT_GT(s.missed_hits, 450);
  ASSERT_EQ(s.events.size(), 500u);
  EXPECT_LT(s.motion->end_s(), 100.0);
}

// A minute of flight, 441 m high; and a minute after which nothing can move any more.
TEST(HardCase26, APauseOfAMinute) {
  const Solution flight = solved(cube(), marks_at({0.3, 60.3}, Ending::open));
  EXPECT_TRUE(flight.plausible);
  const State top = flight.motion->sample({30.3})[0];
  Held height("apex of the flight against g T^2 / 8, relative", 1e-4);  // what retiming hides, twice
  height.see(std::abs(top.position.z() / (sample::kGravity * 60.0 * 60.0 / 8.0) - 1.0));

  const Solution still = solved(cube(), marks_at({0.3, 0.45, 60.45}, Ending::rest));
  EXPECT_FALSE(still.succeeded);
  EXPECT_EQ(still.missed_hits, 1);
  EXPECT_EQ(still.events[1].achieved_s, 0.45);
  EXPECT_LT(still.events[2].achieved_s, 50.0);
}

}  // namespace
}  // namespace ifa
