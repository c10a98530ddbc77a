// method="graph": from marks to a motion by way of the contact-event graph (paper section 5).
#pragma once

#include <cstdint>

#include "ifa/base/progress.hpp"
#include "ifa/graph/graph.hpp"
#include "ifa/solution/solution.hpp"

namespace ifa {

enum class GraphSearch {
  layered,           // exact, rung by rung
  branch_and_bound,  // the paper's: one rung, one take
};

struct GraphOptions {
  double time_budget_s = 10.0;  // once over, no further rung is begun; the paper's search ends
  int rung = -1;                // run just this one, whatever the clock says; -1: climb
  int takes = 1;                // clearly different motions, at most
  double energy_gain_j = 0.0;   // that a change may add to one impact
  double lead_in_s = 0.5;       // of flight before the first mark, at most
  GraphSearch search = GraphSearch::layered;
  ForcedEffects forced = {};  // on or off, whatever the scene calls for: effects of the marks, not the body
};

int graph_rung_count();

// The ladder: first paths whose splices and retimings are plausible, then any; the layers wider from rung to
// rung. Of each rung's best paths those that can be flown are made motions; splices that cannot be are banned
// and the rung searched again (lazy blends). The first plausible motion ends the climb, else the best one is
// returned, if need be one that misses marks. The paper's search has no ladder: it asks for each sub-path
// whether it can be flown, and what it has found when it ends is made a motion. Throws NoMotionError where no
// node at all can begin the motion, Cancelled, or ArgumentError.
Solution solve_graph(const ContactGraph& graph, const Marks& marks, const GraphOptions& options,
                     Progress* progress);

}  // namespace ifa
