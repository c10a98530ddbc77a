#include "ifa/motion/sampling.hpp"

#include <cmath>

#include "ifa/base/parallel.hpp"

namespace ifa {

State sample_touching(const Body& body, RandomStream& random) {
  State s;
  s.orientation = random.rotation();
  s.position.z() = -lowest_gap_m(body, s);
  return s;
}

Vec3 sample_downward(double cone_rad, RandomStream& random) {
  // cosine-weighted within the cone: sin^2 of the angle is uniform
  const double sine = std::sin(cone_rad) * std::sqrt(random.uniform());
  const double azimuth = 2.0 * std::numbers::pi * random.uniform();
  return {sine * std::cos(azimuth), sine * std::sin(azimuth), -std::sqrt(1.0 - sine * sine)};
}

void sample_states(const Body& body, const SamplingOptions& options, std::uint64_t seed, std::uint64_t first,
                   std::span<State> out, int threads, const Progress* progress) {
  const auto sample = [&](std::size_t k) {
    RandomStream random(seed, first + k);
    State s = sample_touching(body, random);
    const Vec3 direction = sample_downward(options.cone_rad, random);
    s.velocity = random.uniform(options.least_speed_m_s, options.most_speed_m_s) * direction;
    const Vec3 axis = random.unit_vector();
    s.angular_velocity = random.uniform(options.least_spin_rad_s, options.most_spin_rad_s) * axis;
    out[k] = s;
  };
  parallel_for(out.size(), threads, sample, progress);
}

}  // namespace ifa
