// One transition of the forward search: from the impact of one event, changed within the plausible region, to
// the next event's first hit.
#pragma once

#include <vector>

#include "ifa/rigid/event_engine.hpp"
#include "ifa/signature/events.hpp"
#include "ifa/signature/factors.hpp"

namespace ifa {

struct SearchPhysics {
  SimulationOptions simulation;
  HearingOptions hearing;
  // Hits within this share of the audible speed, and gaps within this share of the merge gap, could be judged
  // either way by whoever checks the motion: a motion that has one is not used.
  double margin = 0.05;
  double energy_gain_j = 0.0;
};

// The impact an event begins with.
struct Onset {
  State before, after;  // principal axes; `after` as physics has it, before any change
  Hit hit;
};

enum class Next { hit, rest, late, dubious };

struct Passage {
  Next next = Next::late;
  double interval_s = 0.0;  // from the event to the next one (or to where the run ended)
  Event event;              // the event it began with, chain and all
  State before;             // at the end; where next is hit, just before the next event's impact
  double rest_s = 0.0;      // where next is rest: when it began, from the event
};

// Where a recorded passage goes.
struct Record {
  std::vector<Node> nodes;
  std::vector<Hit> hits;  // audible or not, without the onset's
};

// Not thread-safe; make one for each worker. Body and physics must outlive it.
class Runner {
 public:
  Runner(const Body& body, const SearchPhysics& physics)
      : body_(body), physics_(physics), simulation_(body, physics.simulation) {}

  Onset strike(const State& before);

  // From just after the onset's impact, with `after` in place of its own outcome, until the next event
  // begins, the body rests, or `limit_s`. `span_s` is the duration of the mark that the event shall meet.
  Passage pass(const Onset& onset, const State& after, double span_s, double limit_s,
               Record* record = nullptr);

  // Makes touching points not approach any more, without restitution; true if there was something to do.
  bool settle(State& state);

  double simulated_s() const { return simulated_s_; }

 private:
  const Body& body_;
  const SearchPhysics& physics_;
  EventSimulation simulation_;
  std::vector<Load> loads_;
  double simulated_s_ = 0.0;
};

}  // namespace ifa
