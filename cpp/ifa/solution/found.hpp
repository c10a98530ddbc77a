// A motion as a search leaves it: how each event begins and is left.
#pragma once

#include <optional>
#include <vector>

#include "ifa/solution/passage.hpp"

namespace ifa {

// How an event was left.
struct Leave {
  State after;  // the impact's outcome with its change
  double excess = 0.0;
  double interval_s = 0.0;  // to the next event, simulated
};

// A second change, where the last flight before the next event begins: after the event's chain of hits and
// silent contact, which go as `Leave` has them.
struct TakeOff {
  State after;
  double flight_s;  // to the next event
  double excess;
};

// One event of a found motion.
struct Link {
  Onset onset;
  Leave leave;
  std::optional<TakeOff> take_off = {};
  double orientation_factor =
      1.0;  // f_q of the way to the next event (paper eq. 4); 1 where nothing is spliced
};

// A motion, event by event.
struct Found {
  int body = 0;
  std::vector<Link> links;
  bool complete = false;  // it ends as the marks ask
};

}  // namespace ifa
