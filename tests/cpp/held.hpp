// Tolerances that are printed with what was measured, and numbers of random trials, for the hard cases.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <string>

namespace ifa {

// The largest error seen in a test against the tolerance asked for. At its end it prints one line, of which
// docs/hard_cases.md is made, and fails the test if the tolerance did not hold or nothing was seen.
class Held {
 public:
  Held(std::string quantity, double asked) : quantity_(std::move(quantity)), asked_(asked) {}
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

  template <class... Where>
  void see(double error, const Where&... where) {
    if (std::isnan(error)) error = std::numeric_limits<double>::infinity();
    seen_ = true;
    if (!(error > worst_)) return;
    worst_ = error;
    std::ostringstream text;
    ((text << " " << where), ...);
    where_ = text.str();
  }

  ~Held() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    std::printf("[   held   ] %s.%s | %s | asked %.1e | held %.1e\n", test->test_suite_name(), test->name(),
                quantity_.c_str(), asked_, worst_);
    EXPECT_TRUE(seen_) << quantity_ << ": nothing was measured";
    EXPECT_LE(worst_, asked_) << quantity_ << ", worst at" << where_;
  }

 private:
  std::string quantity_, where_;
  double asked_, worst_ = 0.0;
  bool seen_ = false;
};

// Of `full` random trials, a share: `usual_share`, so that all tests take minutes, or what the environment
// variable IFA_HARD_CASES_SHARE says (1: all of them, as `make hard-cases` does).
inline int trials(int full, double usual_share) {
  const char* wanted = std::getenv("IFA_HARD_CASES_SHARE");
  const double share = wanted ? std::atof(wanted) : usual_share;
  return std::max(1, static_cast<int>(full * std::clamp(share, 0.0, 1.0)));
}

}  // namespace ifa
