#include "ifa/graph/flight_index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>

namespace ifa {
namespace {

constexpr double kCell = 0.1;        // rad, edge of a cell
constexpr std::uint32_t kLeaf = 8;   // members
constexpr int kRate = 3, kTime = 7;  // in a Place

// By how much float32, and elements that fit the body to 1e-6, may displace a velocity: a share of it.
constexpr float kRounding = 4e-6f;

constexpr float kMostExcess = static_cast<float>(-kLeastLogFactor) * 1.0001f;  // rounded
constexpr float kNone = std::numeric_limits<float>::infinity();

using Array4f = Eigen::Array4f;

// A direction that no symmetry leaves in place: the image of `up` that is nearest to it stands for all.
const Vec3 kDomain = Vec3(0.48, 0.29, 0.83).normalized();

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// -log f_q.
float cost_of_turn(float angle_rad, float flight_s) {
  static const auto c = static_cast<float>(-log_orientation_factor(kShortFlight_s, kShortFlight_s));
  const float rate = angle_rad / std::min(flight_s, static_cast<float>(kShortFlight_s));
  return c * rate * rate;
}

// Where it is exp(kLeastLogFactor).
double most_angle_rad(double flight_s) {
  return std::sqrt(kLeastLogFactor / log_orientation_factor(1.0, flight_s));
}

Array4f lanes4(const Vec3& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), 0.0f};
}

// The `most` best so far, each node once. Which these are does not depend on the order they come in.
class Best {
 public:
  explicit Best(std::size_t most) : most_(most) {}

  double worst() const { return found_.size() == most_ ? found_.back().cost : -2.0 * kLeastLogFactor; }

  // Whether there is a place for it.
  bool takes(const FoundSplice& s) const {
    for (const FoundSplice& f : found_)
      if (f.node == s.node) return before(s, f);
    return found_.size() < most_ || before(s, found_.back());
  }

  void put(const FoundSplice& s) {
    std::erase_if(found_, [&](const FoundSplice& f) { return f.node == s.node; });
    if (found_.size() == most_) found_.pop_back();
    found_.insert(std::upper_bound(found_.begin(), found_.end(), s, before), s);
  }

  std::vector<FoundSplice> take() { return std::move(found_); }

 private:
  static bool before(const FoundSplice& a, const FoundSplice& b) {
    return std::tie(a.cost, a.node, a.element) < std::tie(b.cost, b.node, b.element);
  }

  std::size_t most_;
  std::vector<FoundSplice> found_;
};

}  // namespace

// One image of the take-off that is searched from, in the axes of one cell. The region's coordinates y (in four
// lanes, the last unused) are linear in a place.
struct FlightIndex::Frame {
  std::array<Array4f, 4> linear;  // by component of the place
  std::array<Array4f, 3> angular;
  Array4f linear_origin, angular_origin;
  Array4f per_velocity, per_spin;  // change of y by a change in its worst direction
  float turn;                      // by which turns do not commute, rad
  float velocity, spin;            // the take-off's own
  float least_angle_rad;
  Vec3 up;
  std::uint32_t root;
  std::uint8_t image;
  float bound;  // of the root

  // |y|^2 of a place, or at least that anywhere in a box; infinite beyond what f_v admits.
  template <bool kBox>
  float excess(const Place& at, const Box& box) const {
    Array4f z = -angular_origin;
    Array4f e = (turn * box.across_spin + kRounding * (spin + box.spin)) * per_spin;
    for (std::size_t d = 0; d < 3; ++d) {
      z += angular[d] * at[4 + d];
      if constexpr (kBox) e += angular[d].abs() * box.half[4 + d];
    }
    const float of_spin = (z.abs() - e).max(0.0f).square().sum();
    if (of_spin > kMostExcess) return kNone;
    z = -linear_origin;
    e = (turn * box.across_velocity + kRounding * (velocity + box.velocity)) * per_velocity;
    for (std::size_t d = 0; d < 4; ++d) {
      z += linear[d] * at[d];
      if constexpr (kBox) e += linear[d].abs() * box.half[d];
    }
    const float sum = of_spin + (z.abs() - e).max(0.0f).square().sum();
    return sum > kMostExcess ? kNone : sum;
  }

