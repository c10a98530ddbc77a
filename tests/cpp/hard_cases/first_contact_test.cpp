// Hard case 7: the first instant of contact, for a parabola and for any spin.
#include <algorithm>
#include <cmath>
#include <vector>

#include "held.hpp"
#include "ifa/rigid/flight.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::kGravity;
using sample::lowest;

// The root of h + v t - g t^2 / 2 without cancellation, in long double.
double fall_time(double height, double velocity) {
  const long double h = height, v = velocity, g = kGravity;
  const long double root = std::sqrt(v * v + 2 * g * h);
  return static_cast<double>(v > 0 ? (v + root) / g : 2 * h / (root - v));
}

TEST(HardCase7, ParabolaToFirstContact) {
  RandomStream random(201, 0);
  Held time("first contact, s", 1e-12);
  for (const Body& body : {sample::ball(0.02, 0.03), sample::box({0.016, 0.02, 0.03}, 0.01)}) {
    Flight flight(body);
    for (int i = 0; i < 2000; ++i) {
      const bool spins = body.vertices().size() == 1;
      const double height = std::pow(10.0, random.uniform(-6.0, 0.5));
      State s = sample::random_state(body, random, height, 5.0, spins ? 100.0 : 0.0);
      const double expected = fall_time(lowest(body, s), s.velocity.z());
      flight.start(s, sample::downwards());
      time.see(std::abs(flight.next_contact(kNever) - expected), i, height);
      EXPECT_EQ(flight.next_contact(0.99 * expected), kNever);
    }
  }
}

// Heights of all vertices at an instant from the pose alone, and a bound on their accelerations from the
// angular momentum, alpha = I^-1 (L x w).
class Heights {
 public:
  Heights(const Body& body, const Flight& flight) : body_(&body), flight_(&flight) {}

  void at(double t, std::vector<double>& heights) const {
    const State s = flight_->at(t);
    const Vec3 up = s.orientation.toRotationMatrix().row(2);
    heights.clear();
    for (const Vec3& p : body_->principal_vertices())
      heights.push_back(s.position.z() - body_->radius_m() + up.dot(p));
  }

  double acceleration(double t) const {
    const State s = flight_->at(t);
    const Mat3 r = s.orientation.toRotationMatrix();
    const Vec3 w = r.transpose() * s.angular_velocity, &inertia = body_->principal_inertia();
    const Vec3 turn = -w.cross(inertia.cwiseProduct(w)).cwiseQuotient(inertia);
    double largest = 0.0;
    for (const Vec3& p : body_->principal_vertices())
      largest = std::max(largest, std::abs((r * (turn.cross(p) + w.cross(w.cross(p)))).z() - kGravity));
    return largest;
  }

 private:
  const Body* body_;
  const Flight* flight_;
};

// How far below the ground any vertex is in [0, end], to within `resolution`: intervals are halved until a
// vertex above the ground at both ends cannot dip to it between them, |h''| <= A allowing A dt^2 / 8.
double deepest(const Body& body, const Flight& flight, double end, double spin, double resolution) {
  const Heights heights(body, flight);
  const int first = 2 + static_cast<int>(end * spin / 0.1);
  double bound = 0.0;  // twice the largest at instants 0.1 rad apart
  for (int i = 0; i <= first; ++i) bound = std::max(bound, 2.0 * heights.acceleration(end * i / first));
  struct Interval {
    double start, end;
    std::vector<double> at_start, at_end;
  };
  std::vector<double> before, after, middle;
  heights.at(0.0, before);
  double depth = 0.0;
  for (int i = 0; i < first; ++i) {
    heights.at(end * (i + 1) / first, after);
    std::vector<Interval> left{{end * i / first, end * (i + 1) / first, before, after}};
    while (!left.empty()) {
      const Interval here = std::move(left.back());
      left.pop_back();
      const double length = here.end - here.start, dip = 0.125 * bound * length * length;
      double low = 0.0;  // what could be below the ground
      for (std::size_t k = 0; k < here.at_start.size(); ++k)
        low = std::min(low, std::min(here.at_start[k], here.at_end[k]) - dip);
      if (low == 0.0) continue;
      if (dip <= resolution) {
        depth = std::max(depth, -low);
        continue;
      }
      const double half = 0.5 * (here.start + here.end);
      heights.at(half, middle);
      left.push_back({here.start, half, here.at_start, middle});
      left.push_back({half, here.end, middle, here.at_end});
    }
    before = after;
  }
  return depth;
}

