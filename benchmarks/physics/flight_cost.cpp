// What a flight costs: its start and the pose at its end, 0.3 s later, with the error beside the time. Prints
// CSV.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "ifa/base/random.hpp"
#include "ifa/rigid/flight.hpp"

namespace {

using namespace ifa;

struct Case {
  std::string name;
  Vec3 moments;
};

Body body_of(const Case& c) {
  Body::Definition d;
  d.name = c.name;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) d.vertices_m.push_back(0.01 * Vec3(x, y, z));
  d.mass_kg = 0.01;
  d.inertia_kg_m2 = 1e-6 * Mat3(c.moments.asDiagonal());
  return Body::make(d);
}

double angle(const Quat& a, const Quat& b) { return 2.0 * (a.conjugate() * b).vec().norm(); }

}  // namespace

int main() {
  constexpr double kLength_s = 0.3;
  constexpr int kFlights = 2000, kRounds = 15;
  std::printf("body,spin_rad_s,us_per_flight,there_and_back_rad\n");
  for (const Case& c :
       {Case{"cube", {1, 1, 1}}, Case{"box 1:2:3", {5, 10, 13}}, Case{"eraser", {1.3, 6.5, 7.1}},
        Case{"card", {1.0, 2.5, 3.5}}, Case{"needle", {1e-4, 1, 1}}})
    for (const double spin : {5.0, 20.0, 100.0}) {
      const Body body = body_of(c);
      RandomStream random(0, 0);
      std::vector<State> starts(kFlights);
      for (State& s : starts) {
        s.orientation = random.rotation();
        s.angular_velocity = spin * random.unit_vector();
      }
      Flight flight(body);
      std::vector<double> us;
      double worst = 0.0, sum = 0.0;
      for (int round = 0; round < kRounds; ++round) {
        const auto begin = std::chrono::steady_clock::now();
        for (const State& s : starts) {
          flight.start(s, {0.0, 0.0, -9.81});
          sum += flight.at(kLength_s).orientation.w();
        }
        const std::chrono::duration<double, std::micro> gone = std::chrono::steady_clock::now() - begin;
        us.push_back(gone.count() / kFlights);
      }
      for (const State& s : starts) {
        flight.start(s, {0.0, 0.0, -9.81});
        const State end = flight.at(kLength_s);
        flight.start(end, {0.0, 0.0, -9.81});
        worst = std::max(worst, angle(flight.at(-kLength_s).orientation, s.orientation));
      }
      std::nth_element(us.begin(), us.begin() + kRounds / 2, us.end());
      std::printf("%s,%g,%.3f,%.1e\n", c.name.c_str(), spin, us[kRounds / 2], sum == sum ? worst : -1.0);
    }
  return 0;
}
