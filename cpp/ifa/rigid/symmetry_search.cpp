#include "ifa/rigid/symmetry_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>
#include <utility>

#include "ifa/rigid/near_points.hpp"

namespace ifa {
namespace {

using Elements = std::vector<SymmetryElement>;

// The body in units of its bounding radius and its largest moment.
class Shape {
 public:
  Shape(const Body& body, double tolerance);

  bool maps_onto_itself(const Mat3& g) const { return inertia_fits(g) && rings_fit(g) && vertices_fit(g); }

  // A place that the group must carry to places alike.
  struct Feature {
    Vec3 at;
    int kind;  // vertex, pole of a ring, tip of a principal axis
    double moment;
    int likeness = 0;  // the same for all that could be images of each other (and by chance for others)
  };
  std::vector<Feature> hull_features() const;
  std::vector<Feature> inertia_features() const;

  double tolerance() const { return tolerance_; }

 private:
  struct HalfSpace {
    Vec3 normal;
    double offset;
  };

  bool inertia_fits(const Mat3& g) const;
  bool rings_fit(const Mat3& g) const;
  bool vertices_fit(const Mat3& g) const;
  void find_corners(const Hull& hull);
  Feature feature(const Vec3& at, int kind) const { return {at, kind, at.dot(moments_.cwiseProduct(at))}; }

