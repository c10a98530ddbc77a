// An effect that a scene does not call for changes no bit of its results: the engine as it is against one
// that has never heard of it.
#include <gtest/gtest.h>

#include <cstring>

#include "ifa/base/error.hpp"
#include "ifa/rigid/flight.hpp"
#include "sample_bodies.hpp"
#include "trace.hpp"

namespace ifa_plain {

std::vector<double> trace();
bool refuses_what_it_has_not();

}  // namespace ifa_plain

namespace ifa {
namespace {

TEST(EffectsOut, SameBitsWhereTheyAreNotCalledFor) {
  const std::vector<double> with = trace(), without = ifa_plain::trace();
  ASSERT_GT(with.size(), 10000u);
  ASSERT_EQ(with.size(), without.size());
  EXPECT_EQ(std::memcmp(with.data(), without.data(), with.size() * sizeof(double)), 0);
}

// Or the comparison above would be one of a thing with itself.
TEST(EffectsOut, TheOtherBuildHasNone) { EXPECT_TRUE(ifa_plain::refuses_what_it_has_not()); }

}  // namespace
}  // namespace ifa
