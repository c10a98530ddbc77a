#include "ifa/graph/layered.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "ifa/signature/factors.hpp"

namespace ifa {
namespace {

constexpr double kNothing = -std::numeric_limits<double>::infinity();

// First events within 5 % of each other count as equally loud.
const double kLoudnessStep = std::log(1.05);

struct Entry {
  std::uint32_t node, parent;  // parent: index at the layer before; of the first edge, the path's first node
  float weight, bound;         // log: of this path; of any with its key, its loudness the kindest of its bin
  float first_amplitude;
  std::int16_t loudness;
  std::uint8_t element;
  bool spliced;
};

// A layer in the making: at most one entry of each key.
class Layer {
 public:
  explicit Layer(std::size_t expected) {
    std::size_t size = 1024;
    while (size < 2 * expected) size *= 2;
    slots_.assign(size, 0);
  }

  void offer(const Entry& e) {
    if (2 * (entries.size() + 1) > slots_.size()) grow();
    std::uint32_t& slot = slots_[find(e)];
    if (slot == 0) {
      entries.push_back(e);
      slot = static_cast<std::uint32_t>(entries.size());
      return;
    }
    Entry& held = entries[slot - 1];
    const float bound = std::max(held.bound, e.bound);
    if (e.weight > held.weight) held = e;
    held.bound = bound;
  }

  std::vector<Entry> entries;

 private:
  std::size_t find(const Entry& e) const {
    const std::uint64_t key =
        (static_cast<std::uint64_t>(e.node) << 16 | static_cast<std::uint16_t>(e.loudness)) *
        0x9E3779B97F4A7C15u;
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t at = (key >> 20) & mask;; at = (at + 1) & mask) {
      if (slots_[at] == 0) return at;
      const Entry& held = entries[slots_[at] - 1];
      if (held.node == e.node && held.loudness == e.loudness) return at;
    }
  }

  void grow() {
    slots_.assign(2 * slots_.size(), 0);
    for (std::size_t i = 0; i < entries.size(); ++i)
      slots_[find(entries[i])] = static_cast<std::uint32_t>(i + 1);
  }

  std::vector<std::uint32_t> slots_;  // index + 1; 0 is free
};

class Search {
 public:
  Search(const Briefs& briefs, const Transitions& transitions, const Targets& targets,
         const LayeredOptions& options, double incumbent)
      : briefs_(briefs),
        transitions_(transitions),
        targets_(targets),
        options_(options),
        incumbent_(incumbent),
        most_cost_(static_cast<std::uint32_t>(std::min(options.most_cost / kCostUnit, 65535.0))) {}

  std::vector<GraphPath> run(const Progress* progress) {
    layers_.push_back(first_edges());
    for (std::size_t k = 1; k + 1 < targets_.size(); ++k) {
      if (progress) progress->throw_if_cancelled();
      keep_best(layers_.back());
      std::vector<Entry> next = next_layer(layers_.back(), k);
      if (next.empty()) break;
      layers_.push_back(std::move(next));
    }
    return traced();
  }

 private:
  bool in_reach(double interval, double target) const {
    return interval <= options_.most_retime * target && target <= options_.most_retime * interval;
  }

  std::vector<Entry> first_edges() {
    const double target = targets_.intervals_s[0];
    const auto& order = briefs_.by_interval;
    const auto interval = [this](std::uint32_t i) { return interval_s(briefs_.nodes[i], briefs_.nodes[i]); };
    auto it = std::lower_bound(order.begin(), order.end(), target / options_.most_retime,
                               [&](std::uint32_t i, double t) { return interval(i) < t; });
    Layer layer(1 << 16);
    for (; it != order.end() && interval(*it) <= options_.most_retime * target; ++it) {
      const NodeBrief& root = briefs_.nodes[*it];
      Entry e{*it + 1, *it, 0.0f, 0.0f, root.amplitude, 0, 0, false};
      if (!targets_.amplitudes.empty() && root.amplitude > 0.0f)
        e.loudness = static_cast<std::int16_t>(std::lround(std::log(root.amplitude) / kLoudnessStep));
      const double log =
          log_sound(root, targets_, 0, root.amplitude) + log_time_factor(interval(*it), target);
      offer(layer, e, log, 1);
    }
    return std::move(layer.entries);
  }