  double tolerance_;
  Vec3 moments_;
  std::vector<Ring> rings_;
  std::vector<Vec3> vertices_;
  std::vector<bool> is_corner_;  // of each vertex: not just noise on a face or an edge
  std::vector<HalfSpace>
      inside_;  // of which the hull is the intersection; none where it is flat or has rings
  NearPoints near_vertices_{{}};
};

Shape::Shape(const Body& body, double tolerance)
    : tolerance_(tolerance), moments_(body.principal_inertia() / body.principal_inertia().maxCoeff()) {
  const double scale = 1.0 / body.bounding_radius_m();
  for (const Vec3& p : body.principal_vertices()) vertices_.push_back(scale * p);
  for (const Ring& ring : body.principal_rings())
    rings_.push_back({scale * ring.centre_m, ring.axis, scale * ring.radius_m});
  is_corner_.assign(vertices_.size(), true);
  if (rings_.empty() && vertices_.size() > 3)
    if (Hull hull = convex_hull(vertices_); !hull.flat) {
      vertices_ = hull.vertices;
      find_corners(hull);
    }
  near_vertices_ = NearPoints(vertices_);
}

// How far a vertex stands out from the hull of the others is at least its lead over its neighbours along any
// direction in which it is extreme, such as the mean of its faces' normals: the runner-up is a neighbour.
void Shape::find_corners(const Hull& hull) {
  std::vector<Vec3> outwards(vertices_.size(), Vec3::Zero());
  for (const Triangle& t : hull.triangles) {
    const Vec3 &a = vertices_[t[0]], &b = vertices_[t[1]], &c = vertices_[t[2]];
    const Vec3 area = (b - a).cross(c - a);
    if (!(area.norm() > 0.0)) continue;
    const Vec3 normal = area.normalized();
    inside_.push_back({normal, std::max({normal.dot(a), normal.dot(b), normal.dot(c)})});
    for (const int i : t) outwards[i] += normal;
  }
  std::vector<double> lead(vertices_.size(), 1.0);
  for (const Triangle& t : hull.triangles)
    for (int k = 0; k < 3; ++k)
      for (const int other : {t[(k + 1) % 3], t[(k + 2) % 3]})
        lead[t[k]] =
            std::min(lead[t[k]], outwards[t[k]].normalized().dot(vertices_[t[k]] - vertices_[other]));
  for (std::size_t i = 0; i < vertices_.size(); ++i) is_corner_[i] = lead[i] > 4.0 * tolerance_;
}

bool Shape::inertia_fits(const Mat3& g) const {
  const Mat3 carried = g * moments_.asDiagonal() * g.transpose();
  return (carried - Mat3(moments_.asDiagonal())).cwiseAbs().maxCoeff() <= tolerance_;
}

bool Shape::rings_fit(const Mat3& g) const {
  return std::all_of(rings_.begin(), rings_.end(), [&](const Ring& ring) {
    const Vec3 centre = g * ring.centre_m, axis = g * ring.axis;
    return std::any_of(rings_.begin(), rings_.end(), [&](const Ring& other) {
      return (centre - other.centre_m).norm() <= tolerance_ &&
             std::abs(ring.radius_m - other.radius_m) <= tolerance_ &&
             ring.radius_m * axis.cross(other.axis).norm() <= tolerance_;
    });
  });
}

bool Shape::vertices_fit(const Mat3& g) const {
  return std::all_of(vertices_.begin(), vertices_.end(), [&](const Vec3& vertex) {
    const Vec3 p = g * vertex;
    if (near_vertices_.first_within(p, tolerance_) >= 0) return true;
    // noise on a face, where the other side has none
    return !inside_.empty() && std::all_of(inside_.begin(), inside_.end(), [&](const HalfSpace& half) {
      return half.normal.dot(p) <= half.offset + tolerance_;
    });
  });
}

std::vector<Shape::Feature> Shape::hull_features() const {
  std::vector<Feature> features;
  for (std::size_t i = 0; i < vertices_.size(); ++i)
    if (is_corner_[i]) features.push_back(feature(vertices_[i], 0));
  if (features.empty())
    for (const Vec3& p : vertices_) features.push_back(feature(p, 0));
  for (const Ring& ring : rings_)
    for (const double side : {1.0, -1.0})
      features.push_back(feature(ring.centre_m + side * ring.radius_m * ring.axis, 1));
  return features;
}

// Where the hull leaves a turn open, the inertia may not.
std::vector<Shape::Feature> Shape::inertia_features() const {
  std::vector<Feature> features;
  for (int i = 0; i < 3; ++i) {
    const double nearest = std::min(std::abs(moments_[i] - moments_[(i + 1) % 3]),
                                    std::abs(moments_[i] - moments_[(i + 2) % 3]));
    if (nearest > tolerance_)
      for (const double side : {1.0, -1.0}) features.push_back(feature(side * Vec3::Unit(i), 2 + i));
  }
  return features;
}

// Drops what is there twice and gives each feature its likeness: features sorted by kind, distance and moment
// are of one likeness as long as no gap between them is above the tolerance.
void sort_by_likeness(std::vector<Shape::Feature>& features, double tolerance) {
  std::vector<Vec3> places;
  for (const auto& f : features) places.push_back(f.at);
  const NearPoints near(places);
  std::vector<Shape::Feature> kept;
  for (std::size_t i = 0; i < features.size(); ++i)
    if (near.first_within(places[i], 2.0 * tolerance) == static_cast<int>(i)) kept.push_back(features[i]);
  features = std::move(kept);

  std::vector<int> order(features.size());
  std::iota(order.begin(), order.end(), 0);
  const auto split = [&](const auto& key, double gap) {
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      const auto &p = features[a], &q = features[b];
      return std::tuple(p.likeness, key(p)) < std::tuple(q.likeness, key(q));
    });
    int next = 0;
    std::vector<int> likeness(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i > 0) {
        const auto &p = features[order[i - 1]], &q = features[order[i]];
        next += p.likeness != q.likeness || key(q) - key(p) > gap;
      }
      likeness[order[i]] = next;
    }
    for (std::size_t i = 0; i < order.size(); ++i) features[i].likeness = likeness[i];
  };
  split([](const auto& f) { return static_cast<double>(f.kind); }, 0.5);
  split([](const auto& f) { return f.at.norm(); }, 2.0 * tolerance);
  split([](const auto& f) { return f.moment; }, 4.0 * tolerance);
}

