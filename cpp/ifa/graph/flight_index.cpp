#include "ifa/graph/flight_index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>

namespace ifa {
namespace {

constexpr double kCell = 0.2;        // rad, edge of a cell
constexpr int kRate = 3, kTime = 7;  // in a Place

// By how much float32, and elements that fit the body to 1e-6, may displace a velocity: a share of it.
constexpr float kRounding = 4e-6f;

constexpr float kMostExcess = static_cast<float>(-kLeastLogFactor) * 1.0001f;  // rounded
constexpr float kNone = std::numeric_limits<float>::infinity();

// A direction that no symmetry leaves in place: the image of `up` that is nearest to it stands for all.
using Array4f = Eigen::Array4f;
using Column = const float*;

const Vec3 kDomain = Vec3(0.48, 0.29, 0.83).normalized();

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// -log f_q.
float cost_of_turn(float angle_rad, float flight_s) {
  static const auto c = static_cast<float>(-log_orientation_factor(kShortFlight_s, kShortFlight_s));
  const float rate = angle_rad / std::min(flight_s, static_cast<float>(kShortFlight_s));
  return c * rate * rate;
}

// Where that is -kLeastLogFactor.
double most_angle_rad(double flight_s) {
  return std::sqrt(kLeastLogFactor / log_orientation_factor(1.0, flight_s));
}

// The `most` best so far, each node once. Which these are does not depend on the order they come in.
class Best {
 public:
  explicit Best(std::size_t most) : most_(most) {}

  // None that costs more is taken; a little more, for float32.
  float limit() const {
    const double worst = found_.size() == most_ ? found_.back().cost : -2.0 * kLeastLogFactor;
    return static_cast<float>(worst * 1.0001);
  }

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

// One image of the take-off that is searched from, in the axes of one cell. The region's coordinates y are
// linear in a place.
struct FlightIndex::Frame {
  float linear[3][4], angular[3][3];  // [coordinate][component of the place]
  float linear_origin[3], angular_origin[3];
  float per_velocity[3], per_spin[3];  // change of y by a change in its worst direction
  float turn;                          // by which turns do not commute, rad
  float velocity, spin;                // the take-off's own
  float least_angle_rad;
  Vec3 up;
  std::uint8_t image;
  float bound;  // of the whole cell
  const Cell* cell;

  // From below of |y|^2 in boxes or, without `half`, of members; infinite beyond what f_v admits. The columns
  // begin at their lanes.
  template <bool kBoxes>
  void excesses(const Column* centre, const Column* half, const Reach& reach, Lanes& out) const {
    const float dw = turn * reach.across_spin + kRounding * (spin + reach.spin);
    const float dv = turn * reach.across_velocity + kRounding * (velocity + reach.velocity);
    for (std::size_t l = 0; l < kLanes; l += 4) {
      Array4f sum = Array4f::Zero();
      for (int k = 0; k < 3; ++k)
        sum += beyond<kBoxes, 3>(angular[k], centre + 4, half + 4, l, angular_origin[k], dw * per_spin[k]);
      if ((sum <= kMostExcess).any())
        for (int k = 0; k < 3; ++k)
          sum += beyond<kBoxes, 4>(linear[k], centre, half, l, linear_origin[k], dv * per_velocity[k]);
      Eigen::Map<Array4f>(out.data() + l) = (sum <= kMostExcess).select(sum, kNone);
    }
  }