  std::vector<Entry> next_layer(const std::vector<Entry>& from, std::size_t k) {
    Layer layer(2 * from.size());
    const double target = targets_.intervals_s[k];
    for (std::uint32_t s = 0; s < from.size(); ++s) {
      const Entry& parent = from[s];
      const NodeBrief& node = briefs_.nodes[parent.node];
      Entry e = parent;
      e.parent = s;
      if (usable_edge(node)) {
        const double interval = interval_s(node, node);
        if (in_reach(interval, target)) {
          e.node = parent.node + 1;
          e.element = 0;
          e.spliced = false;
          offer(layer, e, log_time_factor(interval, target), k + 1);
        }
      }
      if (node.flight_s <= 0.0f) continue;
      e.spliced = true;
      const std::uint64_t first = transitions_.first[parent.node];
      const std::uint64_t count =
          std::min<std::uint64_t>(transitions_.first[parent.node + 1] - first, options_.neighbours);
      for (std::uint64_t m = first; m < first + count; ++m) {
        const std::uint32_t cost = transitions_.cost[m];
        if (cost > most_cost_) break;  // the best come first
        e.node = transitions_.target[m];
        const double interval = interval_s(node, briefs_.nodes[e.node - 1]);
        if (!in_reach(interval, target) || banned(parent.node, e.node)) continue;
        e.element = transitions_.element[m];
        offer(layer, e, log_time_factor(interval, target) - kCostUnit * cost, k + 1);
      }
    }
    return std::move(layer.entries);
  }

  bool banned(std::uint32_t from, std::uint32_t target) const {
    return !options_.banned.empty() &&
           std::binary_search(options_.banned.begin(), options_.banned.end(), splice_key(from, target));
  }

  // e leads to event k, with `log` in addition to what it holds.
  void offer(Layer& layer, Entry& e, double log, std::size_t k) const {
    const NodeBrief& node = briefs_.nodes[e.node];
    if (!fits(node, targets_, k)) return;
    const Entry before = e;
    const double sound = log_sound(node, targets_, k, e.first_amplitude);
    e.weight += static_cast<float>(log + sound);
    e.bound += static_cast<float>(log + kindest_sound(node, k, e, sound));
    if (e.bound > incumbent_) layer.offer(e);
    e.weight = before.weight;
    e.bound = before.bound;
  }

  // The best that `sound` could be were the first event's loudness any in its bin.
  double kindest_sound(const NodeBrief& node, std::size_t k, const Entry& e, double sound) const {
    if (targets_.amplitudes.empty()) return sound;
    const double own = node.amplitude / e.first_amplitude, wanted = targets_.amplitudes[k];
    const double middle = node.amplitude / std::exp(kLoudnessStep * e.loudness);
    const double half = std::exp(0.5 * kLoudnessStep);
    const double kindest = std::clamp(wanted, middle / half, middle * half);
    return sound - log_amplitude_factor(own, wanted) + log_amplitude_factor(kindest, wanted);
  }

  void keep_best(std::vector<Entry>& layer) {
    if (layer.size() <= options_.most_states) return;
    const auto better = [](const Entry& a, const Entry& b) {
      return a.weight != b.weight ? a.weight > b.weight
                                  : std::pair(a.node, a.loudness) < std::pair(b.node, b.loudness);
    };
    const auto cut = layer.begin() + static_cast<std::ptrdiff_t>(options_.most_states);
    std::nth_element(layer.begin(), cut, layer.end(), better);
    for (auto it = cut; it != layer.end(); ++it)
      dropped_ = std::max(dropped_, static_cast<double>(it->bound));
    layer.erase(cut, layer.end());
  }

  std::vector<GraphPath> traced() const {
    std::vector<std::uint32_t> order(layers_.back().size());
    std::iota(order.begin(), order.end(), 0u);
    const auto& last = layers_.back();
    const std::size_t count = std::min(options_.paths, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                      [&](std::uint32_t a, std::uint32_t b) {
                        return std::pair(-last[a].weight, last[a].node) <
                               std::pair(-last[b].weight, last[b].node);
                      });
    // Of paths that go all the way: where these do not, there are none but among those that were dropped.
    const bool whole = layers_.size() + 1 == targets_.size();
    double bound = dropped_;
    if (whole)
      for (const Entry& e : last) bound = std::max(bound, static_cast<double>(e.bound));
    std::vector<GraphPath> paths;
    for (std::size_t p = 0; p < count; ++p) {
      GraphPath path;
      path.log_weight = whole ? last[order[p]].weight : kNothing;
      path.log_bound = bound;
      std::uint32_t at = order[p];
      for (std::size_t l = layers_.size(); l-- > 0;) {
        const Entry& e = layers_[l][at];
        path.steps.push_back({e.node, e.element, e.spliced});
        at = e.parent;
      }
      path.steps.push_back({at, 0, false});
      std::reverse(path.steps.begin(), path.steps.end());
      paths.push_back(std::move(path));
    }
    return paths;
  }

