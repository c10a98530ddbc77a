// The paper's two 12-dimensional k-d trees, of the terminal nodes and of the others: which flights could be
// flown from a take-off to meet a mark (paper section 5.5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "ifa/graph/search.hpp"
#include "ifa/graph/weights.hpp"

namespace ifa {

inline constexpr std::size_t kTreeDimensions = 12;
using TreePoint = std::array<float, kTreeDimensions>;

struct Neighbour {
  std::uint32_t index;
  double distance;  // sum over the axes of (scale times difference)^2
};

// Points in a metric whose scales come with each query.
class ScaledTree {
 public:
  // Scales like most queries': the tree splits where such a query sees the points farthest apart, whatever
  // the units. In the units of nature a search is slower than to look at every point.
  ScaledTree(std::vector<TreePoint> points, const TreePoint& typical_scales);
  ScaledTree(ScaledTree&&) noexcept;
  ScaledTree& operator=(ScaledTree&&) noexcept;
  ~ScaledTree();

  // The `count` nearest, or all if there are fewer, the nearest first.
  std::vector<Neighbour> nearest(const TreePoint& at, const TreePoint& scales, std::size_t count) const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

// A node m that a flight of its own simulation, from j = m - 1, leads to is a point: flight time of j; length
// of m's event; velocity and spin of j's take-off; `up` there, in place of the three angles that the body's
// axes make with the normal (which are those of `up`, and fold what is upside down); centroid of m's event.
class NodeTrees {
 public:
  // What `nodes` looks at, and `body`, must outlive it.
  NodeTrees(const Nodes& nodes, const Body& body);

  // Nodes whose flights could be flown from i to meet mark k, the nearest first; terminal ones or others as
  // mark k asks, of an open ending's last mark both. Scales are one over the half width of each factor; of
  // velocity and spin that of the box about i's plausible region. None where i must take off after mark k.
  std::vector<Neighbour> nearest(std::uint32_t i, const Targets& targets, std::size_t k,
                                 std::size_t count) const;

 private:
  struct Tree {
    std::vector<std::uint32_t> nodes;  // of its points
    ScaledTree tree;
  };
  Tree tree_of(bool terminal, const TreePoint& typical) const;
  TreePoint point(std::uint32_t take_off, double flight_s, double length_s, double centroid_s) const;
  TreePoint scales(std::uint32_t take_off, double flight_s, double interval_s) const;
  TreePoint typical_scales() const;
  bool flown_to(std::size_t m) const;

  Nodes nodes_;
  const Body& body_;
  Tree terminal_, others_;
};

}  // namespace ifa