 private:
  // The square of what is left of |a . centre - origin| when a . half and the slack are taken away.
  template <bool kBoxes, int kDimensions>
  static Array4f beyond(const float* a, const Column* centre, const Column* half, std::size_t l, float origin,
                        float slack) {
    Array4f y = Array4f::Constant(-origin), reach = Array4f::Constant(slack);
    for (int d = 0; d < kDimensions; ++d) {
      y += a[d] * Eigen::Map<const Array4f>(centre[d] + l);
      if constexpr (kBoxes) reach += std::abs(a[d]) * Eigen::Map<const Array4f>(half[d] + l);
    }
    return (y.abs() - reach).max(0.0f).square();
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
  weight_[kTime] = 30.0f;

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
  for (auto& [key, inside] : cells) add_cell(inside);
  for (std::size_t d = 0; d < 8; ++d) {
    columns_[d].reserve(members_.size() + kLanes);
    for (const Member& m : members_) columns_[d].push_back(m.place[d]);
    columns_[d].resize(members_.size() + kLanes);  // the last may be looked at with lanes beyond
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

void FlightIndex::add_cell(std::vector<Member>& inside) {
  const auto up_of = [](const Member& m) { return Vec3(m.up[0], m.up[1], m.up[2]); };
  Cell cell{};
  for (const Member& m : inside) cell.centre += up_of(m);
  cell.centre.normalize();
  const auto first = static_cast<std::uint32_t>(members_.size());
  for (Member& m : inside) {
    cell.radius_rad = std::max(cell.radius_rad, angle_between(up_of(m), cell.centre) + 1e-6);  // float32
    TakeOffView view = take_off_of(nodes_, m.node);
    view = image(images_[m.fold], image({images_.folding(view.up), true}, view));
    const double flight_s = nodes_.flight_s[m.node];
    const Mat3 turn = smallest_turn(view.up, cell.centre);
    const Vec3 v = turn * view.velocity + (view.height_m - height_m_) / flight_s * cell.centre;
    const Vec3 w = turn * view.spin;
    for (int d = 0; d < 3; ++d) {
      m.place[static_cast<std::size_t>(d)] = static_cast<float>(v[d]);
      m.place[static_cast<std::size_t>(4 + d)] = static_cast<float>(w[d]);
    }
    m.place[kRate] = static_cast<float>(1.0 / flight_s);
    m.place[kTime] = static_cast<float>(std::min(flight_s, kShortFlight_s));
    cell.most_flight_s = std::max(cell.most_flight_s, m.place[kTime]);
    members_.push_back(m);
  }
  const double farthest = cell.radius_rad + most_angle_rad(cell.most_flight_s) + 1e-6;
  cell.least_cosine = std::cos(std::min(farthest, std::numbers::pi));
  cell.root = build(first, static_cast<std::uint32_t>(inside.size()), cell.centre);
  cells_.push_back(cell);
}

std::size_t FlightIndex::widest(std::span<const Member> inside) const {
  Place low = inside[0].place, high = low;
  for (const Member& m : inside)
    for (std::size_t d = 0; d < 8; ++d) {
      low[d] = std::min(low[d], m.place[d]);
      high[d] = std::max(high[d], m.place[d]);
    }
  std::size_t widest = 0;
  float extent = -1.0f;
  for (std::size_t d = 0; d < 8; ++d)
    if (const float e = weight_[d] * (d == kTime ? std::log(high[d] / low[d]) : high[d] - low[d]);
        e > extent) {
      extent = e;
      widest = d;
    }
  return widest;
}

FlightIndex::Branch FlightIndex::build(std::uint32_t first, std::uint32_t count, const Vec3& up) {
  Branch all{first, count, {}};
  for (std::uint32_t n = first; n < first + count; ++n) {
    const Place& p = members_[n].place;
    const Vec3 v(p[0], p[1], p[2]), w(p[4], p[5], p[6]);
    Reach& r = all.reach;
    r.across_velocity = std::max(r.across_velocity, static_cast<float>(v.cross(up).norm()));
    r.across_spin = std::max(r.across_spin, static_cast<float>(w.cross(up).norm()));
    r.velocity = std::max(r.velocity, static_cast<float>(v.norm() + p[kRate] * body_.bounding_radius_m()));
    r.spin = std::max(r.spin, static_cast<float>(w.norm()));
  }
  if (count <= kLanes) return all;

  // Four cuts by two, each at a whole number of leaves.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> parts{{first, count}};
  while (parts.size() < kLanes) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> halves;
    for (const auto& [begin, size] : parts) {
      if (size <= kLanes) {
        halves.emplace_back(begin, size);
        continue;
      }
      const std::span<Member> inside(members_.data() + begin, size);
      const std::size_t d = widest(inside);
      const auto left = static_cast<std::uint32_t>((size / 2 + kLanes - 1) / kLanes * kLanes);
      std::nth_element(inside.begin(), inside.begin() + left, inside.end(),
                       [&](const Member& a, const Member& b) {
                         return std::tie(a.place[d], a.node) < std::tie(b.place[d], b.node);
                       });
      halves.emplace_back(begin, left);
      halves.emplace_back(begin + left, size - left);
    }
    if (halves.size() == parts.size()) break;
    parts = std::move(halves);
  }

  const auto index = static_cast<std::uint32_t>(boxes_.size());
  boxes_.emplace_back();
  Boxes boxes{};
  boxes.size = static_cast<std::uint32_t>(parts.size());
  for (std::size_t l = 0; l < parts.size(); ++l) {
    const auto& [begin, size] = parts[l];
    boxes.branch[l] = build(begin, size, up);
    for (std::size_t d = 0; d < 8; ++d) {
      float low = members_[begin].place[d], high = low;
      for (std::uint32_t n = begin; n < begin + size; ++n) {
        low = std::min(low, members_[n].place[d]);
        high = std::max(high, members_[n].place[d]);
      }
      boxes.centre[d][l] = 0.5f * (low + high);
      boxes.half[d][l] = 0.5f * (high - low) * 1.000001f + 1e-7f * std::abs(boxes.centre[d][l]);
    }
  }
  boxes_[index] = boxes;
  return {index, 0, all.reach};
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
  const Vec3 linear_origin = linear * from.velocity, angular_origin = angular * from.spin;
  const Vec3 per_velocity = linear.rowwise().norm(), per_spin = angular.rowwise().norm();
  for (std::size_t e = 0; e < images_.size(); ++e) {
    const Vec3 seen = images_[e].map * up;
    for (const Cell& cell : cells_) {
      if (seen.dot(cell.centre) < cell.least_cosine) continue;
      Frame& f = all.emplace_back();
      const double angle = angle_between(seen, cell.centre);
      const Mat3 map = smallest_turn(seen, cell.centre) * images_[e].map * folding;
      const double sign = images_[e].proper ? 1.0 : -1.0;
      const Mat3 to_linear = linear * map.transpose(), to_angular = sign * angular * map.transpose();
      const Vec3 by_rate = -(from.height_m - height_m_) * (to_linear * cell.centre);
      for (int k = 0; k < 3; ++k) {
        for (int d = 0; d < 3; ++d) {
          f.linear[k][d] = static_cast<float>(to_linear(k, d));
          f.angular[k][d] = static_cast<float>(to_angular(k, d));
        }
        f.linear[k][kRate] = static_cast<float>(by_rate[k]);
        f.linear_origin[k] = static_cast<float>(linear_origin[k]);
        f.angular_origin[k] = static_cast<float>(angular_origin[k]);
        f.per_velocity[k] = static_cast<float>(per_velocity[k]);
        f.per_spin[k] = static_cast<float>(per_spin[k]);
      }
      // Turning to the centre and on to the image, in place of at once, is a turn about it by the area of the
      // triangle: at most 2 asin(tan(a / 2) tan(b / 2)), a and b its sides at the centre.
      f.turn = static_cast<float>(
          std::min(2.0, 2.0 * std::tan(0.5 * cell.radius_rad) * std::tan(std::min(0.5 * angle, 1.5))));
      f.velocity = static_cast<float>(from.velocity.norm());
      f.spin = static_cast<float>(from.spin.norm());
      f.up = seen;
      f.least_angle_rad = static_cast<float>(std::max(0.0, angle - cell.radius_rad));
      f.image = static_cast<std::uint8_t>(e);
      f.bound = cost_of_turn(f.least_angle_rad, cell.most_flight_s);
      f.cell = &cell;
    }
  }
  return all;
}

std::vector<FoundSplice> FlightIndex::best(
    std::size_t i, std::size_t most, const std::function<bool(std::uint32_t, const Splice&)>& admits) const {
  if (most == 0) return {};
  const TakeOffView from = take_off_of(nodes_, i);
  const PlausibleRegion region = region_of(nodes_, i, body_);
  const std::vector<Frame> near = frames(from, region);
  std::vector<std::pair<float, std::uint32_t>> order;  // the most promising first
  for (const Frame& frame : near) order.emplace_back(frame.bound, static_cast<std::uint32_t>(order.size()));
  std::sort(order.begin(), order.end());

  Best found(most);
  float limit = found.limit();
  using Open = std::pair<float, const Branch*>;
  std::vector<Open> stack;
  Lanes excess;
  Column centre[8], half[8]{};
  for (const auto& [least, number] : order) {
    if (least > limit) break;
    const Frame& frame = near[number];
    stack.assign(1, {least, &frame.cell->root});
    while (!stack.empty()) {
      const auto [bound, branch] = stack.back();
      stack.pop_back();
      if (bound > limit) continue;
      if (branch->count == 0) {
        const Boxes& boxes = boxes_[branch->first];
        for (std::size_t d = 0; d < 8; ++d) {
          centre[d] = boxes.centre[d].data();
          half[d] = boxes.half[d].data();
        }
        frame.excesses<true>(centre, half, branch->reach, excess);
        const std::size_t before = stack.size();
        for (std::size_t l = 0; l < boxes.size; ++l) {
          if (excess[l] > limit) continue;
          const float turned = cost_of_turn(frame.least_angle_rad, centre[kTime][l] + half[kTime][l]);
          if (turned <= kMostExcess && turned + excess[l] <= limit)
            stack.emplace_back(turned + excess[l], &boxes.branch[l]);
        }
        std::sort(stack.begin() + static_cast<std::ptrdiff_t>(before), stack.end(),
                  [](const Open& a, const Open& b) { return a.first > b.first; });
        continue;
      }
      for (std::size_t d = 0; d < 8; ++d) centre[d] = &columns_[d][branch->first];
      frame.excesses<false>(centre, half, branch->reach, excess);
      for (std::uint32_t l = 0; l < branch->count; ++l) {
        if (excess[l] > limit) continue;
        const Member& m = members_[branch->first + l];
        const Vec3 across = frame.up.cross(Vec3(m.up[0], m.up[1], m.up[2]));
        // the sine, no more than the angle; float32
        const float angle_rad = std::max(0.0f, static_cast<float>(across.norm()) - 1e-6f);
        if (m.node == i || excess[l] + cost_of_turn(angle_rad, m.place[kTime]) > limit) continue;
        const std::uint8_t element = between_[frame.image * images_.size() + m.fold];
        const TakeOffView seen = take_off_of(nodes_, m.node);
        const Splice s = splice(from, region, image(images_.element(element, from.up, seen.up), seen),
                                nodes_.flight_s[m.node]);
        if (s.log_velocity <= kLeastLogFactor || s.log_orientation <= kLeastLogFactor) continue;
        const FoundSplice candidate{-s.log_weight(), m.node, element};
        if (!found.takes(candidate) || !admits(m.node, s)) continue;
        found.put(candidate);
        limit = found.limit();
      }
    }
  }
  return found.take();
}

}  // namespace ifa
