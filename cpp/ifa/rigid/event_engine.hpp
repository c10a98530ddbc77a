// engine="event": flight in closed form, impacts at their exact instants, small steps only in sustained
// contact. The steps themselves are in lanes/, for one simulation and for many.
#pragma once

#include <vector>

#include "ifa/base/effects.hpp"
#include "ifa/base/progress.hpp"
#include "ifa/rigid/contact.hpp"
#include "ifa/rigid/flight.hpp"
#include "ifa/rigid/lanes/sim.hpp"
#include "ifa/rigid/run.hpp"

namespace ifa {

struct SimulationOptions {
  Vec3 gravity_m_s2{0.0, 0.0, -9.81};
  double step_s = 1e-3;           // of sustained contact
  double micro_speed_m_s = 0.01;  // impacts slower than this do not bounce, or a bounce never ends (Zeno)
  double rest_speed_m_s = 0.01;   // rest: every hull point slower than this ...
  double rest_duration_s = 0.05;  // ... for this long
  int max_impacts = 100000;
  // Off: no steps of contact, a simulation ends where those would begin.
  bool sustained_contact = compiled(Effect::sustained_contact);
};

// Advances from impact to impact; the caller looks at each before it is resolved. States are in principal
// axes. The body must outlive it. Reusable: `start` begins anew.
class EventSimulation {
 public:
  enum class Stop { impact, rest, time_limit, contact };

  EventSimulation(const Body& body, const SimulationOptions& options);

  // `nodes` and `loads`, where given, receive the motion and the steps of sustained contact; a cancelled
  // `progress` ends `advance` with Cancelled. The state may
  // touch the ground, it must not be below it (by more than 1e-6 of its size).
  void start(const State& state, double time_s, std::vector<Node>* nodes = nullptr,
             std::vector<Load>* loads = nullptr, const Progress* progress = nullptr);

  // Goes on to the next impact (state() is then the state just before it), to rest, or to `until_s`. Where
  // sustained contact is off, Stop::contact in its place.
  Stop advance(double until_s);

  double approach_speed() const;  // of the impact `advance` stopped at: the largest over the touching points
  Hit resolve();                  // applies it; state() is then the state just after

  State state() const;
  double time_s() const { return sim_.time_s; }
  double rest_s() const { return sim_.slow_since_s; }  // after Stop::rest
  bool in_contact() const { return sim_.stage == lanes::Stage::contact; }

  // The least normal velocity over the touching points (1e100 if none touches).
  double separation_speed() const;

 private:
  void record();

  lanes::BodyView body_;
  lanes::Settings settings_;
  lanes::Sim sim_{};
  std::vector<Node>* nodes_ = nullptr;
  std::vector<Load>* loads_ = nullptr;
  const Progress* progress_ = nullptr;
};

// The whole run, to rest or to `until_s`.
Run simulate(const Body& body, const State& state, const SimulationOptions& options, double until_s,
             const Progress* progress = nullptr);

}  // namespace ifa
