#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "ifa/base/error.hpp"
#include "ifa/rigid/hull.hpp"

namespace ifa {
namespace {

// Volume, first and second moments about one reference point.
struct Moments {
  double volume = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();

  // Adds a part whose own moments are about `p`.
  void add(const Moments& part, const Vec3& p) {
    volume += part.volume;
    first += part.first + part.volume * p;
    second += part.second + part.first * p.transpose() + p * part.first.transpose() +
              part.volume * p * p.transpose();
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

void Moments::add_rounding(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                           double r) {
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
    prism.second =
        area * (r / 12.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose()) +
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
    sector.second = sector.volume * length * length / 12.0 * e * e.transpose() +
                    length * std::pow(r, 4) / 4.0 * arc_second;
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

Vec3 mean(const std::vector<Vec3>& points) {
  return std::accumulate(points.begin(), points.end(), Vec3(Vec3::Zero())) /
         static_cast<double>(points.size());
}

// Both sides of a flat convex polygon, given by its corners in any order.
std::vector<Triangle> two_sided(const std::vector<Vec3>& corners) {
  const Vec3 centre = mean(corners), first = corners[0] - centre;
  Vec3 normal = Vec3::Zero();
  for (const Vec3& p : corners)
    if (first.cross(p - centre).squaredNorm() > normal.squaredNorm()) normal = first.cross(p - centre);
  const Vec3 u = first.normalized(), w = normal.normalized().cross(u);
  std::vector<int> order(corners.size());
  std::iota(order.begin(), order.end(), 0);
  const auto angle = [&](int i) {
    return std::atan2(w.dot(corners[i] - centre), u.dot(corners[i] - centre));
  };
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
  part.second =
      cylinder * (length * length / 12.0 * along + r * r / 4.0 * across) +
      ball * (r * r / 5.0 * Mat3::Identity() + (0.25 * length * length + 0.375 * length * r) * along);
  out.add(part, 0.5 * (start + end));
  return out;
}

// What polygons of n corners miss goes with 1 / n^2, so that two of them give the limit.
MassProperties rounded_ring_mass_properties(const std::vector<Vec3>& vertices, double radius_m,
                                            double density_kg_m3, const std::vector<Ring>& rings) {
  constexpr int kCorners = 512;
  const auto with_polygons = [&](int corners) {
    std::vector<Vec3> points = ring_points(rings, corners);
    points.insert(points.end(), vertices.begin(), vertices.end());
    return rounded_hull_mass_properties(points, radius_m, density_kg_m3);
  };
  const MassProperties coarse = with_polygons(kCorners), fine = with_polygons(2 * kCorners);
  const auto limit = [](const auto& a, const auto& b) { return b + (b - a) / 3.0; };
  MassProperties out;
  out.volume_m3 = limit(coarse.volume_m3, fine.volume_m3);
  out.mass_kg = limit(coarse.mass_kg, fine.mass_kg);
  out.centre_of_mass_m = limit(coarse.centre_of_mass_m, fine.centre_of_mass_m);
  out.inertia_kg_m2 = limit(coarse.inertia_kg_m2, fine.inertia_kg_m2);
  return out;
}

}  // namespace

MassProperties mass_properties(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                               double density_kg_m3) {
  if (vertices.empty()) return {};
  // about the middle, for a mesh far from its origin would lose digits
  const Vec3 middle = mean(vertices);
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
                                            double density_kg_m3, const std::vector<Ring>& rings) {
  if (!rings.empty()) return rounded_ring_mass_properties(vertices, radius_m, density_kg_m3, rings);
  if (!(radius_m >= 0.0) || !std::isfinite(radius_m))
    throw ArgumentError("radius_m: must be finite and not negative");
  Hull hull = convex_hull(vertices);
  const Vec3 middle = mean(hull.vertices);
  for (Vec3& v : hull.vertices) v -= middle;
  Moments moments;
  if (hull.vertices.size() <= 2) {
    moments = capsule(hull.vertices.front(), hull.vertices.back(), radius_m);
  } else {
    const std::vector<Triangle> triangles = hull.flat ? two_sided(hull.vertices) : hull.triangles;
    if (!hull.flat) moments.add_solid(hull.vertices, triangles);
    if (radius_m > 0.0) moments.add_rounding(hull.vertices, triangles, radius_m);
  }
  return moments.finish(middle, density_kg_m3);
}

}  // namespace ifa
