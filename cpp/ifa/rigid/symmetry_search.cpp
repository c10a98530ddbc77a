#include "ifa/rigid/symmetry_search.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>
#include <tuple>
#include <utility>

#include "ifa/rigid/near_points.hpp"
#include "ifa/rigid/symmetry_shape.hpp"

namespace ifa {
namespace {

using Elements = std::vector<SymmetryElement>;

// Drops what is there twice and gives each feature its likeness: features sorted by kind, distance and moment
// are of one likeness as long as no gap between them is above the tolerance.
void sort_by_likeness(std::vector<SymmetryShape::Feature>& features, double tolerance) {
  std::vector<Vec3> places;
  for (const auto& f : features) places.push_back(f.at);
  const NearPoints near(places);
  std::vector<SymmetryShape::Feature> kept;
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
int reference(const std::vector<SymmetryShape::Feature>& features, double tolerance,
              const Distance& distance) {
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

// All maps that carry the features a and b, not in line with the origin, to a pair alike, and seem to fit.
Elements maps_of_pair(const SymmetryShape& shape, const std::vector<SymmetryShape::Feature>& features, int a,
                      int b) {
  const auto alike = [&](int i) {
    std::vector<int> found;
    for (int k = 0; k < static_cast<int>(features.size()); ++k)
      if (features[k].likeness == features[i].likeness) found.push_back(k);
    return found;
  };
  const std::vector<int> starts = alike(a), ends = alike(b);
  std::vector<Vec3> places;
  for (const int q : ends) places.push_back(features[q].at);
  Projected all_ends(places);
  const Vec3 &from = features[a].at, &to = features[b].at;
  const double product = from.dot(to);
  const Mat3 back = frame(from, to, 1.0).transpose();
  Elements elements{{Mat3::Identity(), true}};
  for (const int p : starts) {
    const Vec3& start = features[p].at;
    const Eigen::ArrayXd& products = all_ends.on(start);
    for (std::size_t k = 0; k < ends.size(); ++k) {
      if (std::abs(products[static_cast<Eigen::Index>(k)] - product) > 4.0 * shape.tolerance()) continue;
      const Vec3& end = features[ends[k]].at;
      if (start.cross(end).norm() < 0.25 * from.cross(to).norm())
        continue;  // by the tolerance, in a thin body
      for (const double side : {1.0, -1.0}) {
        if (p == a && ends[k] == b && side > 0.0) continue;
        const Mat3 g = frame(start, end, side) * back;
        if (shape.may_map(g)) elements.push_back({g, side > 0.0});
      }
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

// The group among maps that seem to fit; empty if those that do are none.
Elements finite_group(const SymmetryShape& shape, const Elements& maps) {
  const auto fits = [&](const SymmetryElement& g) { return shape.maps_onto_itself(g.map); };
  if (maps.size() > Symmetry::kMostElements) {  // look at thousands only where a few of them do not fit
    Elements few = few_enough(maps);
    if (std::all_of(few.begin() + 1, few.end(), fits) && closed(few)) return few;
  }
  Elements fitting{maps.front()};  // the identity
  std::copy_if(maps.begin() + 1, maps.end(), std::back_inserter(fitting), fits);
  fitting = few_enough(fitting);
  return closed(fitting) ? fitting : Elements{};
}

FoundSymmetry search(const Body& body, double tolerance) {
  const SymmetryShape shape(body, tolerance);
  std::vector<SymmetryShape::Feature> features = shape.hull_features();
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
    if (b >= 0)
      return {Symmetry::Kind::finite, axis, finite_group(shape, maps_of_pair(shape, features, a, b))};
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
    if (!found.elements.empty()) return found;
  }
  return {Symmetry::Kind::finite, kUp, {{Mat3::Identity(), true}}};
}

}  // namespace ifa