// Of the features that are at least half as far out as any (for maps to be exact), one of those that have the
// fewest alike (for few maps to try). -1 where none is further out than the tolerance.
template <class Distance>
int reference(const std::vector<Shape::Feature>& features, double tolerance, const Distance& distance) {
  double farthest = 0.0;
  std::vector<int> alike(features.size(), 0);
  for (const auto& f : features) {
    farthest = std::max(farthest, distance(f.at));
    ++alike[f.likeness];
  }
  if (!(farthest > tolerance)) return -1;
  int best = -1;
  for (int i = 0; i < static_cast<int>(features.size()); ++i)
    if (distance(features[i].at) >= 0.5 * farthest &&
        (best < 0 || alike[features[i].likeness] < alike[features[best].likeness]))
      best = i;
  return best;
}

// Axes from a towards b; `side` flips the third.
Mat3 frame(const Vec3& a, const Vec3& b, double side) {
  Mat3 axes;
  axes.col(0) = a.normalized();
  axes.col(1) = (b - b.dot(axes.col(0)) * axes.col(0)).normalized();
  axes.col(2) = side * axes.col(0).cross(axes.col(1)).normalized();
  return axes;
}

// All maps that carry the features a and b, not in line with the origin, to a pair alike, and fit.
Elements maps_of_pair(const Shape& shape, const std::vector<Shape::Feature>& features, int a, int b) {
  const auto alike = [&](int i) {
    std::vector<int> found;
    for (int k = 0; k < static_cast<int>(features.size()); ++k)
      if (features[k].likeness == features[i].likeness) found.push_back(k);
    return found;
  };
  const std::vector<int> starts = alike(a), ends = alike(b);
  const Vec3 &from = features[a].at, &to = features[b].at;
  const double angle = from.dot(to);
  const Mat3 back = frame(from, to, 1.0).transpose();
  Elements elements{{Mat3::Identity(), true}};
  for (const int p : starts)
    for (const int q : ends) {
      const Vec3 &start = features[p].at, &end = features[q].at;
      if (std::abs(start.dot(end) - angle) > 4.0 * shape.tolerance()) continue;
      if (start.cross(end).norm() < 0.25 * from.cross(to).norm())
        continue;  // by the tolerance, in a thin body
      for (const double side : {1.0, -1.0}) {
        if (p == a && q == b && side > 0.0) continue;
        const Mat3 g = frame(start, end, side) * back;
        if (shape.maps_onto_itself(g)) elements.push_back({g, side > 0.0});
      }
    }
  std::stable_partition(elements.begin(), elements.end(), [](const SymmetryElement& g) { return g.proper; });
  return elements;
}

// Of a group about one axis with very many turns: the elements that keep a regular polygon, of the largest
// number of corners that leaves few enough of them.
Elements few_enough(const Elements& group) {
  if (group.size() <= Symmetry::kMostElements) return group;
  constexpr double kNoise = 1e-4;
  double least = 4.0;
  Vec3 axis = kUp;
  for (const SymmetryElement& g : group)
    if (const Eigen::AngleAxisd turn(g.map); g.proper && turn.angle() > kNoise && turn.angle() < least) {
      least = turn.angle();
      axis = turn.axis();
    }
  const int turns = static_cast<int>(std::lround(2.0 * std::numbers::pi / least));
  // a corner on a mirror or on the axis of a half turn, so that these keep the polygon
  Vec3 corner = across(axis);
  for (const SymmetryElement& g : group) {
    const bool is_mirror = !g.proper && (g.map * axis - axis).norm() < kNoise;
    const bool is_half_turn = g.proper && (g.map * axis + axis).norm() < kNoise;
    if (!is_mirror && !is_half_turn) continue;
    const Mat3 twice = Mat3::Identity() + g.map;  // projects twice onto what stays
    const Vec3 first = across(axis), second = axis.cross(first);
    const Vec3 stays = twice * first, other = twice * second;
    corner = (stays.norm() > other.norm() ? stays : other);
    corner = (corner - corner.dot(axis) * axis).normalized();
    break;
  }
  const Vec3 second = axis.cross(corner);
  for (int corners = turns; corners > 0; --corners) {
    if (turns % corners != 0) continue;
    Elements kept;
    for (const SymmetryElement& g : group) {
      const Vec3 p = g.map * corner;
      const double part = std::atan2(second.dot(p), corner.dot(p)) / (2.0 * std::numbers::pi) * corners;
      if (std::abs(part - std::round(part)) < kNoise * corners) kept.push_back(g);
    }
    if (kept.size() <= Symmetry::kMostElements) return kept;
  }
  return {group.front()};
}

