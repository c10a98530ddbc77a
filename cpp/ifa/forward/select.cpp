#include "ifa/forward/select.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

namespace ifa {
namespace {

constexpr double kEnergyBand = 0.4;  // width of a band of energy, in its logarithm
constexpr double kTiltBand = std::numbers::pi / 4.0;
constexpr std::size_t kFewestStarts = 10;  // that a full beam descends from

class Selection {
 public:
  Selection(const std::vector<Candidate>& all, std::size_t room)
      : all_(all), room_(room), taken_(all.size(), 0) {}

  bool full() const { return kept_.size() >= room_; }
  bool taken(std::size_t i) const { return taken_[i]; }
  std::size_t size() const { return kept_.size(); }
  const std::vector<std::size_t>& kept() const { return kept_; }
  void relax() { strict_ = false; }

  bool take(std::size_t i) {
    if (taken_[i] || full()) return false;
    std::size_t& siblings = of_parent_[all_[i].parent];
    std::size_t& relatives = of_start_[all_[i].start];
    if (strict_ && (siblings >= kMostChildren || relatives >= room_ / kFewestStarts + 1)) return false;
    taken_[i] = 1;
    ++siblings;
    ++relatives;
    kept_.push_back(i);
    return true;
  }

 private:
  const std::vector<Candidate>& all_;
  std::size_t room_;
  std::vector<char> taken_;
  std::vector<std::size_t> kept_;
  std::map<int, std::size_t> of_parent_, of_start_;
  bool strict_ = true;
};

// Where an orientation is asked at rest: how near to it the body is, since by rest it tips over an edge or
// two at most. (The heading is free until then.)
int tilt_band(const Problem& problem, const Candidate& c) {
  for (const OrientationConstraint& asked : problem.marks.constraints.orientations) {
    if (asked.mark != kAtRest) continue;
    const Body& body = problem.bodies[static_cast<std::size_t>(c.body)];
    const double now = seen(body, c.onset.before, asked.body_direction.stableNormalized()).z();
    const double off = std::abs(std::acos(std::clamp(now, -1.0, 1.0)) -
                                std::acos(std::clamp(asked.direction.stableNormalized().z(), -1.0, 1.0)));
    return static_cast<int>(off / kTiltBand);
  }
  return 0;
}

// Takes in turn from each group, its first ones first, until `until` are kept or nothing is left.
template <class Key>
void take_evenly(Selection& selection, const std::map<Key, std::vector<std::size_t>>& groups,
                 std::size_t until) {
  std::map<Key, std::size_t> next;
  for (bool more = true; more && selection.size() < until;) {
    more = false;
    for (const auto& [key, members] : groups) {
      std::size_t& at = next[key];
      while (at < members.size() && !selection.take(members[at++])) {
      }
      more |= at < members.size();
      if (selection.size() >= until) return;
    }
  }
}

// Those of `order`, which is sorted, that fill one batch.
std::vector<std::size_t> select_batch(const std::vector<Candidate>& all,
                                      const std::vector<std::size_t>& order, const Problem& problem,
                                      std::size_t room, bool even) {
  Selection selection(all, room);
  for (std::size_t from = 0; from < order.size() && !selection.full();) {
    std::size_t to = from;  // equally sound ones
    while (to < order.size() && !all[order[from]].sounder(all[order[to]])) ++to;
    const std::size_t left = room - selection.size();
    const auto group = std::span(order).subspan(from, to - from);
    if (even) {
      std::map<int, std::vector<std::size_t>> of_body;
      for (const std::size_t i : group) of_body[all[i].body].push_back(i);
      if (of_body.size() > 1) take_evenly(selection, of_body, selection.size() + left / 2);
    }
    const std::size_t by_rank = room - left + (left + 1) / 2;
    for (const std::size_t i : group) {
      if (selection.size() >= by_rank) break;
      selection.take(i);
    }
    std::map<std::pair<int, int>, std::vector<std::size_t>> bands;
    for (const std::size_t i : group) {
      if (selection.taken(i)) continue;
      const double energy =
          kinetic_energy(problem.bodies[static_cast<std::size_t>(all[i].body)], all[i].onset.after);
      const int band = static_cast<int>(std::floor(std::log(std::max(energy, 1e-300)) / kEnergyBand));
      bands[{band, tilt_band(problem, all[i])}].push_back(i);
    }
    take_evenly(selection, bands, room);
    from = to;
  }
  selection.relax();  // where too few families are left, what there is
  for (const std::size_t i : order) selection.take(i);

  auto kept = selection.kept();
  std::stable_sort(kept.begin(), kept.end(),
                   [&](std::size_t a, std::size_t b) { return all[a].body < all[b].body; });
  return kept;
}

}  // namespace

Level select(std::vector<Candidate>&& all, const Problem& problem, std::size_t room, std::size_t batches,
             bool even) {
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (all[a].sounder(all[b]) || all[b].sounder(all[a])) return all[a].sounder(all[b]);
    return all[a].rank() > all[b].rank();
  });
  Level level;
  std::vector<char> gone(all.size(), 0);
  for (std::size_t batch = 0; batch < batches && !order.empty(); ++batch) {
    for (const std::size_t i : select_batch(all, order, problem, room, even)) {
      gone[i] = 1;
      level.candidates.push_back(std::move(all[i]));
    }
    level.batch_ends.push_back(level.candidates.size());
    std::erase_if(order, [&](std::size_t i) { return gone[i] != 0; });
  }
  return level;
}

}  // namespace ifa
