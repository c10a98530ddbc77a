// engine="event": flight in closed form, impacts at their exact instants, small steps only in sustained
// contact.
#pragma once

#include <optional>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/rigid/contact.hpp"
#include "ifa/rigid/flight.hpp"
#include "ifa/rigid/run.hpp"

namespace ifa {

struct SimulationOptions {
  Vec3 gravity_m_s2{0.0, 0.0, -9.81};
  double step_s = 1e-3;           // of sustained contact
  double micro_speed_m_s = 0.01;  // impacts slower than this do not bounce, or a bounce never ends (Zeno)
  double rest_speed_m_s = 0.01;   // rest: every hull point slower than this ...
  double rest_duration_s = 0.05;  // ... for this long
  int max_impacts = 100000;
};

// Advances from impact to impact; the caller looks at each before it is resolved. States are in principal
// axes. The body must outlive it. Reusable: `start` begins anew without allocating.
class EventSimulation {
 public:
  enum class Stop { impact, rest, time_limit };

  EventSimulation(const Body& body, const SimulationOptions& options);

  // `nodes` and `loads`, where given, receive the motion and the steps of sustained contact. The state may
  // touch the ground, it must not be below it (by more than 1e-6 of its size).
  void start(const State& state, double time_s, std::vector<Node>* nodes = nullptr,
             std::vector<Load>* loads = nullptr);

  // Goes on to the next impact (state() is then the state just before it), to rest, or to `until_s`.
  Stop advance(double until_s);

  double approach_speed() const;  // of the impact `advance` stopped at: the largest over the touching points
  Hit resolve();                  // applies it; state() is then the state just after

  const State& state() const { return state_; }
  double time_s() const { return time_s_; }
  double rest_s() const { return slow_since_s_; }  // after Stop::rest
  bool in_contact() const { return phase_ == Phase::contact; }

  // The least normal velocity over the touching points (kNever if none touches).
  double separation_speed() const;

 private:
  struct Step {
    State state;
    double normal_impulse, slip_speed;
    int loaded;  // points that carry load
  };

  void find_touching();
  void choose_phase();
  void choose_bearing(const Quat& orientation);
  void enter(Phase phase);
  void record(Phase phase);
  Stop advance_flight(double until_s);
  std::optional<Stop> advance_contact(double until_s);
  bool almost_at_rest() const;
  void add_settling_points(const Quat& predicted, double length_s);
  Step try_step(double length_s);
  double lowest_newcomer(const State& state, int* vertex) const;
  double approach_of(const State& state, int vertex) const;
  void project(State& state, int newcomer);
  void hold_on_ground(State& state) const;
  void limit_energy(State& state) const;
  double energy(const State& state) const;
  bool check_rest(const Step& step, double length_s);
  bool supported() const;

  const Body* body_;
  SimulationOptions options_;
  Flight flight_;
  ContactSolver solver_;
  State state_;
  double time_s_ = 0.0, flight_start_s_ = 0.0;
  double slow_since_s_ = 0.0;
  bool slow_ = false;
  int still_steps_ = 0;
  Phase phase_ = Phase::flight;
  double touch_m_;
  std::vector<int> touching_;
  std::vector<char> touches_;
  std::vector<int> holding_;
  std::vector<Vec3> forces_;  // of each point in the last step, N: the next one begins from them
  std::vector<ContactPoint> points_;
  std::vector<Node>* nodes_ = nullptr;
  std::vector<Load>* loads_ = nullptr;
};

// Resolves the impact of `state` at the points `arms` (world axes, from the centre of mass): a Newton target
// -e v_n at each point that approaches faster than `micro_speed`, Coulomb's cone, and where the kinetic
// energy would grow, the whole impulse blended towards that of e = 0 until it does not. Changes `state`.
struct ImpactResult {
  Vec3 impulse_n_s = Vec3::Zero();
  Vec3 position_m = Vec3::Zero();
};
ImpactResult resolve_impact(const Body& body, double micro_speed, ContactSolver& solver,
                            std::vector<ContactPoint>& points, State& state);

Mat3 inverse_inertia_world(const Body& body, const Quat& orientation);
double kinetic_energy(const Body& body, const State& state);

// The whole run, to rest or to `until_s`.
Run simulate(const Body& body, const State& state, const SimulationOptions& options, double until_s,
             const Progress* progress = nullptr);

}  // namespace ifa
