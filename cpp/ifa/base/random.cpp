#include "ifa/base/random.hpp"

#include <cmath>
#include <numbers>

namespace ifa {

std::array<std::uint32_t, 4> philox4x32_10(std::array<std::uint32_t, 4> c, std::array<std::uint32_t, 2> k) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = 0xD2511F53ull * c[0];
    const std::uint64_t p1 = 0xCD9E8D57ull * c[2];
    c = {static_cast<std::uint32_t>(p1 >> 32) ^ c[1] ^ k[0], static_cast<std::uint32_t>(p1),
         static_cast<std::uint32_t>(p0 >> 32) ^ c[3] ^ k[1], static_cast<std::uint32_t>(p0)};
    k[0] += 0x9E3779B9u;
    k[1] += 0xBB67AE85u;
  }
  return c;
}

std::uint64_t RandomStream::next() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const auto low = [](std::uint64_t x) { return static_cast<std::uint32_t>(x); };
  const auto high = [](std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); };
  const auto words =
      philox4x32_10({low(draw_), high(draw_), low(stream_), high(stream_)}, {low(seed_), high(seed_)});
  ++draw_;
  spare_ = (std::uint64_t{words[3]} << 32) | words[2];
  has_spare_ = true;
  return (std::uint64_t{words[1]} << 32) | words[0];
}

double RandomStream::uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

double RandomStream::normal() {  // Box and Muller; 1 - u is never 0
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

Vec3 RandomStream::unit_vector() {
  const double z = uniform(-1.0, 1.0);
  const double azimuth = 2.0 * std::numbers::pi * uniform();
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

Quat RandomStream::rotation() {
  const double u = uniform();
  const double a = 2.0 * std::numbers::pi * uniform(), b = 2.0 * std::numbers::pi * uniform();
  const double r = std::sqrt(1.0 - u), s = std::sqrt(u);
  return Quat(s * std::cos(b), r * std::sin(a), r * std::cos(a), s * std::sin(b));
}

}  // namespace ifa
