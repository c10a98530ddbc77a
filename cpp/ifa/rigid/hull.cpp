#include "ifa/rigid/hull.hpp"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <algorithm>
#include <cmath>
#include <cstdio>
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
    for (auto k = kept.rbegin(); is_new && k != kept.rend() && along[i] - along[*k] < 2 * kMergeTolerance; ++k)
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
    const int a = index(SETfirstt_(ridge->vertices, vertexT)), b = index(SETsecondt_(ridge->vertices, vertexT));
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

// Volume, first and second moments about one reference point.
struct Moments {
  double volume = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();

  // Adds a part whose own moments are about `p`.
  void add(const Moments& part, const Vec3& p) {
    volume += part.volume;
    first += part.first + part.volume * p;
    second += part.second + part.first * p.transpose() + p * part.first.transpose() + part.volume * p * p.transpose();
  }

  void add_solid(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles) {
    for (const auto& [i, j, k] : triangles) {  // tetrahedra with the reference point as their apex
      const Vec3 &a = vertices[i], &b = vertices[j], &c = vertices[k], s = a + b + c;
      const double six_volumes = a.dot(b.cross(c));
      volume += six_volumes / 6.0;
      first += six_volumes / 24.0 * s;
      second += six_volumes / 120.0 *
                (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
    }
  }

  // The rest of the body rounded by r: a prism on each face, a sector of a cylinder along each edge and a
  // sector of a ball at each vertex, all in closed form. Signed edge angles let coplanar triangles and
  // slivers cancel.
  void add_rounding(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles, double r);

  MassProperties finish(const Vec3& reference, double density) const {
    MassProperties out;
    out.volume_m3 = volume;
    out.mass_kg = density * volume;
    if (volume == 0.0) return out;
    const Vec3 centre = first / volume;
    const Mat3 spread = second - volume * centre * centre.transpose();
    out.centre_of_mass_m = reference + centre;
    out.inertia_kg_m2 = density * (spread.trace() * Mat3::Identity() - 0.5 * (spread + spread.transpose()));
    return out;
  }
};

void Moments::add_rounding(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles, double r) {
  std::vector<double> solid_angle(vertices.size(), 0.0);
  std::vector<Vec3> ball_first(vertices.size(), Vec3::Zero());
  std::vector<Mat3> ball_second(vertices.size(), Mat3::Zero());
  std::map<std::pair<int, int>, Vec3> normal_left_of;  // of the triangle on the left of a directed edge
  for (const Triangle& t : triangles) {
    const Vec3 &a = vertices[t[0]], &b = vertices[t[1]], &c = vertices[t[2]], s = a + b + c;
    const Vec3 twice = (b - a).cross(c - a);
    const double area = 0.5 * twice.norm();
    const Vec3 n = twice.stableNormalized();
    Moments prism;
    prism.volume = area * r;
    prism.first = area * (r / 3.0 * s + 0.5 * r * r * n);
    prism.second = area * (r / 12.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose()) +
                           r * r / 6.0 * (s * n.transpose() + n * s.transpose()) + r * r * r / 3.0 * n * n.transpose());
    add(prism, Vec3::Zero());
    for (int i = 0; i < 3; ++i) {
      const int v = t[i], next = t[(i + 1) % 3], last = t[(i + 2) % 3];
      const Vec3 to_next = vertices[next] - vertices[v], to_last = vertices[last] - vertices[v];
      solid_angle[v] -= std::atan2(to_next.cross(to_last).norm(), to_next.dot(to_last));
      normal_left_of[{v, next}] = n;
    }
  }
  for (const auto& [edge, n] : normal_left_of) {
    const auto other = normal_left_of.find({edge.second, edge.first});
    if (edge.first > edge.second || other == normal_left_of.end()) continue;
    const Vec3 along = vertices[edge.second] - vertices[edge.first];
    const double length = along.norm();
    const Vec3 e = along / length, t = e.cross(n);
    double angle = std::atan2(n.cross(other->second).dot(e), n.dot(other->second));
    if (angle < -0.5 * std::numbers::pi) angle += 2.0 * std::numbers::pi;  // a fold by pi, rounded to -pi
    const double sine = std::sin(angle), cosine = std::cos(angle);
    const Vec3 arc = sine * n + (1.0 - cosine) * t;  // integral of the unit normal over the arc
    const Mat3 arc_second = 0.5 * (angle + sine * cosine) * n * n.transpose() +
                            0.5 * (angle - sine * cosine) * t * t.transpose() +
                            0.5 * sine * sine * (n * t.transpose() + t * n.transpose());
    Moments sector;
    sector.volume = 0.5 * length * angle * r * r;
    sector.first = length * r * r * r / 3.0 * arc;
    sector.second = sector.volume * length * length / 12.0 * e * e.transpose() + length * std::pow(r, 4) / 4.0 * arc_second;
    add(sector, 0.5 * (vertices[edge.first] + vertices[edge.second]));
    // Gauss's theorem on the sphere: over the region of normals at a vertex, whose sides have the
    // outward conormals m, integral n = -1/2 sum m angle and integral n n' = 1/3 (area - sum m arc').
    ball_first[edge.first] -= 0.5 * angle * e;
    ball_first[edge.second] += 0.5 * angle * e;
    ball_second[edge.first] -= e * arc.transpose();
    ball_second[edge.second] += e * arc.transpose();
  }
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const double omega = solid_angle[v] + 2.0 * std::numbers::pi;  // the angle defect
    Moments sector;
    sector.volume = omega * r * r * r / 3.0;
    sector.first = std::pow(r, 4) / 4.0 * ball_first[v];
    sector.second = std::pow(r, 5) / 15.0 *
                    (omega * Mat3::Identity() + 0.5 * (ball_second[v] + ball_second[v].transpose()));
    add(sector, vertices[v]);
  }
}