bool closed(const Elements& elements) {
  const Vec3 d = generic_direction(elements);
  std::vector<Vec3> orbit;
  double apart = 2.0;
  for (const SymmetryElement& g : elements) {
    orbit.push_back(g.map * d);
    if (orbit.size() > 1) apart = std::min(apart, (orbit.back() - d).norm());
  }
  const NearPoints near(orbit);
  for (const SymmetryElement& g : elements)
    for (std::size_t i = 0; i < orbit.size(); ++i) {
      // the orbit finds the product among many elements; of one that is missing it says nothing
      const int k = near.first_within(g.map * orbit[i], 0.1 * apart);
      if (k < 0 || (g.map * elements[i].map - elements[k].map).norm() > 0.1 * apart) return false;
    }
  return true;
}

FoundSymmetry search(const Body& body, double tolerance) {
  const Shape shape(body, tolerance);
  std::vector<Shape::Feature> features = shape.hull_features();
  const auto from_origin = [](const Vec3& p) { return p.norm(); };
  for (const bool with_inertia : {false, true}) {
    if (with_inertia) {
      const auto tips = shape.inertia_features();
      features.insert(features.end(), tips.begin(), tips.end());
    }
    sort_by_likeness(features, tolerance);
    const int a = reference(features, tolerance, from_origin);
    if (a < 0 && with_inertia) return {Symmetry::Kind::ball, kUp, {{Mat3::Identity(), true}}};
    if (a < 0) continue;
    const Vec3 axis = features[a].at.normalized();
    const int b = reference(features, tolerance, [&](const Vec3& p) { return axis.cross(p).norm(); });
    if (b >= 0) return {Symmetry::Kind::finite, axis, few_enough(maps_of_pair(shape, features, a, b))};
    if (!with_inertia) continue;
    FoundSymmetry found{Symmetry::Kind::axial, axis, {{Mat3::Identity(), true}}};
    const Mat3 flip = Eigen::AngleAxisd(std::numbers::pi, across(axis)).toRotationMatrix();
    if (shape.maps_onto_itself(flip)) found.elements.push_back({flip, true});
    return found;
  }
  return {};  // not reached: the second turn returns
}

}  // namespace

Vec3 across(const Vec3& axis) {
  int most = 0;
  axis.cwiseAbs().minCoeff(&most);
  const Vec3 unit = Vec3::Unit(most);
  return (unit - unit.dot(axis) * axis).normalized();
}

Vec3 generic_direction(const Elements& elements) {
  constexpr int kTried = 64;  // points of a spiral of golden angles
  Vec3 best = kUp;
  double largest = -1.0;
  for (int i = 0; i < kTried; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kTried, around = 2.399963229728653 * i;
    const Vec3 d(std::sqrt(1.0 - z * z) * std::cos(around), std::sqrt(1.0 - z * z) * std::sin(around), z);
    double least = 2.0;
    for (std::size_t k = 1; k < elements.size(); ++k)
      least = std::min(least, (elements[k].map * d - d).norm());
    if (least > largest) {
      largest = least;
      best = d;
    }
  }
  return best;
}

FoundSymmetry find_symmetry(const Body& body, double tolerance) {
  constexpr double kLeast = 1e-12;  // above rounding
  for (double t = tolerance; t > kLeast; t *= 0.1) {
    FoundSymmetry found = search(body, t);
    if (found.kind != Symmetry::Kind::finite || closed(found.elements)) return found;
  }
  return {Symmetry::Kind::finite, kUp, {{Mat3::Identity(), true}}};
}

}  // namespace ifa
