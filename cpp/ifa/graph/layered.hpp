// The exact search: a dynamic programme, layer by layer, over (event, node, loudness of the path's first
// event) on the precomputed transitions. A path's weight is a product over its edges, and all that later
// edges know of what came before is the node and that loudness; so of two paths that agree in both only the
// better one can be part of the best.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/graph/search.hpp"
#include "ifa/graph/transitions.hpp"

namespace ifa {

// What the search needs of a database besides its transitions; made once.
struct Briefs {
  std::vector<NodeBrief> nodes;
  std::vector<std::uint32_t> by_interval;  // nodes whose own edge can be used, the shortest first

  explicit Briefs(const Nodes& of);
};

struct LayeredOptions {
  std::size_t most_states =
      100'000;               // of a layer; the worst are dropped, and the bound says what that may cost
  double most_retime = 1.3;  // a target interval over the path's, or the other way round
  double most_cost = 20.0;   // of a splice: -log(f_v f_q)
  std::size_t paths = 1;     // to return, at most
  std::size_t neighbours = std::numeric_limits<std::size_t>::max();  // of a node: its best transitions
  std::vector<std::uint64_t> banned;  // splices found infeasible, see splice_key; in order
};

inline std::uint64_t splice_key(std::uint32_t from, std::uint32_t target) {
  return static_cast<std::uint64_t>(from) << 32 | target;
}

// The best paths, one at most for each last node and loudness of the first, best first. `log_bound` bounds
// all paths that begin with a simulated edge and go on along simulated edges and those transitions. Where no
// path goes all the way, those that come farthest: with fewer steps, and no weight. Two targets or more.
std::vector<GraphPath> search_layers(const Briefs& briefs, const Transitions& transitions,
                                     const Targets& targets, const LayeredOptions& options,
                                     const Progress* progress = nullptr);

// For a single target: the nodes that can meet it, best first. Nothing leads there, so equal ones abound, and
// those are spread over the database.
std::vector<GraphPath> single_events(const Briefs& briefs, const Targets& targets, std::size_t most);

// The part of one simulation that fits best as it is (also a path of the above).
GraphPath best_suffix(const Briefs& briefs, const Targets& targets, double most_retime);

}  // namespace ifa
