#include "ifa/forward/solve.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <utility>

#include "ifa/base/counted.hpp"
#include "ifa/base/message.hpp"
#include "ifa/forward/kept.hpp"
#include "ifa/forward/materials.hpp"
#include "ifa/forward/takes.hpp"
#include "ifa/solution/solution.hpp"

namespace ifa {
namespace {

constexpr int kLadder[] = {40, 120, 360, 1080, 2160, 4320};  // states in the beam

constexpr int kTrackedRungs = 1;   // while a known motion is kept to
constexpr int kMostSearches = 12;  // of one rung, for the takes that the first one lacks

constexpr int kLargestBeam = 100'000;

std::span<const int> ladder_of(const SolveOptions& options) {
  return options.ladder.empty() ? standard_ladder() : std::span<const int>(options.ladder);
}

void check(const SolveOptions& options) {
  if (!(options.time_budget_s > 0.0)) throw ArgumentError("time_budget_s: must be above 0");
  if (!(options.energy_gain_j >= 0.0)) throw ArgumentError("energy_gain_j: must be 0 or more");
  const std::span<const int> ladder = ladder_of(options);
  if (ladder.front() < 1 || ladder.back() > kLargestBeam ||
      std::ranges::adjacent_find(ladder, std::greater_equal{}) != ladder.end())
    throw ArgumentError("ladder: beams must grow from rung to rung, from 1 to " +
                        std::to_string(kLargestBeam) + " states");
  const int last = static_cast<int>(ladder.size()) - 1;
  if (options.rung > last) throw ArgumentError("rung: the last one is " + std::to_string(last));
  if (options.least_rung < 0 || options.least_rung > last)
    throw ArgumentError("least_rung: must be from 0 to " + std::to_string(last));
  if (options.takes < 1) throw ArgumentError("takes: must be 1 or more");
  if (!(options.lead_in_s > 0.0)) throw ArgumentError("lead_in_s: must be above 0");
  if (options.proposals.roots < 1) throw ArgumentError("roots: must be 1 or more");
  if (options.proposals.variants < 0) throw ArgumentError("variants: must be 0 or more");
}

class Solver {
 public:
  Solver(const Body& body, const Marks& marks, const SolveOptions& options, Progress* progress)
      : options_(options), ladder_(ladder_of(options)), progress_(progress) {
    kept_.physics.energy_gain_j = options.energy_gain_j;
    kept_.physics.hearing.events = options.events;
    kept_.plan = make_plan(body, marks,
                           {options.events, options.fit_material, options.lead_in_s, false, options.forced});
    const Plan& plan = kept_.plan;
    plan.apply(kept_.physics.hearing);
    kept_.physics.simulation.sustained_contact = plan.on(Effect::sustained_contact);
    kept_.marks = plan.seen(marks);
    const Body own = with_effects(body, plan.engine_effects());
    for (const Material& material : materials_to_try(body, marks, plan.on(Effect::material_fit)))
      kept_.bodies.push_back(own.with_material(material));
    if (options.reuse) check_reuse(*options.reuse, own, kept_.physics, plan);
  }

  Solution solve() {
    if (options_.reuse) go_on(*options_.reuse);
    if (takes_.empty() || !takes_.front().satisfies()) climb();
    if (!takes_.empty() && takes_.front().plausible) add_takes();
    if (progress_) progress_->raise_to(1.0);
    if (takes_.empty())
      throw NoMotionError("no first contact was found from which a flight could reach " +
                          mark_name(0, kept_.marks.times_s[0]));
    const EffectCounts runs = counted_since(counts_before_);
    for (Solution& take : takes_) {
      take.plan = kept_.plan;
      take.effect_runs = runs;
    }
    Solution best = std::move(takes_.front());
    best.others.assign(std::make_move_iterator(takes_.begin() + 1), std::make_move_iterator(takes_.end()));
    best.kept = std::make_shared<const KeptSearch>(std::move(kept_));
    best.history = std::move(history_);
    return best;
  }

 private:
  double seconds_gone() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  }

  Problem problem() const { return {kept_.bodies, kept_.physics, kept_.marks, kept_.plan}; }

  int last_rung() const { return options_.rung >= 0 ? options_.rung : static_cast<int>(ladder_.size()) - 1; }

  double beam(int rung) const { return ladder_[static_cast<std::size_t>(rung)]; }

  BeamOptions beam_options(int rung) const {
    return {ladder_[static_cast<std::size_t>(rung)], options_.seed, options_.threads, options_.proposals,
            needs_no_search()};
  }

  bool content() const {
    const Solution& best = takes_.front();
    return options_.goal == Goal::succeeded ? best.succeeded && best.constraints_met() : best.satisfies();
  }

  // What a rung has found competes with what others did only as a whole.
  void offer(Beam&& beam, std::vector<Solution>&& takes, int rung) {
    for (Solution& s : takes) {
      s.rung = rung;
      s.simulated_s = beam.simulated_s;
    }
    if (takes_.empty() || better(takes.front(), takes_.front())) {
      takes_ = std::move(takes);
      kept_.rung = rung;
      kept_.beam = std::move(beam);
    }
    history_.push_back(stage_of(takes_.front(), rung, seconds_gone()));
  }

