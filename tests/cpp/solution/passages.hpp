// One passage at a time.
#pragma once

#include "ifa/solution/passage.hpp"

namespace ifa::sample {

inline SearchPhysics physics_of(Events events) {
  SearchPhysics physics;
  physics.hearing.events = events;
  return physics;
}

inline Onset strike_one(Passages& passages, const State& before) {
  Onset onset;
  passages.strike({&before, 1}, {&onset, 1});
  return onset;
}

inline Passage run_one(Passages& passages, const Departure& departure) {
  Passage passage;
  passages.run({&departure, 1}, {&passage, 1}, nullptr);
  return passage;
}

}  // namespace ifa::sample