std::vector<Body> shapes() {
  RandomStream random(202, 0);
  Body::Definition pebble = sample::box({0.02, 0.02, 0.02}, 0.01).definition();
  pebble.vertices_m.clear();
  for (int i = 0; i < 60; ++i)
    pebble.vertices_m.push_back(Vec3(0.02, 0.012, 0.007).cwiseProduct(random.unit_vector()));
  pebble.inertia_kg_m2 = 1e-6 * Vec3(0.4, 0.9, 1.1).asDiagonal();
  Body::Definition loaded = sample::box({0.02, 0.03, 0.04}, 0.01).definition();  // mass centre near a corner
  loaded.centre_of_mass_m = {0.008, -0.013, 0.018};
  return {sample::box({0.016, 0.016, 0.016}, 0.005),
          sample::box({0.01, 0.02, 0.03}, 0.05),
          sample::rod(0.2, 5e-4, 0.01),
          sample::rod(0.02, 0.004, 0.01),
          sample::box({0.085, 0.054, 1e-5}, 0.005),
          sample::box({0.1, 1e-3, 1e-3}, 0.001),
          Body::make(pebble),
          Body::make(loaded)};
}

// The search itself finds a dip that it must: the tip of a rod that turns about a fixed centre.
TEST(HardCase7Search, SeesAGrazingTip) {
  const double length = 0.2, rate = 30.0;
  const Body body = sample::rod(length, 0.0005, 0.01);
  for (const double dip : {0.0, 1e-9, 1e-6, 1e-3}) {
    State s;
    s.position.z() = 0.0005 + 0.5 * length - dip;
    s.angular_velocity.y() = rate;
    s.velocity.z() = kGravity * 0.05;  // at its highest as the tip is at its lowest, nearly
    Flight flight(body);
    flight.start(s, sample::downwards());
    double lowest_seen = 1.0;
    for (int i = 0; i <= 100000; ++i) lowest_seen = std::min(lowest_seen, lowest(body, flight.at(1e-6 * i)));
    EXPECT_NEAR(deepest(body, flight, 0.1, rate, 1e-14), std::max(0.0, -lowest_seen), 1e-10) << dip;
  }
}

class HardCase7Spinning : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Shape, HardCase7Spinning, ::testing::Range(0, 8));

// Neither missed nor late, and something touches at it. Up to 1e-13 of the size counts as touching: a
// thousand roundings of the pose.
TEST_P(HardCase7Spinning, NothingIsBelowTheGroundBefore) {
  const Body body = shapes()[static_cast<std::size_t>(GetParam())];
  const double size = body.bounding_radius_m();
  RandomStream random(203, static_cast<std::uint64_t>(GetParam()));
  Held below("depth before the first contact, of the size", 1e-12);
  Held off("height of the nearest vertex at it, of the size", 1e-12);
  const int flights = trials(100000, 0.1);
  int landed = 0;
  for (int i = 0; i < flights; ++i) {
    const double spin = std::pow(10.0, random.uniform(0.0, 3.3));  // up to 2000 rad/s
    const double height = size * std::pow(10.0, random.uniform(-6.0, 0.7));
    State s = sample::random_state(body, random, height, 3.0, 0.0);
    s.angular_velocity = spin * random.unit_vector();
    Flight flight(body);
    flight.start(s, sample::downwards());
    const double until = 0.1, found = flight.next_contact(until);
    if (found < kNever) {
      ++landed;
      const State there = flight.at(found);
      off.see(std::abs(lowest(body, there)) / size, i, spin, height, found);
    }
    below.see(deepest(body, flight, std::min(found, until), spin, 1e-13 * size) / size, i, spin, height,
              found);
  }
  EXPECT_GT(landed, flights / 2);
}

}  // namespace
}  // namespace ifa
