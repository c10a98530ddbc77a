// Hard cases 1 to 5: torque-free rotation.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "held.hpp"
#include "ifa/rigid/flight.hpp"
#include "sample_bodies.hpp"
#include "torque_free.hpp"

namespace ifa {
namespace {

using sample::angular_momentum;
using sample::kinetic;

Body with_moments(const Vec3& moments) {
  Body::Definition d = sample::box({0.02, 0.02, 0.02}, 0.03).definition();
  d.inertia_kg_m2 = moments.asDiagonal();
  return Body::make(d);
}

State spinning(const Vec3& body_spin, const Quat& orientation = Quat::Identity()) {
  State s;
  s.orientation = orientation;
  s.angular_velocity = orientation * body_spin;
  return s;
}

double momentum_error(const Body& body, const State& now, const State& start) {
  const Vec3 before = angular_momentum(body, start);
  return (angular_momentum(body, now) - before).norm() / before.norm();
}

const std::vector<std::string> kKinds = {"any",    "near sphere", "prolate", "oblate",
                                         "needle", "plate",       "card"};

// In units of the largest, in any order.
Vec3 random_moments(const std::string& kind, RandomStream& random) {
  const double small = std::pow(10.0, random.uniform(-12.0, -1.0)), share = random.uniform();
  Vec3 m;
  if (kind == "any") {
    const double least = random.uniform(0.05, 1.0);
    m = {least, std::max(least, 1.0 - least * share), 1.0};
  } else if (kind == "near sphere") {
    m = {1.0 - small, 1.0 - small * share, 1.0};
  } else if (kind == "prolate") {
    m = {random.uniform(0.01, 0.99), 1.0, 1.0};
  } else if (kind == "oblate") {
    const double across = random.uniform(0.5, 0.99);
    m = {across, across, 1.0};
  } else if (kind == "needle") {
    m = {small, 1.0 - small * share, 1.0};
  } else if (kind == "plate") {
    const double least = random.uniform(0.01, 0.49);
    m = {least, 1.0 - least, 1.0};
  } else {  // a card: a plate with a little thickness
    const double least = random.uniform(0.01, 0.49);
    m = {least, (1.0 - least) * (1.0 + small * least), 1.0};
  }
  const int turn = static_cast<int>(random.uniform(0.0, 6.0));
  const int i = turn % 3, j = (i + 1 + turn / 3) % 3;
  return 1e-6 * Vec3(m[i], m[j], m[3 - i - j]);
}

TEST(TorqueFreeOracle, ClosedFormAndIntegrationAgree) {
  RandomStream random(101, 0);
  Held turn("orientation, rad", 1e-14), spin("spin, relative", 1e-14);
  for (const std::string& kind : kKinds)
    for (int i = 0; i < 8; ++i) {
      const Body body = with_moments(random_moments(kind, random));
      const State s = spinning(random.uniform(1.0, 60.0) * random.unit_vector(), random.rotation());
      const TorqueFree exact(body, s);
      const double t = i % 2 ? 0.3 : -0.3;
      Mat3l r = to_matrix(s.orientation);
      Vec3l w = r.transpose() * s.angular_velocity.cast<Real>();
      const Real size = w.norm();
      Quatl q(r);
      integrate_torque_free(body.principal_inertia().cast<Real>(), t, q, w);
      turn.see(static_cast<double>(angle_between(exact.orientation(t), q.toRotationMatrix())), kind, i);
      spin.see(static_cast<double>((exact.body_spin(t) - w).norm() / size), kind, i);
    }
}

TEST(HardCase1, TriaxialRotation) {
  for (const std::string& kind : kKinds) {
    RandomStream random(102, 0);
    Held turn("orientation at 0.3 s, rad (" + kind + ")", 1e-10);
    for (int i = 0; i < 100; ++i) {
      const Body body = with_moments(random_moments(kind, random));
      const double rate = std::pow(10.0, random.uniform(0.0, 2.5));
      const State s = spinning(rate * random.unit_vector(), random.rotation());
      const TorqueFree exact(body, s);
      Flight flight(body);
      flight.start(s, Vec3::Zero());
      for (const double t : {0.3, -0.3})
        turn.see(
            static_cast<double>(angle_between(exact.orientation(t), to_matrix(flight.at(t).orientation))), i,
            rate, body.principal_inertia().transpose(), exact.complement());
    }
  }
}

// Spins for an elliptic modulus k on either side of the separatrix, about the middle axis a quarter of a
// period after the start. Moments ascending.
Vec3 spin_of_modulus(const Vec3& moments, double modulus, double rate, bool about_largest) {
  const Vec3& i = moments;
  const double ratio = std::sqrt(i[2] * (i[2] - i[1]) / (i[0] * (i[1] - i[0])));  // w1 / w3 on the separatrix
  const Vec3 w = about_largest ? Vec3(modulus * ratio, 0.0, 1.0) : Vec3(ratio, 0.0, modulus);
  return rate * w.normalized();
}

TEST(HardCase2, FlipPeriodOfTheMiddleAxis) {
  RandomStream random(103, 0);
  Held period("flip period, relative", 1e-8), energy("energy, relative", 1e-12),
      momentum("momentum, relative", 1e-12);
  for (int i = 0; i < 100; ++i) {
    const double least = random.uniform(0.1, 0.9);
    const Vec3 moments = 1e-6 * Vec3(least, random.uniform(std::max(least, 1.0 - least) + 0.02, 0.98), 1.0);
    const Body body = with_moments(moments);
    // rad off the axis. Rounding moves 1 - k^2, which is about its square, by some 1e-16, and the logarithm
    // of that is the period: 1e-10 at a thousandth, and more than 1e-8 below a ten-thousandth in any double
    // state.
    const double off = std::pow(10.0, random.uniform(-3.0, -1.0));
    const double rate = random.uniform(5.0, 50.0), angle = random.uniform(0.0, 6.0);
    const Vec3 spin = rate * Vec3(off * std::cos(angle), 1.0, off * std::sin(angle)).normalized();
    const State s = spinning(spin, random.rotation());
    const double expected = static_cast<double>(TorqueFree(body, s).period_s());
    Flight flight(body);
    flight.start(s, Vec3::Zero());
    const auto middle = [&](double t) {
      const State now = flight.at(t);
      return (now.orientation.conjugate() * now.angular_velocity).y();
    };
    // The spin's middle component vanishes twice a period: the times of three such flips, by bisection.
    std::vector<double> flips;
    const double step = expected / 64;
    for (double t = 0.0; flips.size() < 3 && t < 4 * expected; t += step) {
      double low = t, high = t + step;
      const double at_low = middle(low);
      if (at_low * middle(high) > 0.0) continue;
      for (int k = 0; k < 60; ++k) {
        const double half = 0.5 * (low + high);
        (middle(half) * at_low > 0.0 ? low : high) = half;
      }
      flips.push_back(low);
    }
    ASSERT_EQ(flips.size(), 3u) << i;
    period.see(std::abs((flips[2] - flips[0]) / expected - 1.0), i);
    for (const double t : {0.3, 0.5 * expected, expected, 2.0 * expected}) {
      const State now = flight.at(t);
      energy.see(std::abs(kinetic(body, now) / kinetic(body, s) - 1.0), i, t);
      momentum.see(momentum_error(body, now, s), i, t);
    }
  }
}

// q(t) = exp(L t / I1) q0 exp(-lambda t e3), lambda = (I3 - I1) w3 / I1: the precession about the momentum
// and the body's own rate, both in the long double of the expected value.
TEST(HardCase3, SymmetricBodyPrecesses) {
  RandomStream random(104, 0);
  Held turn("orientation, rad", 1e-12), momentum("momentum, relative", 1e-12),
      precession("spin, relative", 1e-12);
  for (const double ratio : {1e-12, 1e-6, 0.01, 0.5, 0.999, 1.0 - 1e-9, 1.0 + 1e-9, 1.3, 1.99, 2.0}) {
    const Body body = with_moments(1e-6 * Vec3(1.0, 1.0, ratio));
    Flight flight(body);
    for (int i = 0; i < 20; ++i) {
      const State s =
          spinning(std::pow(10.0, random.uniform(0.0, 2.5)) * random.unit_vector(), random.rotation());
      flight.start(s, sample::downwards());
      const Mat3l r = to_matrix(s.orientation);
      const Vec3l w = r.transpose() * s.angular_velocity.cast<Real>();
      const Vec3l inertia = body.principal_inertia().cast<Real>();
      const Vec3l axis = r * inertia.cwiseProduct(w) / inertia[0];
      const Real own = (inertia[2] - inertia[0]) * w[2] / inertia[0];
      for (const double t : {-0.5, 0.3, 1.0}) {
        const Mat3l back = Eigen::AngleAxis<Real>(-own * t, Vec3l::UnitZ()).toRotationMatrix();
        const Mat3l expected =
            Eigen::AngleAxis<Real>(axis.norm() * t, axis.normalized()).toRotationMatrix() * r * back;
        const State now = flight.at(t);
        turn.see(static_cast<double>(angle_between(expected, to_matrix(now.orientation))), ratio, i, t);
        const Vec3l spin = expected * (back.transpose() * w);
        precession.see(static_cast<double>((now.angular_velocity.cast<Real>() - spin).norm() / w.norm()),
                       ratio, i, t);
        momentum.see(momentum_error(body, now, s), ratio, i, t);
      }
    }
  }
}

Real turn_error(const TorqueFree& exact, const Flight& flight, double t) {
  return angle_between(exact.orientation(t), to_matrix(flight.at(t).orientation));
}

// Departures grow by e^(rate t) along the middle axis, at best a tenfold in 4 rad of turning: at 60 rad/s the
// rounding of the start alone is 1e-12 rad at 0.3 s, at 300 rad/s a radian. There the error is compared with
// what one rounding of the start's spin does to the exact answer: the flight rounds in each of its hundred
// steps.
TEST(HardCase4, NearTheSeparatrix) {
  Held momentum("momentum, relative", 1e-10), energy("energy, relative", 1e-10),
      turn("orientation at 0.3 s, rad", 1e-10),
      turn_fast("the same at 300 rad/s, in roundings of the start", 100.0);
  RandomStream random(105, 0);
  for (const Vec3& moments :
       {Vec3(1.0, 2.0, 3.0), Vec3(0.1, 0.98, 1.0), Vec3(0.55, 0.6, 1.0), Vec3(1e-3, 0.9995, 1.0)}) {
    const Body body = with_moments(1e-6 * moments);
    Flight flight(body);
    for (const double modulus : {1.0 - 1e-12, 1.0})
      for (const bool about_largest : {false, true})
        for (const double rate : {1.0, 20.0, 60.0, 300.0}) {
          const State s = spinning(spin_of_modulus(moments, modulus, rate, about_largest), random.rotation());
          flight.start(s, Vec3::Zero());
          const TorqueFree exact(body, s);
          const double error = static_cast<double>(turn_error(exact, flight, 0.3));
          if (rate < 300.0) {
            turn.see(error, moments.transpose(), modulus, rate);
          } else {
            double rounding = 1e-15;
            for (int axis = 0; axis < 3; ++axis) {
              State near = s;
              near.angular_velocity[axis] += 3e-16 * rate;
              rounding =
                  std::max(rounding, static_cast<double>(angle_between(
                                         exact.orientation(0.3), TorqueFree(body, near).orientation(0.3))));
            }
            turn_fast.see(error / rounding, moments.transpose(), modulus, error, rounding);
          }
          for (const double t : {-1.0, 0.3, 1.0, 5.0}) {
            const State now = flight.at(t);
            ASSERT_TRUE(now.orientation.coeffs().allFinite() && now.angular_velocity.allFinite());
            momentum.see(momentum_error(body, now, s), moments.transpose(), modulus, rate, t);
            energy.see(std::abs(kinetic(body, now) / kinetic(body, s) - 1.0), moments.transpose(), modulus,
                       rate, t);
          }
        }
  }
  // About the middle axis itself, and so near to it that squares vanish.
  const Body body = sample::box({0.03, 0.02, 0.01}, 0.05);
  for (const double off : {0.0, 1e-300, 1e-12, 1e-6}) {
    const State s = spinning({off, 20.0, -off});
    Flight flight(body);
    flight.start(s, Vec3::Zero());
    for (const double t : {0.3, 5.0}) momentum.see(momentum_error(body, flight.at(t), s), off, t);
  }
}

TEST(HardCase5, ForwardThenReversedIsTheIdentity) {
  Held turn("orientation, rad", 1e-11), spin("spin, of its size", 1e-11), place("position, m", 1e-11),
      speed("velocity, m/s", 1e-11);
  RandomStream random(106, 0);
  for (const std::string& kind : kKinds)
    for (int i = 0; i < 50; ++i) {
      const Body body = with_moments(random_moments(kind, random));
      State s = sample::random_state(body, random, 1.0, 4.0, 100.0);
      const double t = random.uniform(0.05, 0.5);
      Flight flight(body);
      flight.start(s, sample::downwards());
      const State there = flight.at(t);
      flight.start(there, sample::downwards());
      const State back = flight.at(-t);
      turn.see(static_cast<double>(angle_between(to_matrix(back.orientation), to_matrix(s.orientation))),
               kind, i);
      spin.see((back.angular_velocity - s.angular_velocity).norm() / s.angular_velocity.norm(), kind, i);
      place.see((back.position - s.position).norm(), kind, i);
      speed.see((back.velocity - s.velocity).norm(), kind, i);
    }
}

}  // namespace
}  // namespace ifa