  // No splice in the box costs less.
  float cost(const Box& box) const {
    const float turned = cost_of_turn(least_angle_rad, box.centre[kTime] + box.half[kTime]);
    return turned > kMostExcess ? kNone : turned + excess<true>(box.centre, box);
  }
};

FlightIndex::FlightIndex(const Nodes& nodes, const Body& body, const Images& images,
                         std::span<const std::uint32_t> members)
    : nodes_(nodes), body_(body), images_(images) {
  for (std::size_t a = 0; a < images.size(); ++a)
    for (std::size_t b = 0; b < images.size(); ++b) {
      const Mat3 map = images[a].map.transpose() * images[b].map;
      const auto misfit = [&](std::size_t c) { return (images[c].map - map).squaredNorm(); };
      std::size_t nearest = 0;
      for (std::size_t c = 1; c < images.size(); ++c)
        if (misfit(c) < misfit(nearest)) nearest = c;
      between_.push_back(static_cast<std::uint8_t>(nearest));
    }
  if (members.empty()) return;

  // Sizes of typical regions, so that cuts make boxes of similar shape.
  double velocity = 0.0, spin = 0.0, spread = 0.0;
  const std::size_t step = 1 + members.size() / 1000;
  std::size_t asked = 0;
  for (std::size_t m = 0; m < members.size(); m += step, ++asked) {
    const PlausibleRegion region = region_of(nodes, members[m], body);
    for (int k = 0; k < 3; ++k) {
      Vec6 y = Vec6::Zero();
      y[k] = y[3 + k] = 1.0;
      velocity += std::log(region.velocity_offset(y).norm()) / 3.0;
      spin += std::log(region.spin_offset(y).norm()) / 3.0;
    }
    height_m_ += take_off_of(nodes, members[m]).height_m;
  }
  height_m_ /= static_cast<double>(asked);
  for (std::size_t m = 0; m < members.size(); m += step)
    spread += std::abs(take_off_of(nodes, members[m]).height_m - height_m_);
  velocity = std::exp(-velocity / static_cast<double>(asked));
  spin = std::exp(-spin / static_cast<double>(asked));
  const double rate = spread / static_cast<double>(asked) * velocity;
  for (std::size_t d = 0; d < 7; ++d)
    weight_[d] = static_cast<float>(d < 3 ? velocity : d == kRate ? rate : spin);
  weight_[kTime] = 10.0f;

  std::map<std::array<int, 3>, std::vector<Member>> cells;
  for (const std::uint32_t j : members) {
    const Vec3 up = take_off_of(nodes, j).up.normalized();
    const Vec3 turned = images.folding(up) * up;
    Member m{};
    m.node = j;
    m.fold = fold(turned);
    const Vec3 folded = images[m.fold].map * turned;
    std::array<int, 3> key;
    for (std::size_t d = 0; d < 3; ++d) {
      m.up[d] = static_cast<float>(folded[static_cast<int>(d)]);
      key[d] = static_cast<int>(std::floor(folded[static_cast<int>(d)] / kCell));
    }
    cells[key].push_back(m);
  }
  members_.reserve(members.size());
  for (auto& [key, inside] : cells) {
    Vec3 centre = Vec3::Zero();
    for (const Member& m : inside) centre += Vec3(m.up[0], m.up[1], m.up[2]);
    centre.normalize();
    const auto first = static_cast<std::uint32_t>(members_.size());
    double radius = 0.0;
    for (Member& m : inside) {
      const Vec3 up(m.up[0], m.up[1], m.up[2]);
      radius = std::max(radius, angle_between(up, centre));
      TakeOffView view = take_off_of(nodes, m.node);
      view = image({images.folding(view.up), true}, view);
      view = image(images[m.fold], view);
      const double flight_s = nodes.flight_s[m.node];
      const Mat3 turn = smallest_turn(view.up, centre);
      const Vec3 v = turn * view.velocity + (view.height_m - height_m_) / flight_s * centre;
      const Vec3 w = turn * view.spin;
      for (int d = 0; d < 3; ++d) {
        m.place[static_cast<std::size_t>(d)] = static_cast<float>(v[d]);
        m.place[static_cast<std::size_t>(4 + d)] = static_cast<float>(w[d]);
      }
      m.place[kRate] = static_cast<float>(1.0 / flight_s);
      m.place[kTime] = static_cast<float>(std::min(flight_s, kShortFlight_s));
      members_.push_back(m);
    }
    const std::uint32_t root = build(first, static_cast<std::uint32_t>(inside.size()), centre);
    radius += 1e-6;  // float32
    const Box& all = boxes_[root];
    const double farthest = radius + most_angle_rad(all.centre[kTime] + all.half[kTime]) + 1e-6;
    cells_.push_back({centre, radius, std::cos(std::min(farthest, std::numbers::pi)), root});
  }
}

