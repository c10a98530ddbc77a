// Starts as the paper samples them (section 5.1).
#pragma once

#include "sample_bodies.hpp"

namespace ifa::sample {

// Touching the ground in any orientation; downwards within 30 degrees with a density by the cosine, 0.5 to 4
// m/s; spin of up to 20 rad/s about any axis.
inline State paper_start(const Body& body, std::uint64_t sample) {
  RandomStream random(1, sample);
  State s;
  s.orientation = random.rotation();
  s.position.z() = -lowest(body, s);
  const double cosine = std::sqrt(1.0 - 0.25 * random.uniform());  // sin^2(30 degrees)
  const double sine = std::sqrt(1.0 - cosine * cosine), heading = 2.0 * std::numbers::pi * random.uniform();
  s.velocity = random.uniform(0.5, 4.0) * Vec3(sine * std::cos(heading), sine * std::sin(heading), -cosine);
  s.angular_velocity = random.uniform(0.0, 20.0) * random.unit_vector();
  return s;
}

}  // namespace ifa::sample
