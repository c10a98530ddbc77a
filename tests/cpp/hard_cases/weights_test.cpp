// Weights of transitions where what they divide by vanishes.
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>

#include "held.hpp"
#include "ifa/graph/weights.hpp"

namespace ifa {
namespace {

TakeOffView take_off(const Vec3& velocity, const Vec3& spin) {
  return {Vec3(0.36, 0.48, 0.8), velocity, spin, 0.01};
}

TEST(HardCase24, EqualStatesWeighOne) {
  Held held("1 - f", 1e-15);
  for (const double dv : {0.0, 1e-300, 1e-12, 1.0})
    for (const double dw : {0.0, 1e-300, 1e-12, 30.0})
      for (const double flight_s : {1e-300, 1e-9, 1e-3, 1.0}) {
        const TakeOffView s = take_off({0.1, -0.7, 1.3}, {3.0, -20.0, 7.0});
        const PlausibleRegion region(Vec3(0.0, dv, 0.0), Vec3(dw, 0.0, 0.0), 0.01);
        const Splice equal = splice(s, region, s, flight_s);
        held.see(1.0 - std::exp(equal.log_weight()), "dv", dv, "dw", dw, "T", flight_s);
      }
}

TEST(HardCase24, VanishingChangesAndFlightsStayFinite) {
  Held held("not a number, or above 1", 0.0);
  for (const double dv : {0.0, 1e-300, 1e-12, 1.0})
    for (const double dw : {0.0, 1e-300, 1e-12, 30.0})
      for (const double flight_s : {1e-9, 1e-6, 1e-3, 1.0})
        for (const double apart : {0.0, 1e-300, 1e-9, 1.0}) {
          const TakeOffView i = take_off({0.1, -0.7, 1.3}, {3.0, -20.0, 7.0});
          TakeOffView j = take_off({0.1 + apart, -0.7, 1.3}, {3.0, -20.0 - apart, 7.0});
          if (apart == 1.0) j.up = -i.up;  // upside down: half a turn about no axis in particular
          const PlausibleRegion region(Vec3(0.0, dv, 0.0), Vec3(dw, 0.0, 0.0), 0.01);
          const Splice s = splice(i, region, j, flight_s);
          const double f = std::exp(s.log_weight());
          const bool good = std::isfinite(s.excess) && std::isfinite(s.angle_rad) && f >= 0.0 && f <= 1.0;
          held.see(good ? 0.0 : 1.0, "dv", dv, "dw", dw, "T", flight_s, "apart", apart);
        }
}

}  // namespace
}  // namespace ifa