std::uint8_t FlightIndex::fold(const Vec3& up) const {
  std::size_t nearest = 0;
  double most = -2.0;
  for (std::size_t e = 0; e < images_.size(); ++e)
    if (const double dot = kDomain.dot(images_[e].map * up); dot > most) {
      most = dot;
      nearest = e;
    }
  return static_cast<std::uint8_t>(nearest);
}

// The box of these members and all boxes below it.
std::uint32_t FlightIndex::build(std::uint32_t first, std::uint32_t count, const Vec3& up) {
  const auto index = static_cast<std::uint32_t>(boxes_.size());
  boxes_.emplace_back();
  const std::span<Member> inside(members_.data() + first, count);
  Place low = inside[0].place, high = low;
  Box box{};
  box.first = first;
  box.count = count;
  for (const Member& m : inside) {
    const Place& p = m.place;
    for (std::size_t d = 0; d < 8; ++d) {
      low[d] = std::min(low[d], p[d]);
      high[d] = std::max(high[d], p[d]);
    }
    const Vec3 v(p[0], p[1], p[2]), w(p[4], p[5], p[6]);
    box.across_velocity = std::max(box.across_velocity, static_cast<float>(v.cross(up).norm()));
    box.across_spin = std::max(box.across_spin, static_cast<float>(w.cross(up).norm()));
    box.velocity =
        std::max(box.velocity, static_cast<float>(v.norm() + p[kRate] * body_.bounding_radius_m()));
    box.spin = std::max(box.spin, static_cast<float>(w.norm()));
  }
  std::size_t widest = 0;
  float extent = 0.0f;
  for (std::size_t d = 0; d < 8; ++d) {
    box.centre[d] = 0.5f * (low[d] + high[d]);
    box.half[d] = 0.5f * (high[d] - low[d]) * 1.000001f + 1e-7f * std::abs(box.centre[d]);
    const float of_d = d == kTime ? weight_[d] * std::log(high[d] / low[d]) : weight_[d] * (high[d] - low[d]);
    if (of_d > extent) {
      extent = of_d;
      widest = d;
    }
  }
  if (count > kLeaf && extent > 0.0f) {
    const std::uint32_t left = count / 2;
    std::nth_element(inside.begin(), inside.begin() + left, inside.end(), [&](const Member& a, const Member& b) {
      return std::tie(a.place[widest], a.node) < std::tie(b.place[widest], b.node);
    });
    build(first, left, up);
    box.right = build(first + left, count - left, up);
  }
  boxes_[index] = box;
  return index;
}

