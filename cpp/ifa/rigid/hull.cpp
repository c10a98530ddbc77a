#include "ifa/rigid/hull.hpp"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "ifa/base/error.hpp"

namespace ifa {
namespace {

// Points closer than this share of the extent are one point; a set thinner than it is flat. It is far
// above rounding (1e-16) and far below any real thickness (a 0.01 mm plate of 1 m: 1e-5).
constexpr double kMergeTolerance = 1e-9;

struct Unit {
  Vec3 centre;
  double scale;  // a power of two, so that scaling a body by powers of two keeps every bit
};

Unit unit_box(const std::vector<Vec3>& points) {
  if (points.empty()) throw ArgumentError("vertices_m: at least one point is needed");
  Vec3 low = points.front(), high = points.front();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite())
      throw ArgumentError("vertices_m: point " + std::to_string(i) + " has a coordinate that is not finite");
    low = low.cwiseMin(points[i]);
    high = high.cwiseMax(points[i]);
  }
  const double extent = (high - low).maxCoeff();
  if (!(extent < 1e150)) throw ArgumentError("vertices_m: the points lie too far apart to compute with");
  int exponent = 0;
  std::frexp(extent, &exponent);
  // a size below 1e-150 m is a point
  return {0.5 * (low + high), extent > 1e-150 ? std::ldexp(1.0, -exponent) : 1.0};
}