  const Briefs& briefs_;
  const Transitions& transitions_;
  const Targets& targets_;
  const LayeredOptions& options_;
  double incumbent_;
  std::uint32_t most_cost_;
  double dropped_ = kNothing;
  std::vector<std::vector<Entry>> layers_;
};

}  // namespace

Briefs::Briefs(const Nodes& of) {
  nodes.reserve(of.size());
  for (std::size_t i = 0; i < of.size(); ++i) {
    nodes.push_back(brief_of(of, i));
    if (usable_edge(nodes.back())) by_interval.push_back(static_cast<std::uint32_t>(i));
  }
  std::stable_sort(by_interval.begin(), by_interval.end(), [this](std::uint32_t a, std::uint32_t b) {
    return interval_s(nodes[a], nodes[a]) < interval_s(nodes[b], nodes[b]);
  });
}

std::vector<GraphPath> single_events(const Briefs& briefs, const Targets& targets, std::size_t most) {
  std::vector<std::pair<double, std::uint32_t>> ranked;  // log weight, node
  for (std::uint32_t i = 0; i < briefs.nodes.size(); ++i)
    if (fits(briefs.nodes[i], targets, 0))
      ranked.emplace_back(log_sound(briefs.nodes[i], targets, 0, 1.0), i);
  // A fixed shuffle, so that of equal ones not only the first simulations' are taken.
  const auto mixed = [](std::uint32_t i) { return i * 0x9E3779B1u; };
  most = std::min(most, ranked.size());
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(most), ranked.end(),
                    [&](const auto& a, const auto& b) {
                      return a.first != b.first ? a.first > b.first : mixed(a.second) < mixed(b.second);
                    });
  std::vector<GraphPath> paths;
  for (std::size_t i = 0; i < most; ++i)
    paths.push_back({{{ranked[i].second, 0, false}}, ranked[i].first, ranked.front().first});
  return paths;
}

GraphPath best_suffix(const Briefs& briefs, const Targets& targets, double most_retime) {
  GraphPath best;
  best.log_weight = best.log_bound = kNothing;
  std::uint32_t best_root = 0;
  const auto& order = briefs.by_interval;
  const auto interval = [&](std::uint32_t i) { return interval_s(briefs.nodes[i], briefs.nodes[i]); };
  const double first = targets.intervals_s[0];
  auto it = std::lower_bound(order.begin(), order.end(), first / most_retime,
                             [&](std::uint32_t i, double t) { return interval(i) < t; });
  for (; it != order.end() && interval(*it) <= most_retime * first; ++it) {
    const std::uint32_t root = *it;
    const double amplitude = briefs.nodes[root].amplitude;
    double weight = log_sound(briefs.nodes[root], targets, 0, amplitude);
    std::size_t k = 0;
    for (; k + 1 < targets.size(); ++k) {
      const std::uint32_t node = root + static_cast<std::uint32_t>(k);
      if (!usable_edge(briefs.nodes[node])) break;
      const double here = interval(node), target = targets.intervals_s[k];
      if (here > most_retime * target || target > most_retime * here) break;
      if (!fits(briefs.nodes[node + 1], targets, k + 1)) break;
      weight += log_time_factor(here, target) + log_sound(briefs.nodes[node + 1], targets, k + 1, amplitude);
      if (weight <= best.log_weight) break;
    }
    if (k + 1 == targets.size() && weight > best.log_weight) {
      best.log_weight = weight;
      best_root = root;
    }
  }
  if (best.log_weight == kNothing) return best;
  for (std::uint32_t k = 0; k < targets.size(); ++k) best.steps.push_back({best_root + k, 0, false});
  return best;
}

std::vector<GraphPath> search_layers(const Briefs& briefs, const Transitions& transitions,
                                     const Targets& targets, const LayeredOptions& options,
                                     const Progress* progress) {
  // A path within rounding of the incumbent must be found too.
  const double suffix = best_suffix(briefs, targets, options.most_retime).log_weight;
  return Search(briefs, transitions, targets, options, suffix - 1e-3 * std::abs(suffix)).run(progress);
}

}  // namespace ifa
