// What the two searches of the graph share: what is asked for, what a path is, and the sound-dependent half
// of an edge weight (paper section 5.4).
#pragma once

#include <cstdint>
#include <vector>

#include "ifa/graph/nodes.hpp"
#include "ifa/signature/factors.hpp"
#include "ifa/signature/marks.hpp"

namespace ifa {

// Marks as the graph sees them: event k is mark k, edge k leads from event k to event k + 1.
struct Targets {
  std::vector<double> intervals_s;  // (n - 1) from mark to mark
  std::vector<double> durations_s;  // (n) 0: discrete
  std::vector<double> amplitudes;   // (n) relative to the first, or empty: unknown
  std::vector<double> centroids_s;  // (n) NaN where unknown
  bool rest = true;                 // the last event shall be a terminal node

  SoundTerms judged;

  explicit Targets(const Marks& marks, const SoundTerms& judged = {});
  std::size_t size() const { return durations_s.size(); }
};

// A node as the weights see it, its figures side by side: a search looks at millions.
struct NodeBrief {
  float delay_s, flight_s;  // delay + flight: from the event to the next one of its own simulation
  float amplitude, length_s, centroid_s;
  std::uint32_t flags;
};

NodeBrief brief_of(const Nodes& nodes, std::size_t i);

// Of an edge from `from` that ends as the flight of `like` did; of its own simulated one, both are the same.
inline double interval_s(const NodeBrief& from, const NodeBrief& like) {
  return static_cast<double>(from.delay_s) + static_cast<double>(like.flight_s);
}

// Whether the simulated edge that leaves it can be part of a path.
inline bool usable_edge(const NodeBrief& b) { return (b.flags & kEdge) != 0 && (b.flags & kDubious) == 0; }

// Whether a node can be event k: the last one ends as asked (f_end), from any other a body goes on.
bool fits(const NodeBrief& node, const Targets& targets, std::size_t k);

// log f_a f_l f_c (eqs. 6 to 9) of a node that shall meet mark k on a path whose first event is that loud.
double log_sound(const NodeBrief& node, const Targets& targets, std::size_t k, double first_amplitude);

// One event of a path.
struct Step {
  std::uint32_t node;
  std::uint8_t element;  // of a splice that led here: the group element under which node - 1 was seen
  bool spliced;          // else the simulated edge of the step before led here (or it is the first step)
};

struct GraphPath {
  std::vector<Step> steps;
  double log_weight = 0.0;  // of all factors of all edges and of the events' sounds (eqs. 1 and 12)
  double log_bound =
      0.0;  // no path that the search could have found is better; log_weight where that is proven
};

}  // namespace ifa