// Indices of the points that stay when near duplicates are merged, ascending. Points are sorted along
// a direction of irrational slopes, so that only true neighbours come close in it.
std::vector<int> distinct(const std::vector<Vec3>& unit_points) {
  const Vec3 direction(0.54772255750516612, 0.31415926535897931, 0.77542218478128212);
  std::vector<double> along(unit_points.size());
  for (std::size_t i = 0; i < along.size(); ++i) along[i] = direction.dot(unit_points[i]);
  std::vector<int> order(unit_points.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return along[a] != along[b] ? along[a] < along[b] : a < b; });
  std::vector<int> kept;
  for (const int i : order) {
    bool is_new = true;
    for (auto k = kept.rbegin(); is_new && k != kept.rend() && along[i] - along[*k] < 2 * kMergeTolerance;
         ++k)
      is_new = (unit_points[i] - unit_points[*k]).norm() > kMergeTolerance;
    if (is_new) kept.push_back(i);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

// The affine span of points: dimension 0 to 3, with the direction of a line or the normal of a plane.
struct Span {
  int dimension = 0;
  int line_start = 0, line_end = 0;
  Vec3 normal = Vec3::Zero();
};

Span span_of(const std::vector<Vec3>& points) {
  const auto farthest = [&](auto&& distance) {
    int best = 0;
    for (int i = 1; i < static_cast<int>(points.size()); ++i)
      if (distance(points[i]) > distance(points[best])) best = i;
    return std::pair{best, distance(points[best])};
  };
  Span span;
  span.line_start = farthest([&](const Vec3& p) { return (p - points[0]).norm(); }).first;
  const Vec3 origin = points[span.line_start];
  const auto [end, length] = farthest([&](const Vec3& p) { return (p - origin).norm(); });
  span.line_end = end;
  if (length == 0.0) return span;
  const Vec3 axis = (points[end] - origin) / length;
  const auto [side, width] = farthest([&](const Vec3& p) { return axis.cross(p - origin).norm(); });
  span.dimension = 1;
  if (width <= kMergeTolerance * length) return span;
  span.normal = axis.cross(points[side] - origin).normalized();
  const double height = farthest([&](const Vec3& p) { return std::abs(span.normal.dot(p - origin)); }).second;
  span.dimension = height <= kMergeTolerance * length ? 2 : 3;
  return span;
}

struct CloseFile {
  void operator()(std::FILE* f) const { std::fclose(f); }
};

// Owns Qhull's state and the silent stream for its messages, for it takes no null stream.
class Qhull {
 public:
  Qhull() : quiet_(std::fopen("/dev/null", "w")) {
    if (!quiet_) quiet_.reset(std::tmpfile());
    if (!quiet_) throw FileError("/dev/null: cannot be opened for the messages of the hull computation");
    qh_zero(&state_, quiet_.get());
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;
  ~Qhull() {
    int left, total;
    qh_freeqhull(&state_, !qh_ALL);
    qh_memfreeshort(&state_, &left, &total);
  }

  // qh_new_qhull catches every error of Qhull's by longjmp and returns its code. Only plain data
  // lives between, and nothing of Qhull's that may fail is called later.
  bool run(std::vector<double>& coordinates, const char* options) {
    std::string command = options;
    return qh_new_qhull(&state_, 3, static_cast<int>(coordinates.size() / 3), coordinates.data(), False,
                        command.data(), nullptr, quiet_.get()) == 0;
  }

  qhT* state() { return &state_; }

 private:
  qhT state_;
  std::unique_ptr<std::FILE, CloseFile> quiet_;
};

// The corners of a facet in order around it. A merged facet is a polygon whose edges are its ridges.
std::vector<int> facet_polygon(facetT* facet, const coordT* first_point) {
  const auto index = [&](vertexT* v) { return static_cast<int>((v->point - first_point) / 3); };
  std::vector<int> polygon;
  vertexT *vertex, **vertexp;
  if (facet->simplicial) {
    FOREACHvertex_(facet->vertices) polygon.push_back(index(vertex));
    return polygon;
  }
  std::multimap<int, int> next;
  ridgeT *ridge, **ridgep;
  FOREACHridge_(facet->ridges) {
    const int a = index(SETfirstt_(ridge->vertices, vertexT)),
              b = index(SETsecondt_(ridge->vertices, vertexT));
    next.emplace(a, b);
    next.emplace(b, a);
  }
  if (next.empty()) return polygon;
  int here = next.begin()->first;
  for (auto step = next.find(here); step != next.end(); step = next.find(here)) {
    const int there = step->second;
    next.erase(step);
    for (auto back = next.lower_bound(there); back != next.upper_bound(there); ++back)
      if (back->second == here) {
        next.erase(back);
        break;
      }
    polygon.push_back(here);
    here = there;
  }
  return polygon;
}

// Triangles of the hull, by indices into `points`, whose span is a volume; none if Qhull gives up.
std::vector<Triangle> hull_triangles(const std::vector<Vec3>& points) {
  std::vector<double> coordinates;
  coordinates.reserve(3 * points.size());
  for (const Vec3& p : points) coordinates.insert(coordinates.end(), p.data(), p.data() + 3);
  // Q12 lets Qhull go on with facets that rounding made wide; only where it refused without it.
  for (const char* options : {"qhull Pp", "qhull Pp Q12"}) {
    Qhull qhull;
    if (!qhull.run(coordinates, options)) continue;
    qhT* const qh = qhull.state();
    std::vector<Triangle> triangles;
    facetT* facet;
    FORALLfacets {
      std::vector<int> polygon = facet_polygon(facet, qh->first_point);
      if (polygon.size() < 3) continue;
      Vec3 area = Vec3::Zero();
      for (std::size_t i = 2; i < polygon.size(); ++i)
        area += (points[polygon[i - 1]] - points[polygon[0]]).cross(points[polygon[i]] - points[polygon[0]]);
      if (area.dot(Eigen::Map<const Vec3>(facet->normal)) < 0) std::reverse(polygon.begin(), polygon.end());
      for (std::size_t i = 2; i < polygon.size(); ++i)
        triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
    }
    return triangles;
  }
  return {};
}

// The point nearest to the origin of the simplex of at most four points, of which only those that carry it
// are kept. Tries every face; a degenerate one only gives a point that is no nearer.
Vec3 nearest_of_simplex(std::vector<Vec3>& simplex) {
  Vec3 nearest = simplex.front();
  std::vector<Vec3> carriers{nearest};
  for (unsigned chosen = 1; chosen < 1u << simplex.size(); ++chosen) {
    std::vector<Vec3> face;
    for (std::size_t i = 0; i < simplex.size(); ++i)
      if (chosen >> i & 1u) face.push_back(simplex[i]);
    Vec3 point = face.front();
    if (face.size() > 1) {
      Eigen::Matrix<double, 3, Eigen::Dynamic> edges(3, face.size() - 1);
      for (std::size_t i = 1; i < face.size(); ++i) edges.col(i - 1) = face[i] - face.front();
      const Eigen::VectorXd shares = edges.colPivHouseholderQr().solve(-face.front());
      if (shares.minCoeff() < 0.0 || shares.sum() > 1.0) continue;
      point += edges * shares;
    }
    if (point.squaredNorm() < nearest.squaredNorm()) {
      nearest = point;
      carriers = face;
    }
  }
  simplex = carriers;
  return nearest;
}

// Of the hull of the points from the origin (Gilbert, Johnson and Keerthi 1988). Stops where rounding ends
// the progress, and so is never too small.
double distance_m(const std::vector<Vec3>& points) {
  std::vector<Vec3> simplex{points.front()};
  Vec3 nearest = points.front();
  for (;;) {
    simplex.push_back(*std::min_element(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) {
      return nearest.dot(a) < nearest.dot(b);
    }));
    const Vec3 next = nearest_of_simplex(simplex);
    if (!(next.squaredNorm() < nearest.squaredNorm()) || simplex.size() > 3) return next.norm();
    nearest = next;
  }
}

}  // namespace

