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

// How much of the graph is looked at; 0: all of it, of `states` what the rung has.
struct GraphSizes {
  std::size_t states = 0;      // of a layer of the exact search
  std::size_t neighbours = 0;  // of a node: its best transitions, in the exact search
  std::size_t children = 5;    // of a node in branch and bound
};

struct GraphOptions {
  double time_budget_s = 10.0;  // once over, no further rung is begun; the paper's search ends
  int rung = -1;                // run just this one, whatever the clock says; -1: climb
  int takes = 1;                // clearly different motions, at most
  double energy_gain_j = 0.0;   // that a change may add to one impact
  double lead_in_s = 0.5;       // of flight before the first mark, at most
  GraphSearch search = GraphSearch::layered;
  ForcedEffects forced = {};  // on or off, whatever the scene calls for: effects of the marks, not the body
  GraphSizes sizes;
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
