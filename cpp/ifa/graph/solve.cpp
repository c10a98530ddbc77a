#include "ifa/graph/solve.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <vector>

#include "ifa/base/counted.hpp"
#include "ifa/graph/branch_and_bound.hpp"
#include "ifa/graph/realise.hpp"
#include "ifa/motion/difference.hpp"
#include "ifa/solution/standard.hpp"

namespace ifa {
namespace {

struct Rung {
  std::size_t states;  // of a layer
  double retime;       // ratio
  double cost;         // of a splice, -log(f_v f_q)
};
constexpr Rung kLadder[] = {{20'000, 1.0 + kPlausible.retime, kPlausible.excess},
                            {200'000, 1.0 + kPlausible.retime, kPlausible.excess},
                            {50'000, 1.0 + kMostRetime, 20.0},
                            {1'000'000, 1.0 + kMostRetime, 20.0}};

constexpr std::size_t kPathsTried = 32;         // of a search
constexpr std::size_t kConstrainedTried = 200;  // where poses are constrained, which the search does not see
constexpr int kRepeats = 8;                     // of a search, without the splices that could not be flown

SearchPhysics physics_with(SearchPhysics physics, double energy_gain_j, const Plan& plan) {
  physics.energy_gain_j = energy_gain_j;
  plan.apply(physics.hearing);
  return physics;
}

class GraphSolver {
 public:
  GraphSolver(const ContactGraph& graph, const Marks& marks, const GraphOptions& options, Progress* progress)
      : graph_(graph),
        plan_(make_plan(
            graph.database().body(), marks,
            {graph.database().physics().hearing.events, false, options.lead_in_s, true, options.forced})),
        marks_(plan_.seen(marks)),
        targets_(marks_, plan_.sound_terms()),
        options_(options),
        progress_(progress),
        physics_(physics_with(graph.database().physics(), options.energy_gain_j, plan_)),
        realiser_(graph.database(), physics_, graph.images()) {}

  Solution solve() {
    // A single mark asks for no search: its node and the flight that leads there are the paper's answer too.
    if (options_.search == GraphSearch::branch_and_bound && targets_.size() > 1)
      branch_and_bound();
    else
      climb_ladder();
    if (takes_.empty())
      throw NoMotionError("database: no event in it can begin a motion that meets the first two marks");
    const EffectCounts runs = counted_since(counts_before_);
    for (Solution& take : takes_) {
      take.plan = plan_;
      take.effect_runs = runs;
    }
    Solution best = takes_.front();
    best.others.assign(takes_.begin() + 1, takes_.end());
    best.history = std::move(history_);
    return best;
  }

 private:
  bool enough() const { return takes_.size() >= static_cast<std::size_t>(options_.takes); }

  double seconds_gone() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  }

  void climb_ladder() {
    const int first = std::max(options_.rung, 0),
              last = options_.rung >= 0 ? options_.rung : graph_rung_count() - 1;
    for (int rung = first; rung <= last; ++rung) {
      if (rung > first && seconds_gone() > options_.time_budget_s) break;
      climb(rung);
      note(rung);
      if (progress_) progress_->raise_to(static_cast<double>(rung - first + 1) / (last - first + 1));
      if (!takes_.empty() && takes_.front().satisfies() && enough()) break;
    }
  }

  void branch_and_bound() {
    const Database& database = graph_.database();
    BranchAndBoundOptions options;
    options.most_retime = 1.0 + kMostRetime;  // what is retimed more does not succeed, whatever its Score
    options.time_limit_s = options_.time_budget_s - seconds_gone();
    options.children = options_.sizes.children;
    const GraphPath path = search_branch_and_bound(
        {database.nodes(), database.body(), graph_.briefs(), graph_.trees(),
         physics_.simulation.gravity_m_s2.norm(), options_.energy_gain_j},
        targets_, options, [this](const GraphPath& p) { return realiser_.realise(p, targets_).failed_step; },
        progress_);
    if (path.steps.empty()) return;
    const Realised realised = realiser_.realise(path, targets_);
    if (!realised.found.links.empty()) offer(realised.found, path, 0);
    note(0);
  }

  void note(int rung) {
    if (!takes_.empty()) history_.push_back(stage_of(takes_.front(), rung, seconds_gone()));
  }

  void climb(int rung) {
    LayeredOptions layered;
    layered.most_states = options_.sizes.states > 0 ? options_.sizes.states : kLadder[rung].states;
    if (options_.sizes.neighbours > 0) layered.neighbours = options_.sizes.neighbours;
    layered.most_retime = kLadder[rung].retime;
    layered.most_cost = kLadder[rung].cost;
    layered.paths = marks_.constraints.empty() ? kPathsTried : kConstrainedTried;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
      const std::vector<GraphPath> paths =
          targets_.size() == 1
              ? single_events(graph_.briefs(), targets_, layered.paths)
              : search_layers(graph_.briefs(), graph_.transitions(), targets_, layered, progress_);
      std::size_t banned = layered.banned.size();
      for (const GraphPath& path : paths) {
        const Realised realised = realiser_.realise(path, targets_);
        if (realised.failed_step && path.steps[*realised.failed_step].spliced)
          layered.banned.push_back(
              splice_key(path.steps[*realised.failed_step - 1].node, path.steps[*realised.failed_step].node));
        if (!realised.found.links.empty()) offer(realised.found, path, rung);
      }
      std::sort(layered.banned.begin(), layered.banned.end());
      layered.banned.erase(std::unique(layered.banned.begin(), layered.banned.end()), layered.banned.end());
      if (layered.banned.size() == banned || (!takes_.empty() && takes_.front().succeeded && enough()))
        return;
    }
  }

  // Keeps it where it is better than the best, or a further take.
  void offer(const Found& found, const GraphPath& path, int rung) {
    Solution s = make_solution(graph_.database().body(), physics_, marks_, plan_, found, options_.lead_in_s,
                               progress_);
    s.rung = rung;
    s.search_log_weight = path.log_weight;
    s.search_log_bound = path.log_bound;
    if (takes_.empty()) {
      takes_.push_back(s);
      return;
    }
    const double from = marks_.times_s.front(), to = marks_.times_s.back();
    const auto alike = [&](const Solution& a, const Solution& b) {
      return difference(*a.motion, *b.motion, from,
                        to > from ? to : std::max(a.motion->end_s(), b.motion->end_s())) < kClearlyDifferent;
    };
    if (better(s, takes_.front())) {
      std::swap(s, takes_.front());
      std::erase_if(takes_,
                    [&](const Solution& t) { return &t != &takes_.front() && alike(t, takes_.front()); });
    }
    if (options_.takes == 1 || s.plausible != takes_.front().plausible || !s.succeeded) return;
    if (enough() || std::ranges::any_of(takes_, [&](const Solution& t) { return alike(t, s); })) return;
    takes_.push_back(s);
    std::stable_sort(takes_.begin() + 1, takes_.end(), better);
  }

  const EffectCounts counts_before_ = effect_counts;
  const ContactGraph& graph_;
  Plan plan_;
  Marks marks_;
  Targets targets_;
  const GraphOptions& options_;
  Progress* progress_;
  SearchPhysics physics_;
  Realiser realiser_;
  std::vector<Solution> takes_;  // the best first
  std::vector<Stage> history_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

}  // namespace

int graph_rung_count() { return static_cast<int>(std::size(kLadder)); }

Solution solve_graph(const ContactGraph& graph, const Marks& marks, const GraphOptions& options,
                     Progress* progress) {
  validate(marks, graph.database().physics().hearing.merge_gap_s);
  if (options.search == GraphSearch::branch_and_bound && options.rung > 0)
    throw ArgumentError("rung: branch and bound has a single one, got " + std::to_string(options.rung));
  if (options.rung >= graph_rung_count())
    throw ArgumentError("rung: method=\"graph\" has " + std::to_string(graph_rung_count()) + " rungs, got " +
                        std::to_string(options.rung));
  return GraphSolver(graph, marks, options, progress).solve();
}

}  // namespace ifa
