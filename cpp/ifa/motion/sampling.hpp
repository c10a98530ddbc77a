// Random states just before a contact (paper section 5.1).
#pragma once

#include <cstdint>
#include <numbers>
#include <span>

#include "ifa/base/progress.hpp"
#include "ifa/base/random.hpp"
#include "ifa/rigid/state.hpp"

namespace ifa {

struct SamplingOptions {
  double cone_rad =
      std::numbers::pi / 6.0;  // about straight down, at most pi / 2; 80 degrees suit what rolls
  double least_speed_m_s = 0.5, most_speed_m_s = 4.0;     // uniform between these
  double least_spin_rad_s = 0.0, most_spin_rad_s = 20.0;  // likewise; its direction is uniform too
};

// Any orientation, pushed into contact at its lowest point, and still. Principal axes.
State sample_touching(const Body& body, RandomStream& random);

// A unit vector cosine-weighted within a cone about straight down.
Vec3 sample_downward(double cone_rad, RandomStream& random);

// `out[k]` is sample `first + k` of the seed and depends on nothing else: not on how many are asked for at
// once, nor on the threads. Principal axes. A large body may spin so fast that its lowest point leaves.
void sample_states(const Body& body, const SamplingOptions& options, std::uint64_t seed, std::uint64_t first,
                   std::span<State> out, int threads, const Progress* progress = nullptr);

}  // namespace ifa
