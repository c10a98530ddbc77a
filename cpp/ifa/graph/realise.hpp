// From a path in the graph to a motion: splices become connections, and everything is simulated again (paper
// sections 5.3 and 5.5, "lazy evaluation of blends").
#pragma once

#include <optional>

#include "ifa/graph/connection.hpp"
#include "ifa/graph/database.hpp"
#include "ifa/graph/images.hpp"
#include "ifa/graph/search.hpp"
#include "ifa/solution/found.hpp"

namespace ifa {

struct Realised {
  Found found;
  // Where it failed: the step that could not be gone (found ends there), and why.
  std::optional<std::size_t> failed_step;
  const char* reason = "";
};

// The motion of a path, as physics has it between changes: every impact is resolved for the body as it
// arrives there. What a splice changes is therefore measured against that, not against the node's own
// simulation. After a splice the next node is left as in its own simulation, and the difference counts as a
// change too.
class Realiser {
 public:
  // `physics` is the database's, but for the energy that a change may add. All must outlive it.
  Realiser(const Database& database, const SearchPhysics& physics, const Images& images);

  // Throws ReplayError.
  Realised realise(const GraphPath& path, const Targets& targets) const;

 private:
  class Walk;

  const Database& database_;
  const SearchPhysics& physics_;
  const Images& images_;
  Connector connector_;
};

}  // namespace ifa
