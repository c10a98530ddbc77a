#include "ifa/forward/explain.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "ifa/base/error.hpp"
#include "ifa/solution/solution.hpp"

namespace ifa {
namespace {

constexpr int kRungs = 3;              // that say how well the marks can be met as they are
constexpr double kLadderShare = 0.1;   // of the budget, after which no next one of these begins
constexpr int kTrialRungs[] = {0, 1};  // of repairs: the second only where the first finds none plausible
constexpr double kAsAsked = 0.2;       // of the progress, for the marks as they are

enum class Grade { fails, succeeds, plausible };

struct Outcome {
  Grade grade = Grade::fails;
  double score = 0.0;
};

// One size of one line, and what it led to.
struct Tried {
  int size;
  Outcome outcome;
};

// A part of the progress, for trials whose number is not known: each takes half of what is left.
struct Part {
  double from, to;

  std::pair<double, double> next() {
    const double begin = std::exchange(from, 0.5 * (from + to));
    return {begin, from};
  }
};

class Explainer {
 public:
  Explainer(const Body& body, const Marks& marks, const SolveOptions& options, Progress* progress)
      : request_{body, marks, options.energy_gain_j, options.fit_material},
        options_(options),
        progress_(progress) {}

  const Request& request() const { return request_; }
  int trials() const { return trials_; }
  bool complete() const { return complete_; }

  std::optional<Solution> solve_as_asked() {
    std::optional<Solution> best;
    for (int rung = 0; rung < kRungs && !(best && best->plausible); ++rung) {
      if (rung > 0 && out_of_time(kLadderShare)) break;
      auto solution = solve(request_, rung, kAsAsked * rung / kRungs, kAsAsked * (rung + 1) / kRungs);
      if (solution && (!best || better(*solution, *best))) best = std::move(solution);
    }
    return best;
  }

  std::vector<Repair> repairs(const std::vector<Line>& lines, Grade as_asked) {
    std::vector<std::optional<Repair>> best(lines.size());
    const auto plausible = [](const std::optional<Repair>& r) { return r && r->plausible; };
    const double share = (1.0 - kAsAsked) / static_cast<double>(std::size(kTrialRungs));
    for (const int rung : kTrialRungs) {
      const double from = kAsAsked + share * rung;
      try_lines(lines, as_asked, rung, {from, from + share}, best);
      if (std::any_of(best.begin(), best.end(), plausible)) break;
    }
    std::vector<Repair> found;
    for (auto& repair : best)
      if (repair) found.push_back(std::move(*repair));
    std::stable_sort(found.begin(), found.end(), first);
    return found;
  }

 private:
  static bool first(const Repair& a, const Repair& b) {
    return a.plausible != b.plausible ? a.plausible : a.cost < b.cost;
  }

  // The sizes of all lines in the order of their costs. A line is done with its first plausible size; in the
  // end those without one may still better what was asked. Either way the smallest such size is then sought
  // by bisection, down from the last size that was not good enough.
  void try_lines(const std::vector<Line>& lines, Grade as_asked, int rung, const Part& whole,
                 std::vector<std::optional<Repair>>& best) {
    struct Entry {
      double cost;
      std::size_t line;
      int size;
    };
    std::vector<Entry> entries;
    for (std::size_t l = 0; l < lines.size(); ++l)
      for (const int size : lines[l].sizes)  // those that one trial decides come first
        entries.push_back({lines[l].sizes.size() == 1 ? 0.0 : cost(request_, lines[l], size), l, size});
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.cost < b.cost; });

    const auto keep = [&](std::size_t l, Repair&& repair) {
      if (!best[l] || first(repair, *best[l])) best[l] = std::move(repair);
    };
    std::vector<std::vector<Tried>> tried(lines.size());
    std::vector<char> done(lines.size(), 0);
    const double share = (whole.to - whole.from) / static_cast<double>(entries.size() + 1);
    double from = whole.from;
    for (const auto& [own_cost, l, size] : entries) {
      Part part{from, from + share};
      from += share;
      if (done[l]) continue;
      const auto outcome = attempt(lines[l], size, rung, part);
      if (!outcome) break;
      tried[l].push_back({size, *outcome});
      if (outcome->grade != Grade::plausible) continue;
      keep(l, smallest(lines[l], tried[l], Grade::plausible, rung, part));
      for (std::size_t other = 0; other < lines.size(); ++other)
        if (other == l || same_number(lines[other], lines[l])) done[other] = 1;
    }
    Part part{from, whole.to};
    for (std::size_t l = 0; l < lines.size() && as_asked == Grade::fails; ++l) {
      const auto good = std::find_if(tried[l].begin(), tried[l].end(),
                                     [](const Tried& t) { return t.outcome.grade == Grade::succeeds; });
      if (done[l] || good == tried[l].end()) continue;
      tried[l].erase(good + 1, tried[l].end());
      keep(l, smallest(lines[l], tried[l], Grade::succeeds, rung, part));
    }
  }

