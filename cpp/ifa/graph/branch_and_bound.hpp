// The paper's own search (section 5.5, with its optional speedups): branch and bound on sub-paths of bounded
// depth, transitions from the k-d trees. Incomplete, and slower than search_layers; kept to compare with.
//
// The first edge is a simulated one, of about the first interval. From there the best path to the event
// `depth` edges ahead, or to the last one, is sought among each node's own simulated edge and its best
// `children`; the next `keep` of its edges are kept, and so on to the end. The body's symmetry is not used.
//
// What the paper leaves open, and what is done here:
// - "close" to the first interval: log f_t above kLeastLogFactor, as of f_v and f_q. Edges of such a kind are
//   begun with in the order of their weight, the sounds of both their events included.
// - "best 5 children": the nearest in the k-d tree, its own successor not counted. Their exact weights are
//   computed; those of f_v or f_q too low, or that gain energy, are left out and not made up for.
// - A sub-path that cannot be continued, or a path that can no longer be better than the best complete one:
//   the next first edge is tried, and nothing that was kept is taken back.
// - After the first complete path the search goes on likewise, until one is good enough or the time is over.
// - An open ending's last event is of either tree.
// - Where an edge turns out infeasible: a splice is never used again; a simulated one, that a spliced body no
//   longer follows, is not used again after this first edge.
#pragma once

#include <functional>
#include <limits>
#include <optional>

#include "ifa/base/progress.hpp"
#include "ifa/graph/layered.hpp"
#include "ifa/graph/trees.hpp"

namespace ifa {

struct SearchedGraph {
  const Nodes& nodes;
  const Body& body;
  const Briefs& briefs;
  const NodeTrees& trees;
  double gravity_m_s2, energy_gain_j;
};

struct BranchAndBoundOptions {
  std::size_t depth = 5, keep = 2;               // edges; 0 is as 1
  std::size_t children = 5;                      // of a node, besides its own successor
  std::optional<double> early_exit_score = 0.3;  // of a complete path; none: only the time ends the search
  // A target interval over an edge's, or the other way round. The paper has no such limit, and so may end
  // early with a path whose Score is good and one edge of which is retimed by half.
  double most_retime = std::numeric_limits<double>::infinity();
  double time_limit_s = 3600.0;
};

// Of a path, the first step that cannot be gone, if any. Asked of the best sub-path, with what leads there.
using FirstInfeasible = std::function<std::optional<std::size_t>(const GraphPath& path)>;

// The best path that was found; where none goes all the way, the best of those that come farthest, with fewer
// steps; without steps where no edge is close to the first interval. Its log_bound is 0, as nothing is known.
// Two targets or more. Throws Cancelled.
GraphPath search_branch_and_bound(const SearchedGraph& graph, const Targets& targets,
                                  const BranchAndBoundOptions& options,
                                  const FirstInfeasible& first_infeasible,
                                  const Progress* progress = nullptr);

}  // namespace ifa
