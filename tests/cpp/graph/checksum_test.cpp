#include "ifa/graph/checksum.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ifa {
namespace {

std::uint64_t sum_of(const std::string& text) { return checksum(std::as_bytes(std::span(text))); }

// Published sums of XXH64 with seed 0; the last text is longer than a stripe of 32 bytes.
TEST(Checksum, IsXxh64) {
  EXPECT_EQ(sum_of(""), 0xEF46DB3751D8E999u);
  EXPECT_EQ(sum_of("a"), 0xD24EC4F1A98C6E5Bu);
  EXPECT_EQ(sum_of("abc"), 0x44BC2CF5AD770999u);
  EXPECT_EQ(sum_of("Nobody inspects the spammish repetition"), 0xFBCEA83C8A378BF1u);
}

TEST(Checksum, DoesNotDependOnPieces) {
  std::string text;
  for (int i = 0; i < 200; ++i) text += static_cast<char>(37 * i);
  const auto bytes = std::as_bytes(std::span(text));
  for (std::size_t first = 0; first <= text.size(); first += 7)
    for (std::size_t second = first; second <= text.size(); second += 13) {
      Checksum sum;
      sum.add(bytes.first(first));
      sum.add(bytes.subspan(first, second - first));
      sum.add(bytes.subspan(second));
      ASSERT_EQ(sum.value(), checksum(bytes)) << first << " " << second;
    }
}

TEST(Checksum, SeesEveryBit) {
  std::vector<std::byte> bytes(77);
  const std::uint64_t sum = checksum(bytes);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= std::byte{1} << bit % 8;
    EXPECT_NE(checksum(bytes), sum) << bit;
    bytes[bit / 8] ^= std::byte{1} << bit % 8;
  }
}

}  // namespace
}  // namespace ifa