void check_rings(std::vector<Ring>& rings) {
  if (rings.size() > kMostRings)
    throw ArgumentError("rings_m: there are " + std::to_string(rings.size()) + " circular edges, at most " +
                        std::to_string(kMostRings) + " are possible");
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const auto need_row = [&](bool condition, const char* message) {
      if (!condition) throw ArgumentError("rings_m: row " + std::to_string(i) + message);
    };
    Ring& ring = rings[i];
    need_row(ring.centre_m.allFinite() && ring.axis.allFinite() && std::isfinite(ring.radius_m),
             " has a number that is not finite");
    need_row(ring.radius_m > 0.0, ": its radius must be above 0");
    need_row(ring.axis.stableNorm() > 0.0, ": its axis must not be zero");
    const double length = ring.axis.stableNorm();
    // one that has been a unit vector keeps its bits
    if (std::abs(length - 1.0) > 4e-16) ring.axis.stableNormalize();
  }
}

std::vector<Vec3> ring_points(const std::vector<Ring>& rings, int points_each) {
  std::vector<Vec3> points;
  for (const Ring& ring : rings) {
    const Vec3 u = ring.axis.unitOrthogonal(), v = ring.axis.cross(u);
    for (int i = 0; i < points_each; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / points_each;
      points.push_back(ring.centre_m + ring.radius_m * (std::cos(angle) * u + std::sin(angle) * v));
    }
  }
  return points;
}

Hull convex_hull(const std::vector<Vec3>& points) {
  const auto [centre, scale] = unit_box(points);
  std::vector<Vec3> unit_points(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) unit_points[i] = (points[i] - centre) * scale;
  std::vector<int> kept = distinct(unit_points);
  std::vector<Vec3> candidates;
  for (const int i : kept) candidates.push_back(unit_points[i]);

  const Span span = span_of(candidates);
  Hull hull;
  hull.flat = span.dimension < 3;
  if (span.dimension == 0) {
    hull.vertices = {points[kept[0]]};
    return hull;
  }
  if (span.dimension == 1) {
    const auto [first, second] = std::minmax(span.line_start, span.line_end);
    hull.vertices = {points[kept[first]], points[kept[second]]};
    return hull;
  }
  const int n = static_cast<int>(candidates.size());
  if (hull.flat) {  // two apexes beside the plane make a solid with the same rim
    const Vec3 middle = std::accumulate(candidates.begin(), candidates.end(), Vec3(Vec3::Zero())) / n;
    candidates.push_back(middle + span.normal);
    candidates.push_back(middle - span.normal);
  }
  const std::vector<Triangle> triangles = hull_triangles(candidates);
  if (triangles.empty()) throw ArgumentError("vertices_m: their convex hull cannot be computed");
  std::vector<int> position(candidates.size(), -1);
  for (const Triangle& t : triangles)
    for (const int i : t) position[i] = 0;
  for (int i = 0; i < n; ++i) {
    if (position[i] < 0) continue;
    position[i] = static_cast<int>(hull.vertices.size());
    hull.vertices.push_back(points[kept[i]]);
  }
  if (!hull.flat)
    for (const auto& [i, j, k] : triangles) hull.triangles.push_back({position[i], position[j], position[k]});
  return hull;
}

double least_reach_m(const std::vector<Vec3>& points) {
  const Hull hull = convex_hull(points);
  double least = hull.flat ? -1.0 : std::numeric_limits<double>::infinity();
  for (const auto& [i, j, k] : hull.triangles) {
    const Vec3 &a = hull.vertices[i], &b = hull.vertices[j], &c = hull.vertices[k];
    least = std::min(least, (b - a).cross(c - a).normalized().dot(a));
  }
  return least >= 0.0 ? least : -distance_m(hull.vertices);
}

}  // namespace ifa
