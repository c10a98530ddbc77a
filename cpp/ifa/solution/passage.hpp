// A passage: from just after the impact of one event to the impact that the next one begins with.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/rigid/event_engine.hpp"
#include "ifa/rigid/flock.hpp"
#include "ifa/signature/events.hpp"

namespace ifa {

struct SearchPhysics {
  SimulationOptions simulation;
  HearingOptions hearing;
  // Hits within this share of the audible speed, and gaps within this share of the merge gap, could be judged
  // either way by whoever checks the motion: a motion that has one is not used.
  double margin = 0.05;
  double energy_gain_j = 0.0;

  // An impact that approaches this fast begins an event that nobody could miss.
  double least_onset_speed_m_s() const {
    return hearing.events == Events::contact ? 0.0 : hearing.audible_speed_m_s * (1.0 + margin);
  }

  // How long after its last hit an event is over beyond doubt.
  double event_over_s() const { return hearing.merge_gap_s * (1.0 + margin); }
};

// The impact an event begins with.
struct Onset {
  State before, after;  // principal axes; `after` as physics has it, before any change
  Hit hit;              // its time is 0
};

// `late`: neither a hit nor rest in time; a rest that the body would not keep is none. Where sustained
// contact is off, also a passage that ends as it would begin.
enum class Next { hit, rest, late, dubious };

struct Passage {
  Next next = Next::late;
  double interval_s = 0.0;  // from the event to the next one (or to where the run ended)
  Event event;              // the event it began with, chain and all
  Onset onset;              // where a hit ended it: of the next event
  State end;                // where it ended; before the next event's impact
  double rest_s = 0.0;      // where next is rest: when it began, from the event

  // Whether a hit ended it, one that can be told or not.
  bool hits() const {
    return next == Next::hit || (next == Next::dubious && onset.hit.approach_speed_m_s > 0.0);
  }
};

// Where a passage begins.
struct Departure {
  Hit first;       // of the event
  State after;     // in place of the impact's own outcome
  double span_s;   // duration of the mark that the event shall meet
  double limit_s;  // when it is given up
  // Only the event itself is watched: each hit that chains on moves the limit until nothing more can. What
  // could be judged either way before is dubious, and nothing else.
  bool event_only = false;
};

// Judges what is heard on the way. Times are from the event.
class Listener {
 public:
  Listener(const SearchPhysics& physics, const Departure& departure);

  void add(const Load& load) { event_.add(load); }

  // An impact that comes: whether the next event begins with it. If not, `add` it.
  bool begins_next(double time_s, double approach_speed_m_s);
  void add(const Hit& hit);

  Passage ended(Next next, double time_s, const State& end, double rest_s = 0.0);

 private:
  const SearchPhysics* physics_;
  bool event_only_;
  EventBuilder event_;
  bool dubious_ = false;
  int impacts_ = 0;
};

// Many passages of one body, side by side. Not thread-safe; make one for each worker. Body and physics must
// outlive it.
class Passages {
 public:
  Passages(const Body& body, const SearchPhysics& physics);

  // out[i] of departures[i]. A cancelled `progress` ends it with Cancelled.
  void run(std::span<const Departure> departures, std::span<Passage> out, const Progress* progress);

  // The impacts of states that touch the ground.
  void strike(std::span<const State> before, std::span<Onset> out);

  // Makes touching points not approach any more, without restitution; true if there was something to do.
  bool settle(State& state) const;

  double simulated_s() const { return simulated_s_; }

 private:
  struct Member : lanes::Sim {
    std::size_t index;
    std::optional<Listener> listener;
    State before;
  };
  class Client;

  double rolls_for_s(const lanes::Sim& sim) const;

  const Body& body_;
  const SearchPhysics& physics_;
  const lanes::Kernels& kernels_;
  Flock<Member> flock_;
  lanes::BodyView dull_;
  bool ball_;
  double simulated_s_ = 0.0;
};

// Whether the body is one rounded vertex at its centre of mass, with equal moments: once it does not bounce
// any more, it only rolls.
bool is_ball(const Body& body);

// Whether a body at rest stands on three vertices or more, and not balanced on an edge or a corner, where
// rolling friction can hold it though no viewer would believe it. Bodies that have no faces to stand on, and
// those with circular edges, stand as they are.
bool stands(const Body& body, const State& at_rest);

// Where a recorded passage goes.
struct Record {
  std::vector<Node> nodes;
  std::vector<Hit> hits;  // audible or not, without the onset's
  std::vector<Load> loads;
};

// Of a passage that a hit ended: just before the contact that its last flight begins with.
const State& state_before_last_flight(const Record& record);

// One passage, with what lies on the way; the same bytes as in Passages, but that a ball's rolling is
// simulated to its end. `onset` is left as it is.
Passage record_passage(const Body& body, const SearchPhysics& physics, const Departure& departure,
                       Record& record, const Progress* progress = nullptr);

Onset strike(const Body& body, const SearchPhysics& physics, const State& before);

// How long the flight before `first` can be followed backwards before something touches the ground, at most
// `limit_s`.
double clear_before(const Body& body, const State& first, const Vec3& gravity_m_s2, double limit_s);

}  // namespace ifa
