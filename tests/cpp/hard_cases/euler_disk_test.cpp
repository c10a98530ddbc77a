// Hard case 16: circular edges. A disk rolls, precesses and lands as a disk, not as a polygon.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "held.hpp"
#include "ifa/rigid/flight.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::kGravity;

constexpr double kRadius = 0.0375, kMass = 0.44;  // of the toy "Euler's disk"

// Uniform and thin, its axis z.
Body thin_disk(const Material& material) {
  Body::Definition d;
  d.rings_m = {{Vec3::Zero(), kUp, kRadius}};
  d.mass_kg = kMass;
  d.inertia_kg_m2 = (kMass * kRadius * kRadius * Vec3(0.25, 0.25, 0.5)).asDiagonal();
  d.material = material;
  return Body::make(d);
}

// Steady rolling about a centre of mass at rest: the disk, inclined by `tilt`, turns about its steepest
// diameter, which precesses at W with W^2 sin(tilt) = 4 g / R.
State steady(double tilt, double& precession) {
  precession = std::sqrt(4.0 * kGravity / (kRadius * std::sin(tilt)));
  State s;
  s.orientation = Quat(Eigen::AngleAxisd(tilt, Vec3::UnitY()));
  s.position.z() = kRadius * std::sin(tilt);
  s.angular_velocity = -precession * std::sin(tilt) * (s.orientation * Vec3::UnitX());
  return s;
}

TEST(HardCase16, SteadyPrecession) {
  Held rate("precession over 5 turns against sqrt(4 g / (R sin tilt)), of it", 0.01);
  Held lean("tilt, of it", 0.01);
  const Body disk = thin_disk(sample::ideal(0.0, 1e3));
  for (const double tilt : {1.2, 0.8, 0.4, 0.1, 0.03}) {
    double precession = 0.0;
    EventSimulation simulation(disk, {});
    simulation.start(steady(tilt, precession), 0.0);
    const double period = 2.0 * std::numbers::pi / precession;
    double turned = 0.0, last = 0.0;
    constexpr int kTurns = 5, kLooks = 32;
    for (int i = 1; i <= kTurns * kLooks; ++i) {
      ASSERT_EQ(simulation.advance(i * period / kLooks), EventSimulation::Stop::time_limit)
          << tilt << " " << i;
      const Vec3 axis = simulation.state().orientation * kUp;
      const double heading = std::atan2(axis.y(), axis.x());
      turned += std::remainder(heading - last, 2.0 * std::numbers::pi);
      last = heading;
      lean.see(std::abs(std::atan2(axis.head<2>().norm(), axis.z()) / tilt - 1.0), tilt, i);
    }
    rate.see(std::abs(turned / (2.0 * std::numbers::pi * kTurns) - 1.0), tilt);
  }
}

}  // namespace
}  // namespace ifa
