#include "ifa/graph/branch_and_bound.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include "ifa/signature/factors.hpp"

namespace ifa {
namespace {

constexpr double kNothing = -std::numeric_limits<double>::infinity();

struct Edge {
  std::uint32_t to;
  bool spliced;
  double log_weight;
};

class BranchAndBound {
 public:
  BranchAndBound(const SearchedGraph& graph, const Targets& targets, const BranchAndBoundOptions& options,
                 const FirstInfeasible& first_infeasible, const Progress* progress)
      : graph_(graph),
        targets_(targets),
        options_(options),
        first_infeasible_(first_infeasible),
        progress_(progress) {}

  GraphPath run() {
    for (const Edge& root : first_edges()) {
      if (root.log_weight <= least()) break;  // the others are worse still
      go_on_from(root);
      const bool good = complete(best_) && options_.early_exit_score &&
                        std::exp(best_.log_weight / (6.0 * static_cast<double>(targets_.size()))) >=
                            *options_.early_exit_score;
      if (good || time_over()) break;
    }
    return best_;
  }

 private:
  bool complete(const GraphPath& path) const { return path.steps.size() == targets_.size(); }
  double least() const { return complete(best_) ? best_.log_weight : kNothing; }

  bool time_over() const {
    if (progress_) progress_->throw_if_cancelled();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count() >=
           options_.time_limit_s;
  }

  bool in_reach(double interval, double target) const {
    return interval <= options_.most_retime * target && target <= options_.most_retime * interval;
  }

  // Best first; `to` is the second event.
  std::vector<Edge> first_edges() const {
    const std::vector<NodeBrief>& nodes = graph_.briefs.nodes;
    std::vector<Edge> edges;
    for (const std::uint32_t i : graph_.briefs.by_interval) {
      const double interval = interval_s(nodes[i], nodes[i]);
      const double time = log_time_factor(interval, targets_.intervals_s[0]);
      if (time <= kLeastLogFactor || !in_reach(interval, targets_.intervals_s[0]) ||
          !fits(nodes[i + 1], targets_, 1))
        continue;
      const double log = time + log_sound(nodes[i], targets_, 0, nodes[i].amplitude) +
                         log_sound(nodes[i + 1], targets_, 1, nodes[i].amplitude);
      if (log > kNothing) edges.push_back({i + 1, false, log});
    }
    best_first(edges);
    return edges;
  }

  static void best_first(std::vector<Edge>& edges) {
    std::ranges::sort(edges, [](const Edge& a, const Edge& b) {
      return a.log_weight != b.log_weight ? a.log_weight > b.log_weight : a.to < b.to;
    });
  }

  void go_on_from(const Edge& root) {
    path_ = {{{root.to - 1, 0, false}, {root.to, 0, false}}, root.log_weight, 0.0};
    first_amplitude_ = graph_.briefs.nodes[root.to - 1].amplitude;
    known_.clear();
    std::erase_if(infeasible_, [](std::uint64_t key) { return (key >> 32) + 1 == (key & 0xffffffff); });
    keep_if_best();
    while (!complete(path_)) {
      if (!best_sub_path()) return;
      if (const std::optional<std::size_t> step = first_infeasible_(sub_path_)) {
        const std::size_t at = std::clamp<std::size_t>(*step, 1, sub_path_.steps.size() - 1);
        infeasible_.insert(splice_key(sub_path_.steps[at - 1].node, sub_path_.steps[at].node));
        if (at < path_.steps.size()) return;  // in what was kept
        continue;
      }
      extend();
      keep_if_best();
    }
  }

  // Along sub_path_, which is feasible; all of it where it ends the path, for that is the best end of what
  // would be kept of it.
  void extend() {
    if (complete(sub_path_)) {
      path_ = sub_path_;
      return;
    }
    const std::size_t kept = path_.steps.size() + std::max<std::size_t>(options_.keep, 1);
    while (path_.steps.size() < std::min(kept, sub_path_.steps.size())) {
      const Step& step = sub_path_.steps[path_.steps.size()];
      for (const Edge& edge : edges_from(path_.steps.back().node, path_.steps.size() - 1))
        if (edge.to == step.node) path_.log_weight += edge.log_weight;
      path_.steps.push_back(step);
    }
  }