// Both sides of a flat convex polygon, given by its corners in any order.
std::vector<Triangle> two_sided(const std::vector<Vec3>& corners, const Vec3& normal) {
  const Vec3 centre = std::accumulate(corners.begin(), corners.end(), Vec3(Vec3::Zero())) / corners.size();
  const Vec3 u = (corners[0] - centre).normalized(), w = normal.cross(u);
  std::vector<int> order(corners.size());
  std::iota(order.begin(), order.end(), 0);
  const auto angle = [&](int i) { return std::atan2(w.dot(corners[i] - centre), u.dot(corners[i] - centre)); };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return angle(a) < angle(b); });
  std::vector<Triangle> triangles;
  for (std::size_t i = 2; i < order.size(); ++i) triangles.push_back({order[0], order[i - 1], order[i]});
  // the other side as a fan about another corner, so that no diagonal lies on both sides
  std::reverse(order.begin(), order.end());
  for (std::size_t i = 2; i < order.size(); ++i) triangles.push_back({order[0], order[i - 1], order[i]});
  return triangles;
}

// A cylinder with half balls on its ends; a ball where both ends are one point.
Moments capsule(const Vec3& start, const Vec3& end, double r) {
  const double length = (end - start).norm();
  const Vec3 e = length > 0.0 ? Vec3((end - start) / length) : Vec3(Vec3::UnitX());
  const Mat3 along = e * e.transpose(), across = Mat3::Identity() - along;
  const double cylinder = std::numbers::pi * r * r * length, ball = 4.0 / 3.0 * std::numbers::pi * r * r * r;
  Moments part, out;
  part.volume = cylinder + ball;
  // half balls: mean of x^2 is r^2 / 5 and of |x| is 3 r / 8
  part.second = cylinder * (length * length / 12.0 * along + r * r / 4.0 * across) +
                ball * (r * r / 5.0 * Mat3::Identity() + (0.25 * length * length + 0.375 * length * r) * along);
  out.add(part, 0.5 * (start + end));
  return out;
}

}  // namespace

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

MassProperties mass_properties(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                               double density_kg_m3) {
  if (vertices.empty()) return {};
  // about the middle, for a mesh far from its origin would lose digits
  const Vec3 middle = unit_box(vertices).centre;
  std::vector<Vec3> local = vertices;
  for (Vec3& v : local) v -= middle;
  for (const Triangle& t : triangles)
    for (const int i : t)
      if (i < 0 || i >= static_cast<int>(vertices.size()))
        throw ArgumentError("triangles: index " + std::to_string(i) + " is outside the vertices");
  Moments moments;
  moments.add_solid(local, triangles);
  return moments.finish(middle, density_kg_m3);
}

MassProperties rounded_hull_mass_properties(const std::vector<Vec3>& vertices, double radius_m,
                                            double density_kg_m3) {
  if (!(radius_m >= 0.0) || !std::isfinite(radius_m))
    throw ArgumentError("radius_m: must be finite and not negative");
  const Vec3 middle = unit_box(vertices).centre;
  std::vector<Vec3> local = vertices;
  for (Vec3& v : local) v -= middle;
  const Hull hull = convex_hull(local);
  Moments moments;
  if (hull.vertices.size() <= 2) {
    moments = capsule(hull.vertices.front(), hull.vertices.back(), radius_m);
  } else {
    const std::vector<Triangle> triangles =
        hull.flat ? two_sided(hull.vertices, span_of(hull.vertices).normal) : hull.triangles;
    if (!hull.flat) moments.add_solid(hull.vertices, triangles);
    if (radius_m > 0.0) moments.add_rounding(hull.vertices, triangles, radius_m);
  }
  return moments.finish(middle, density_kg_m3);
}

}  // namespace ifa
