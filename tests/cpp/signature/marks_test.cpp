#include "ifa/signature/marks.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "ifa/base/error.hpp"

namespace ifa {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

Marks at(std::vector<double> times_s) {
  Marks marks;
  marks.times_s = std::move(times_s);
  marks.durations_s.assign(marks.size(), 0.0);
  marks.centroids_s.assign(marks.size(), kNan);
  return marks;
}

// The message that validate throws; empty if it throws none.
std::string complaint(const Marks& marks, double merge_gap_s = kMergeGap_s) {
  try {
    validate(marks, merge_gap_s);
  } catch (const ArgumentError& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

#define EXPECT_COMPLAINT(marks, part) EXPECT_PRED2(contains, complaint(marks), part)

TEST(Marks, OneMarkIsEnough) {
  EXPECT_EQ(complaint(at({0.0})), "");
  EXPECT_EQ(complaint(at({0.35})), "");
}

TEST(Marks, ManyMarksAndLongPausesAreFine) {
  std::vector<double> times_s;
  for (int k = 0; k < 500; ++k) times_s.push_back(0.010 * k);  // each at the merge gap
  times_s.push_back(65.0);
  EXPECT_EQ(complaint(at(times_s)), "");
}

TEST(Marks, NoMarks) { EXPECT_COMPLAINT(at({}), "no marks"); }

TEST(Marks, OutOfOrderNamesBoth) {
  EXPECT_COMPLAINT(at({0.1, 0.2, 0.4, 0.31}), "mark 4 (0.31 s) comes before mark 3 (0.40 s)");
}

TEST(Marks, SameTimeNamesBoth) {
  EXPECT_COMPLAINT(at({0.1, 0.2, 0.2}), "mark 3 (0.20 s) is at the same time as mark 2 (0.20 s)");
}

TEST(Marks, TooCloseNamesBothToTheMicrosecond) {
  const std::string message = complaint(at({0.5, 0.500001}));
  EXPECT_PRED2(contains, message, "mark 2 (0.500001 s)");
  EXPECT_PRED2(contains, message, "mark 1 (0.50 s)");
  EXPECT_PRED2(contains, message, "10 ms");
}

TEST(Marks, TheMergeGapIsTheCallers) {
  EXPECT_EQ(complaint(at({0.5, 0.504}), 0.004), "");
  EXPECT_NE(complaint(at({0.5, 0.504}), 0.0041), "");
  EXPECT_NE(complaint(at({0.5, 0.529}), 0.030), "");
  EXPECT_EQ(complaint(at({0.5, 0.500001}), 0.0), "");
  EXPECT_PRED2(contains, complaint(at({0.5}), -0.01), "merge_gap_s");
  EXPECT_PRED2(contains, complaint(at({0.5}), kNan), "merge_gap_s");
}

// Each pair of hundredths is 10 ms apart in decimals, and about half of them less than that in binary.
TEST(Marks, ExactlyTheMergeGapIsAllowedAtEveryHundredth) {
  int below = 0;
  for (int i = 0; i < 1000; ++i) {
    const double first = i / 100.0, second = (i + 1) / 100.0;
    below += second - first < 0.01;
    EXPECT_EQ(complaint(at({first, second})), "");
  }
  EXPECT_GT(below, 0);  // or the loop proves nothing
}

TEST(Marks, TimesMustBeFiniteAndNotNegative) {
  EXPECT_COMPLAINT(at({0.1, kNan}), "mark 2 (nan s)");
  EXPECT_COMPLAINT(at({0.1, kInf}), "mark 2 (inf s)");
  EXPECT_COMPLAINT(at({-0.25, 0.1}), "mark 1 (-0.25 s): lies before the start");
}

TEST(Marks, ASpanMayTouchTheNextMarkButNotHoldIt) {
  Marks marks = at({0.1, 0.3});
  marks.durations_s = {0.3 - 0.1, 0.0};
  EXPECT_EQ(complaint(marks), "");
  marks.durations_s = {0.2001, 0.0};
  EXPECT_COMPLAINT(marks,
                   "mark 2 (0.30 s) starts inside the span of mark 1 (0.10 s), which ends at 0.3001 s");
}

TEST(Marks, DurationsMustBeFiniteAndNotNegative) {
  Marks marks = at({0.1, 0.3, 0.5});
  for (const double bad : {-0.01, kNan, kInf}) {
    for (std::size_t k = 0; k < 3; ++k) {
      marks.durations_s.assign(3, 0.0);
      marks.durations_s[k] = bad;
      EXPECT_COMPLAINT(marks, "mark " + std::to_string(k + 1) + " (0." + "135"[k] + "0 s): its duration");
    }
  }
}

TEST(Marks, AmplitudesMustBeFiniteAndNotNegative) {
  Marks marks = at({0.1, 0.3});
  for (const double bad : {-0.5, kNan, kInf}) {
    marks.amplitudes = {1.0, bad};
    EXPECT_COMPLAINT(marks, "mark 2 (0.30 s): its amplitude") << bad;
  }
  marks.amplitudes = {1.0, 0.0};
  EXPECT_EQ(complaint(marks), "");
}

TEST(Marks, TheFirstAmplitudeIsTheReference) {
  Marks marks = at({0.1, 0.3});
  marks.amplitudes = {0.0, 1.0};
  EXPECT_COMPLAINT(marks, "mark 1 (0.10 s): its amplitude is 0");
}

TEST(Marks, CentroidsLieInTheirSpan) {
  Marks marks = at({0.1, 0.3});
  marks.durations_s = {0.0, 0.2};
  for (const double good : {0.0, 0.1, 0.2}) {
    marks.centroids_s = {kNan, good};
    EXPECT_EQ(complaint(marks), "") << good;
  }
  for (const double bad : {-0.01, 0.21, kInf}) {
    marks.centroids_s = {kNan, bad};
    EXPECT_COMPLAINT(marks, "mark 2 (0.30 s): its centroid") << bad;
  }
}

TEST(Marks, EveryListHasOneValueForEachMark) {
  Marks durations = at({0.1, 0.3}), amplitudes = at({0.1, 0.3}), centroids = at({0.1, 0.3});
  durations.durations_s = {0.0};
  amplitudes.amplitudes = {1.0, 0.5, 0.2};
  centroids.centroids_s = {};
  EXPECT_COMPLAINT(durations, "durations_s: needs one value for each of the 2 marks, got 1");
  EXPECT_COMPLAINT(amplitudes, "amplitudes: needs one value for each of the 2 marks, got 3");
  EXPECT_COMPLAINT(centroids, "centroids_s: needs one value for each of the 2 marks, got 0");
}

}  // namespace
}  // namespace ifa