  std::vector<Solution> takes_of(const Beam& beam) const {
    return best_takes(problem(), beam, options_.takes, options_.lead_in_s, {}, progress_);
  }

  // Whether a rung that would take so long is begun: alone the clock decides that.
  bool in_time(double rung_s) const { return seconds_gone() + rung_s <= options_.time_budget_s; }

  // A call that leads half of the way that is left.
  Progress half() { return Progress(progress_, reached(), 0.5 * (1.0 + reached())); }
  double reached() const { return progress_ ? progress_->fraction() : 0.0; }

  void go_on(const KeptSearch& before) {
    const std::size_t same = std::min(marks_in_common(before.marks, kept_.marks), before.beam.levels.size());
    if (same == 0) return;
    const std::vector<Body> own = std::exchange(kept_.bodies, before.bodies);  // the levels refer to them
    const int last = std::min(last_rung(), before.rung);
    double rung_s = 0.0;
    const auto search = [&](int rung, auto&& beam_of) {
      if (!takes_.empty() && takes_.front().satisfies()) return;
      if (options_.rung < 0 && !in_time(rung_s)) return;
      const double began = seconds_gone();
      Progress part = half();
      Beam beam = beam_of(beam_options(rung), &part);
      rung_s = seconds_gone() - began;
      const bool sound = !beam.leaves.empty() && beam.leaves.front().violations == 0;
      if (!sound || beam.leaves.front().unmet > 0) return;  // the climb may do better
      auto takes = takes_of(beam);
      offer(std::move(beam), std::move(takes), rung);
    };
    for (int rung = 0; rung <= std::min(last, kTrackedRungs); ++rung)
      search(rung, [&](const BeamOptions& options, Progress* part) {
        return track_beam(problem(), options, part, before.beam, same);
      });
    for (int rung = 0; rung <= last; ++rung)
      search(rung, [&](const BeamOptions& options, Progress* part) {
        return search_beam(problem(), options, part, &before.beam, same);
      });
    if (!takes_.empty() && takes_.front().satisfies()) return;
    history_.clear();
    takes_.clear();  // what the climb finds has its own materials
    kept_.bodies = own;
  }

  // One of the first contacts that can be thrown will do.
  bool needs_no_search() const {
    const Marks& marks = kept_.marks;
    return marks.size() == 1 && marks.durations_s[0] == 0.0 && marks.constraints.empty() &&
           options_.takes == 1 && options_.events == Events::audible;
  }

  void climb() {
    const int first = std::max(options_.rung, 0), last = last_rung();
    const double from = reached(), parts = last - first + 1;
    double rung_s = 0.0;
    for (int rung = first; rung <= last; ++rung) {
      // A rung costs about as much more than the last one as it is larger, had that reached the end.
      if (rung > first && !in_time(rung_s * beam(rung) / beam(rung - 1))) return;
      const double rung_began = seconds_gone();
      const auto at = [&](int r) { return from + (1.0 - from) * (r - first) / parts; };
      Progress part(progress_, at(rung), at(rung + 1));
      Beam beam = search_beam(problem(), beam_options(rung), &part);
      const double share = static_cast<double>(std::max<std::size_t>(beam.levels.size(), 1)) /
                           static_cast<double>(kept_.marks.size());
      if (!beam.levels.empty()) {
        auto takes = takes_of(beam);
        offer(std::move(beam), std::move(takes), rung);
        if (rung >= options_.least_rung && content()) return;
      }
      rung_s = (seconds_gone() - rung_began) / share;
    }
  }

  // Takes that the beam lacks, from more searches of its rung with other random numbers.
  void add_takes() {
    const int rung = takes_.front().rung;
    double last_s = 0.0;
    for (int search = 1; search < kMostSearches && takes_.size() < static_cast<std::size_t>(options_.takes);
         ++search) {
      if (options_.rung < 0 && !in_time(last_s)) break;
      const double began = seconds_gone();
      BeamOptions other = beam_options(rung);
      other.seed += 0x9E3779B97F4A7C15u * static_cast<std::uint64_t>(search);
      Progress part = half();
      const Beam beam = search_beam(problem(), other, &part);
      last_s = seconds_gone() - began;
      if (beam.leaves.empty()) continue;
      for (Solution& s : best_takes(problem(), beam, options_.takes, options_.lead_in_s, takes_, progress_)) {
        s.rung = rung;
        s.simulated_s = beam.simulated_s;
        takes_.push_back(std::move(s));
      }
    }
    std::stable_sort(takes_.begin() + 1, takes_.end(), better);
  }

  const SolveOptions& options_;
  std::span<const int> ladder_;
  Progress* progress_;
  const EffectCounts counts_before_ = effect_counts;
  KeptSearch kept_{};
  std::vector<Solution> takes_;
  std::vector<Stage> history_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

}  // namespace

int rung_count() { return static_cast<int>(std::size(kLadder)); }
std::span<const int> standard_ladder() { return kLadder; }

Solution solve_forward(const Body& body, const Marks& marks, const SolveOptions& options,
                       Progress* progress) {
  validate(marks);
  check(options);
  return Solver(body, marks, options, progress).solve();
}

}  // namespace ifa