// Of the images and cells that can be near.
std::vector<FlightIndex::Frame> FlightIndex::frames(const TakeOffView& from,
                                                    const PlausibleRegion& region) const {
  std::vector<Frame> all;
  const Mat3 folding = images_.folding(from.up);
  const Vec3 up = (folding * from.up).normalized();
  Mat3 linear, angular;  // rows: a coordinate's direction over its half axis
  for (int k = 0; k < 3; ++k) {
    Vec6 y = Vec6::Zero();
    y[k] = y[3 + k] = 1.0;
    const Vec3 a = region.velocity_offset(y), b = region.spin_offset(y);
    linear.row(k) = a / a.squaredNorm();
    angular.row(k) = b / b.squaredNorm();
  }
  const Array4f linear_origin = lanes4(linear * from.velocity), angular_origin = lanes4(angular * from.spin);
  const Array4f per_velocity = lanes4(linear.rowwise().norm()), per_spin = lanes4(angular.rowwise().norm());
  for (std::size_t e = 0; e < images_.size(); ++e) {
    const Vec3 seen = images_[e].map * up;
    for (const Cell& cell : cells_) {
      if (seen.dot(cell.centre) < cell.least_cosine) continue;
      const double angle = angle_between(seen, cell.centre);
      Frame f;
      const Mat3 map = smallest_turn(seen, cell.centre) * images_[e].map * folding;
      const double sign = images_[e].proper ? 1.0 : -1.0;
      const Mat3 to_linear = linear * map.transpose(), to_angular = sign * angular * map.transpose();
      for (int d = 0; d < 3; ++d) {
        f.linear[static_cast<std::size_t>(d)] = lanes4(to_linear.col(d));
        f.angular[static_cast<std::size_t>(d)] = lanes4(to_angular.col(d));
      }
      f.linear[kRate] = lanes4(-(from.height_m - height_m_) * (to_linear * cell.centre));
      f.linear_origin = linear_origin;
      f.angular_origin = angular_origin;
      f.per_velocity = per_velocity;
      f.per_spin = per_spin;
      // Turning to the centre and on to the image, in place of at once, is a turn about it by the area of the
      // triangle: at most 2 asin(tan(a / 2) tan(b / 2)), a and b its sides at the centre.
      f.turn = static_cast<float>(
          std::min(2.0, 2.0 * std::tan(0.5 * cell.radius_rad) * std::tan(std::min(0.5 * angle, 1.5))));
      f.velocity = static_cast<float>(from.velocity.norm());
      f.spin = static_cast<float>(from.spin.norm());
      f.up = seen;
      f.least_angle_rad = static_cast<float>(std::max(0.0, angle - cell.radius_rad));
      f.root = cell.root;
      f.image = static_cast<std::uint8_t>(e);
      f.bound = f.cost(boxes_[cell.root]);
      if (f.bound < kNone) all.push_back(f);
    }
  }
  return all;
}

std::vector<FoundSplice> FlightIndex::best(
    std::size_t i, std::size_t most, const std::function<bool(std::uint32_t, const Splice&)>& admits) const {
  if (most == 0) return {};
  const TakeOffView from = take_off_of(nodes_, i);
  const PlausibleRegion region = region_of(nodes_, i, body_);
  Best found(most);
  const auto within = [&](float bound) { return bound <= found.worst() * 1.0001; };  // float32
  const std::vector<Frame> near = frames(from, region);
  std::vector<std::pair<float, std::uint32_t>> order;
  for (const Frame& frame : near) order.emplace_back(frame.bound, static_cast<std::uint32_t>(order.size()));
  std::sort(order.begin(), order.end());
  std::vector<std::pair<std::uint32_t, float>> stack;
  for (const auto& [least, n_frame] : order) {
    if (!within(least)) break;
    const Frame& frame = near[n_frame];
    stack.assign(1, {frame.root, frame.bound});
    while (!stack.empty()) {
      const auto [at, bound] = stack.back();
      stack.pop_back();
      if (!within(bound)) continue;
      const Box& box = boxes_[at];
      if (box.right != 0) {
        const float left = frame.cost(boxes_[at + 1]), right = frame.cost(boxes_[box.right]);
        const bool left_first = left <= right;
        for (const auto& child : {std::pair(left_first ? box.right : at + 1, std::max(left, right)),
                                  std::pair(left_first ? at + 1 : box.right, std::min(left, right))})
          if (within(child.second)) stack.push_back(child);
        continue;
      }
      for (std::uint32_t n = box.first; n < box.first + box.count; ++n) {
        const Member& m = members_[n];
        if (m.node == i) continue;
        const float excess = frame.excess<false>(m.place, box);
        const Vec3 across = frame.up.cross(Vec3(m.up[0], m.up[1], m.up[2]));
        // the sine, no more than the angle
        const float turn = cost_of_turn(std::max(0.0f, static_cast<float>(across.norm()) - 1e-6f), m.place[kTime]);
        if (!within(excess + turn)) continue;
        const std::uint8_t element = between_[frame.image * images_.size() + m.fold];
        const TakeOffView seen = take_off_of(nodes_, m.node);
        const Splice s = splice(from, region, image(images_.element(element, from.up, seen.up), seen),
                                nodes_.flight_s[m.node]);
        if (s.log_velocity <= kLeastLogFactor || s.log_orientation <= kLeastLogFactor) continue;
        const FoundSplice candidate{-s.log_weight(), m.node, element};
        if (found.takes(candidate) && admits(m.node, s)) found.put(candidate);
      }
    }
  }
  return found.take();
}

}  // namespace ifa
