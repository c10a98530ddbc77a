// Counter-based random numbers: Philox4x32-10 (Salmon et al. 2011, "Parallel random numbers: as
// easy as 1, 2, 3"). A draw depends only on (seed, stream, draw), so results are the same for any
// number of threads, any order and any batch size.
#pragma once

#include <array>
#include <cstdint>

#include "ifa/base/linear_algebra.hpp"

namespace ifa {

std::array<std::uint32_t, 4> philox4x32_10(std::array<std::uint32_t, 4> counter,
                                           std::array<std::uint32_t, 2> key);

// One independent stream of draws. Cheap to make: make one for each sample.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream) : seed_(seed), stream_(stream) {}

  double uniform();  // in [0, 1), 53 bits
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double normal();     // mean 0, variance 1
  Vec3 unit_vector();  // uniform on the sphere
  Quat rotation();     // uniform on SO(3) (Shoemake 1992)

 private:
  std::uint64_t next();

  std::uint64_t seed_, stream_, draw_ = 0;
  std::uint64_t spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace ifa
