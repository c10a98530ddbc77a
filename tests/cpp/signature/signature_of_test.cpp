#include "ifa/signature/signature_of.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "ifa/base/error.hpp"

namespace ifa {
namespace {

Hit hit(double time_s, double impulse_n_s, double speed_m_s = 1.0) {
  Hit h;
  h.time_s = time_s;
  h.impulse_n_s = impulse_n_s * Vec3(0.0, 0.6, 0.8);
  h.approach_speed_m_s = speed_m_s;
  return h;
}

Run run_of(std::vector<Hit> hits, RunStatus status = RunStatus::rest) {
  Run run;
  run.status = status;
  run.hits = std::move(hits);
  return run;
}

TEST(SignatureOf, ChainsHitsIntoMarks) {
  // A single hit, a chain of 8 ms (discrete), a chain of 24 ms, which two silent hits do not lengthen.
  const auto run = run_of({hit(0.0, 2.0), hit(0.1, 3.0), hit(0.108, 4.0), hit(0.2, 1.0), hit(0.208, 2.0),
                           hit(0.216, 2.0), hit(0.22, 9.0, 0.049), hit(0.224, 1.0), hit(0.23, 9.0, 0.01)});
  const Marks marks = signature_of(run);
  EXPECT_EQ(marks.times_s, (std::vector{0.0, 0.1, 0.2}));
  ASSERT_EQ(marks.durations_s.size(), 3u);
  EXPECT_EQ(marks.durations_s[0], 0.0);
  EXPECT_EQ(marks.durations_s[1], 0.0);
  EXPECT_NEAR(marks.durations_s[2], 0.024, 1e-16);  // rounding of 0.224 - 0.2
  ASSERT_EQ(marks.amplitudes.size(), 3u);
  EXPECT_NEAR(marks.amplitudes[0], 2.0, 1e-15);  // rounding
  EXPECT_NEAR(marks.amplitudes[1], 5.0, 1e-15);  // 3, 4, 5
  EXPECT_NEAR(marks.amplitudes[2], std::sqrt(1.0 + 4.0 + 4.0 + 1.0), 1e-15);
  ASSERT_EQ(marks.centroids_s.size(), 3u);
  EXPECT_TRUE(std::isnan(marks.centroids_s[0]));
  EXPECT_TRUE(std::isnan(marks.centroids_s[1]));  // of no use where there is no span
  EXPECT_NEAR(marks.centroids_s[2], (2.0 * 0.008 + 2.0 * 0.016 + 0.024) / 6.0, 1e-16);
  EXPECT_NO_THROW(validate(marks));
}

TEST(SignatureOf, AnEventThatFollowsAChainAtOnceIsValid) {
  // Chained up to the gap itself, which does not chain: the next mark is as near to a span's end as can be.
  std::vector<Hit> hits;
  for (int i = 0; i < 6; ++i) hits.push_back(hit(0.3 + 0.0099 * i, 1.0));
  hits.push_back(hit(hits.back().time_s + kMergeGap_s, 1.0));
  const Marks marks = signature_of(run_of(hits));
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_EQ(marks.times_s[1], hits.back().time_s);
  EXPECT_NO_THROW(validate(marks));
}

TEST(SignatureOf, HearingIsAnOption) {
  const auto run = run_of({hit(0.0, 1.0, 0.2), hit(0.02, 1.0, 0.1), hit(0.04, 1.0, 0.2)});
  EXPECT_EQ(signature_of(run, {Events::audible, 0.05, 0.010}).times_s, (std::vector{0.0, 0.02, 0.04}));
  EXPECT_EQ(signature_of(run, {Events::audible, 0.05, 0.030}).times_s, (std::vector{0.0}));
  EXPECT_EQ(signature_of(run, {Events::audible, 0.15, 0.010}).times_s, (std::vector{0.0, 0.04}));
}

TEST(SignatureOf, EndsInRestWhereTheRunDoes) {
  EXPECT_EQ(signature_of(run_of({hit(0.0, 1.0)}, RunStatus::rest)).ending, Ending::rest);
  for (const RunStatus status : {RunStatus::time_limit, RunStatus::impact_limit, RunStatus::failed})
    EXPECT_EQ(signature_of(run_of({hit(0.0, 1.0)}, status)).ending, Ending::open);
}

TEST(SignatureOf, ASilentRunHasNone) {
  for (const auto& run : {run_of({}), run_of({hit(0.0, 1.0, 0.049), hit(0.1, 1.0, 0.01)})}) {
    try {
      signature_of(run);
      FAIL();
    } catch (const ArgumentError& error) {
      const std::string expected = "run: none of its " + std::to_string(run.hits.size()) + " hits is audible";
      EXPECT_EQ(std::string(error.what()).substr(0, expected.size()), expected);
    }
  }
}

}  // namespace
}  // namespace ifa
