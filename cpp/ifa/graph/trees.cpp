#include "ifa/graph/trees.hpp"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>
#include <numbers>

#include "ifa/signature/factors.hpp"

namespace ifa {
namespace {

constexpr std::size_t kLeaf = 16;         // points
constexpr std::size_t kSampled = 10'000;  // nodes, for the typical scales

// Axes of a TreePoint.
constexpr std::size_t kFlight = 0, kLength = 1, kVelocity = 2, kSpin = 5, kUpward = 8, kCentroid = 11;

// Of exp(-c x^2).
double half_width(double log_factor_at_1) { return std::sqrt(-std::numbers::ln2 / log_factor_at_1); }

// nanoflann has one metric for an index and all its queries; what this thread's query sees comes beside it:
// the squared scales over the typical ones.
thread_local const std::array<double, kTreeDimensions>* query_weights = nullptr;

struct Points {
  std::vector<TreePoint> rows;

  std::size_t kdtree_get_point_count() const { return rows.size(); }
  float kdtree_get_pt(std::uint32_t row, std::size_t axis) const { return rows[row][axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

struct Metric {
  using ElementType = float;
  using DistanceType = double;

  explicit Metric(const Points& of) : points(of) {}

  double evalMetric(const float* at, std::uint32_t row, std::size_t) const {
    const auto& weights = *query_weights;
    double sum = 0.0;
    for (std::size_t a = 0; a < kTreeDimensions; ++a) {
      const double off = static_cast<double>(at[a]) - static_cast<double>(points.rows[row][a]);
      sum += weights[a] * off * off;
    }
    return sum;
  }
  double accum_dist(double a, double b, std::size_t axis) const {
    return (*query_weights)[axis] * (a - b) * (a - b);
  }

  const Points& points;
};

using Tree12 = nanoflann::KDTreeSingleIndexAdaptor<Metric, Points, kTreeDimensions, std::uint32_t>;

}  // namespace

struct ScaledTree::Index {
  Index(std::vector<TreePoint> rows, const TreePoint& typical_scales)
      : typical(typical_scales),
        points{scaled(std::move(rows))},
        tree(kTreeDimensions, points, nanoflann::KDTreeSingleIndexAdaptorParams(kLeaf)) {}

  std::vector<TreePoint> scaled(std::vector<TreePoint> rows) const {
    for (TreePoint& row : rows)
      for (std::size_t a = 0; a < kTreeDimensions; ++a) row[a] *= typical[a];
    return rows;
  }

  TreePoint typical;
  Points points;
  Tree12 tree;
};

ScaledTree::ScaledTree(std::vector<TreePoint> points, const TreePoint& typical_scales)
    : index_(std::make_unique<Index>(std::move(points), typical_scales)) {}
ScaledTree::ScaledTree(ScaledTree&&) noexcept = default;
ScaledTree& ScaledTree::operator=(ScaledTree&&) noexcept = default;
ScaledTree::~ScaledTree() = default;

std::vector<Neighbour> ScaledTree::nearest(const TreePoint& at, const TreePoint& scales,
                                           std::size_t count) const {
  count = std::min(count, index_->points.rows.size());
  if (count == 0) return {};
  TreePoint scaled_at;
  std::array<double, kTreeDimensions> weights;
  for (std::size_t a = 0; a < kTreeDimensions; ++a) {
    scaled_at[a] = at[a] * index_->typical[a];
    const double ratio = static_cast<double>(scales[a]) / static_cast<double>(index_->typical[a]);
    weights[a] = ratio * ratio;
  }
  std::vector<std::uint32_t> rows(count);
  std::vector<double> distances(count);
  query_weights = &weights;
  count = index_->tree.knnSearch(scaled_at.data(), count, rows.data(), distances.data());
  query_weights = nullptr;
  std::vector<Neighbour> found;
  for (std::size_t f = 0; f < count; ++f) found.push_back({rows[f], distances[f]});
  return found;
}

NodeTrees::NodeTrees(const Nodes& nodes, const Body& body)
    : nodes_(nodes),
      body_(body),
      terminal_(tree_of(true, typical_scales())),
      others_(tree_of(false, typical_scales())) {}

bool NodeTrees::flown_to(std::size_t m) const {
  return m > 0 && nodes_.flight_s[m - 1] > 0.0f && (nodes_.flags[m - 1] & kEdge) != 0 &&
         (nodes_.flags[m - 1] & kDubious) == 0;
}

NodeTrees::Tree NodeTrees::tree_of(bool terminal, const TreePoint& typical) const {
  std::vector<std::uint32_t> members;
  std::vector<TreePoint> points;
  for (std::uint32_t m = 1; m < nodes_.size(); ++m) {
    if (!flown_to(m) || ((nodes_.flags[m] & kTerminal) != 0) != terminal) continue;
    members.push_back(m);
    points.push_back(point(m - 1, nodes_.flight_s[m - 1], nodes_.length_s[m], nodes_.centroid_s[m]));
  }
  return {std::move(members), ScaledTree(std::move(points), typical)};
}

TreePoint NodeTrees::point(std::uint32_t take_off, double flight_s, double length_s,
                           double centroid_s) const {
  const float* off = nodes_.take_off.data() + 10 * static_cast<std::size_t>(take_off);  // up, velocity, spin
  TreePoint p;
  p[kFlight] = static_cast<float>(flight_s);
  p[kLength] = static_cast<float>(length_s);
  std::copy_n(off + 3, 3, p.begin() + kVelocity);
  std::copy_n(off + 6, 3, p.begin() + kSpin);
  std::copy_n(off, 3, p.begin() + kUpward);
  p[kCentroid] = static_cast<float>(centroid_s);
  return p;
}

TreePoint NodeTrees::scales(std::uint32_t take_off, double flight_s, double interval_s) const {
  const double time = half_width(log_time_factor(2.0, 1.0)) * interval_s;
  const double length = half_width(log_length_factor(1.0, 0.0));
  const double upward = half_width(log_orientation_factor(1.0, 1.0)) / kShortFlight_s;  // rad/s
  // The box about the box about the region, as the paper has it.
  const PlausibleRegion region = region_of(nodes_, take_off, body_);
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    velocity += region.velocity_offset(Vec6::Unit(axis)).cwiseAbs();
    spin += region.spin_offset(Vec6::Unit(3 + axis)).cwiseAbs();
  }
  const double edge = half_width(-1.0);  // of f_v, whose excess is 1 at the region's edge
  TreePoint s;
  s[kFlight] = static_cast<float>(1.0 / time);
  s[kLength] = s[kCentroid] = static_cast<float>(1.0 / length);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    s[kVelocity + axis] = static_cast<float>(1.0 / (edge * velocity[static_cast<int>(axis)]));
    s[kSpin + axis] = static_cast<float>(1.0 / (edge * spin[static_cast<int>(axis)]));
    s[kUpward + axis] = static_cast<float>(1.0 / (upward * std::min(flight_s, kShortFlight_s)));
  }
  return s;
}

TreePoint NodeTrees::typical_scales() const {
  std::array<std::vector<float>, kTreeDimensions> seen;
  const std::size_t step = std::max<std::size_t>(1, nodes_.size() / kSampled);
  for (std::size_t m = 1; m < nodes_.size(); m += step) {
    if (!flown_to(m)) continue;
    const double flight_s = nodes_.flight_s[m - 1];
    const TreePoint s = scales(static_cast<std::uint32_t>(m - 1), flight_s, flight_s);
    for (std::size_t a = 0; a < kTreeDimensions; ++a) seen[a].push_back(s[a]);
  }
  TreePoint typical;
  typical.fill(1.0f);
  for (std::size_t a = 0; a < kTreeDimensions && !seen[a].empty(); ++a) {
    const auto middle = seen[a].begin() + static_cast<std::ptrdiff_t>(seen[a].size() / 2);
    std::nth_element(seen[a].begin(), middle, seen[a].end());
    typical[a] = *middle;
  }
  return typical;
}

std::vector<Neighbour> NodeTrees::nearest(std::uint32_t i, const Targets& targets, std::size_t k,
                                          std::size_t count) const {
  const double interval_s = targets.intervals_s[k - 1];
  const double flight_s = interval_s - static_cast<double>(nodes_.delay_s[i]);
  if (flight_s <= 0.0) return {};
  const double duration_s = targets.durations_s[k], centroid_s = targets.centroids_s[k];
  const bool centroid = duration_s > 0.0 && !std::isnan(centroid_s);
  const TreePoint at = point(i, flight_s, duration_s, centroid ? centroid_s : 0.0);
  TreePoint s = scales(i, flight_s, interval_s);
  if (!centroid) s[kCentroid] = 0.0f;

  const bool last = k + 1 == targets.size();
  std::vector<Neighbour> found;
  const auto look = [&](const Tree& in) {
    for (const Neighbour& n : in.tree.nearest(at, s, count)) found.push_back({in.nodes[n.index], n.distance});
  };
  if (last) look(terminal_);
  if (!last || !targets.rest) look(others_);
  std::ranges::stable_sort(found, {}, &Neighbour::distance);
  if (found.size() > count) found.resize(count);
  return found;
}

}  // namespace ifa