  void keep_if_best() {
    const std::size_t steps = path_.steps.size(), held = best_.steps.size();
    if (steps > held || (steps == held && path_.log_weight > best_.log_weight)) best_ = path_;
  }

  // Whether there is one that is better than the best path.
  bool best_sub_path() {
    horizon_ = std::min(path_.steps.size() + std::max<std::size_t>(options_.depth, 1), targets_.size());
    sub_path_ = {{}, least(), 0.0};
    GraphPath tried = path_;
    explore(tried);
    return !sub_path_.steps.empty() && !time_over();
  }

  // Weights are at most 1: what a path is worth, no continuation exceeds.
  void explore(GraphPath& tried) {
    if (tried.steps.size() == horizon_) {
      sub_path_ = tried;
      return;
    }
    if (time_over()) return;
    const std::uint32_t from = tried.steps.back().node;
    const double log = tried.log_weight;
    for (const Edge& edge : edges_from(from, tried.steps.size() - 1)) {
      if (log + edge.log_weight <= sub_path_.log_weight) break;  // the best come first
      if (infeasible_.contains(splice_key(from, edge.to))) continue;
      tried.steps.push_back({edge.to, 0, edge.spliced});
      tried.log_weight = log + edge.log_weight;
      explore(tried);
      tried.steps.pop_back();
    }
    tried.log_weight = log;
  }

  // From event k at `from` to event k + 1, best first. Remembered while the first edge is the same.
  const std::vector<Edge>& edges_from(std::uint32_t from, std::size_t k) {
    const auto [at, is_new] = known_.try_emplace(static_cast<std::uint64_t>(k) << 32 | from);
    std::vector<Edge>& edges = at->second;
    if (!is_new) return edges;
    const std::vector<NodeBrief>& nodes = graph_.briefs.nodes;
    const auto add = [&](std::uint32_t to, bool spliced, double log_static) {
      const double interval = interval_s(nodes[from], nodes[spliced ? to - 1 : from]);
      const double log = log_static + log_time_factor(interval, targets_.intervals_s[k]) +
                         log_sound(nodes[to], targets_, k + 1, first_amplitude_);
      if (log > kNothing && in_reach(interval, targets_.intervals_s[k])) edges.push_back({to, spliced, log});
    };
    if (usable_edge(nodes[from]) && fits(nodes[from + 1], targets_, k + 1)) add(from + 1, false, 0.0);
    if (nodes[from].flight_s > 0.0f) {
      const TakeOffView take_off = take_off_of(graph_.nodes, from);
      const PlausibleRegion region = region_of(graph_.nodes, from, graph_.body);
      std::size_t left = options_.children;
      for (const Neighbour& n : graph_.trees.nearest(from, targets_, k + 1, options_.children + 1)) {
        if (n.index == from + 1 || left == 0) continue;
        --left;
        if (!fits(nodes[n.index], targets_, k + 1)) continue;
        const Splice s =
            splice(take_off, region, take_off_of(graph_.nodes, n.index - 1), nodes[n.index - 1].flight_s);
        if (s.log_velocity > kLeastLogFactor && s.log_orientation > kLeastLogFactor &&
            keeps_energy(graph_.nodes, from, n.index, s, graph_.body, graph_.gravity_m_s2,
                         graph_.energy_gain_j))
          add(n.index, true, s.log_weight());
      }
    }
    best_first(edges);
    return edges;
  }

  const SearchedGraph& graph_;
  const Targets& targets_;
  const BranchAndBoundOptions& options_;
  const FirstInfeasible& first_infeasible_;
  const Progress* progress_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();

  GraphPath best_;
  std::unordered_set<std::uint64_t> infeasible_;  // splice_key
  // Of the first edge that is gone on from:
  GraphPath path_;           // what is kept
  GraphPath sub_path_;       // that, and the best way on
  std::size_t horizon_ = 0;  // steps of it
  double first_amplitude_ = 0.0;
  std::unordered_map<std::uint64_t, std::vector<Edge>> known_;  // by event and node
};

}  // namespace

GraphPath search_branch_and_bound(const SearchedGraph& graph, const Targets& targets,
                                  const BranchAndBoundOptions& options,
                                  const FirstInfeasible& first_infeasible, const Progress* progress) {
  return BranchAndBound(graph, targets, options, first_infeasible, progress).run();
}

}  // namespace ifa
