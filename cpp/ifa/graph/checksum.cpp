#include "ifa/graph/checksum.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace ifa {
namespace {

static_assert(std::endian::native == std::endian::little, "files hold numbers as they are in memory");

template <class T>
T load(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

}  // namespace

void Checksum::mix(const std::byte* stripe) {
  for (std::size_t i = 0; i < 4; ++i) {
    const std::uint64_t lane = lanes_[i] + load<std::uint64_t>(stripe + 8 * i) * kPrime2;
    lanes_[i] = std::rotl(lane, 31) * kPrime1;
  }
}

void Checksum::add(std::span<const std::byte> bytes) {
  length_ += bytes.size();
  if (resting_ > 0) {
    const std::size_t taken = std::min(kStripe - resting_, bytes.size());
    std::copy_n(bytes.begin(), taken, rest_.begin() + static_cast<std::ptrdiff_t>(resting_));
    resting_ += taken;
    bytes = bytes.subspan(taken);
    if (resting_ < kStripe) return;
    mix(rest_.data());
    resting_ = 0;
  }
  for (; bytes.size() >= kStripe; bytes = bytes.subspan(kStripe)) mix(bytes.data());
  std::ranges::copy(bytes, rest_.begin());
  resting_ = bytes.size();
}

std::uint64_t Checksum::value() const {
  std::uint64_t sum = kPrime5;
  if (length_ >= kStripe) {
    sum = std::rotl(lanes_[0], 1) + std::rotl(lanes_[1], 7) + std::rotl(lanes_[2], 12) +
          std::rotl(lanes_[3], 18);
    for (const std::uint64_t lane : lanes_)
      sum = (sum ^ (std::rotl(lane * kPrime2, 31) * kPrime1)) * kPrime1 + kPrime4;
  }
  sum += length_;
  const std::byte* at = rest_.data();
  std::size_t left = resting_;
  for (; left >= 8; at += 8, left -= 8) {
    sum ^= std::rotl(load<std::uint64_t>(at) * kPrime2, 31) * kPrime1;
    sum = std::rotl(sum, 27) * kPrime1 + kPrime4;
  }
  if (left >= 4) {
    sum ^= load<std::uint32_t>(at) * kPrime1;
    sum = std::rotl(sum, 23) * kPrime2 + kPrime3;
    at += 4, left -= 4;
  }
  for (; left > 0; ++at, --left) {
    sum ^= std::to_integer<std::uint64_t>(*at) * kPrime5;
    sum = std::rotl(sum, 11) * kPrime1;
  }
  sum = (sum ^ (sum >> 33)) * kPrime2;
  sum = (sum ^ (sum >> 29)) * kPrime3;
  return sum ^ (sum >> 32);
}

std::uint64_t checksum(std::span<const std::byte> bytes) {
  Checksum sum;
  sum.add(bytes);
  return sum.value();
}

}  // namespace ifa
