#include "ifa/base/progress.hpp"

#include <gtest/gtest.h>

namespace ifa {
namespace {

TEST(Progress, OfAPartRaisesTheWholeAndNeverLowersIt) {
  Progress whole;
  Progress first(&whole, 0.0, 0.5), second(&whole, 0.5, 1.0);
  first.raise_to(0.5);
  EXPECT_EQ(whole.fraction(), 0.25);
  second.raise_to(0.5);
  EXPECT_EQ(whole.fraction(), 0.75);
  first.raise_to(1.0);
  EXPECT_EQ(first.fraction(), 1.0);
  EXPECT_EQ(whole.fraction(), 0.75);
}

TEST(Progress, CancellingTheWholeCancelsItsParts) {
  Progress whole;
  Progress part(&whole, 0.0, 0.5), within(&part, 0.0, 1.0), alone(nullptr, 0.0, 1.0);
  EXPECT_FALSE(within.cancelled());
  whole.cancel();
  EXPECT_THROW(within.throw_if_cancelled(), Cancelled);
  alone.raise_to(0.5);
  EXPECT_FALSE(alone.cancelled());
  EXPECT_EQ(alone.fraction(), 0.5);
}

TEST(Progress, CancellingAPartLeavesTheWhole) {
  Progress whole;
  Progress part(&whole, 0.0, 0.5);
  part.cancel();
  EXPECT_TRUE(part.cancelled());
  EXPECT_FALSE(whole.cancelled());
}

}  // namespace
}  // namespace ifa