  // Restitution up and down are one number; so is friction.
  static bool same_number(const Line& a, const Line& b) {
    return a.kind == b.kind && (a.kind == RepairKind::restitution || a.kind == RepairKind::friction);
  }

  // Between the last of `tried`, which is as good as wanted, and the one before it, which was not.
  Repair smallest(const Line& line, const std::vector<Tried>& tried, Grade wanted, int rung, Part& part) {
    Tried best = tried.back();
    int below = tried.size() > 1 ? tried[tried.size() - 2].size : 0;
    while (best.size - below > 1) {
      const int middle = below + (best.size - below) / 2;
      const auto outcome = attempt(line, middle, rung, part);
      if (!outcome) break;
      if (outcome->grade >= wanted)
        best = {middle, *outcome};
      else
        below = middle;
    }
    return {line.kind,
            line.mark,
            amount(request_, line, best.size),
            cost(request_, line, best.size),
            text_of(request_, line, best.size),
            best.outcome.grade == Grade::plausible,
            best.outcome.score,
            changed(request_, line, best.size),
            rung};
  }

  // Nothing once the time is over.
  std::optional<Outcome> attempt(const Line& line, int size, int rung, Part& part) {
    if (out_of_time()) return std::nullopt;
    ++trials_;
    const auto [from, to] = part.next();
    const auto solution = solve(changed(request_, line, size), rung, from, to);
    if (!solution) return Outcome{};
    return Outcome{grade_of(*solution), solution->score};
  }

  static Grade grade_of(const Solution& s) {
    return s.plausible ? Grade::plausible : s.succeeded ? Grade::succeeds : Grade::fails;
  }

  std::optional<Solution> solve(const Request& request, int rung, double from, double to) {
    Progress progress(progress_, from, to);
    progress.throw_if_cancelled();
    SolveOptions options = options_;
    options.rung = rung;
    options.energy_gain_j = request.energy_gain_j;
    options.fit_material = request.fit_material;
    try {
      return solve_forward(request.body, request.marks, options, &progress);
    } catch (const NoMotionError&) {
      return std::nullopt;
    }
  }

  // Whether this share of the budget is over; what then does not begin is missing from the explanation.
  bool out_of_time(double share = 1.0) {
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - began_;
    const bool over = gone.count() >= share * options_.time_budget_s;
    complete_ = complete_ && !over;
    return over;
  }

  Request request_;
  SolveOptions options_;
  Progress* progress_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  int trials_ = 0;
  bool complete_ = true;
};

}  // namespace

Explanation explain(const Body& body, const Marks& marks, const SolveOptions& options, double merge_gap_s,
                    const Solution* known, Progress* progress) {
  validate(marks, merge_gap_s);
  if (known && known->events.size() != marks.size())
    throw ArgumentError("solution: has " + std::to_string(known->events.size()) + " events, but there are " +
                        std::to_string(marks.size()) + " marks");
  Explainer explainer(body, marks, options, progress);
  const Estimate expected = estimate(body, marks);  // refuses gaps too long to compute with
  std::optional<Solution> own;
  if (!known) {
    own = explainer.solve_as_asked();
    if (own) known = &*own;
  }
  Explanation out{};
  if (known) {
    out.succeeded = known->succeeded;
    out.plausible = known->plausible;
  }
  out.conflicts = conflicts_of(marks, expected, known);
  const auto as_asked = out.succeeded ? Grade::succeeds : Grade::fails;
  if (!out.conflicts.empty())
    out.repairs =
        explainer.repairs(lines_for(explainer.request(), out.conflicts, expected, merge_gap_s), as_asked);
  out.trials = explainer.trials();
  out.complete = explainer.complete();
  if (progress) progress->raise_to(1.0);
  return out;
}

}  // namespace ifa
