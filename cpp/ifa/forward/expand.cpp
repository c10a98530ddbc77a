#include "ifa/forward/expand.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/forward/root.hpp"

namespace ifa {
namespace {

constexpr int kPool = 8;  // changes tried for a candidate in one round
constexpr int kRefinements = 8;
constexpr double kOnTime_s = 1e-5, kOnTimeShare = 1e-4;  // what is left is retimed away: nobody could see it
constexpr double kLateShare = 1.35;                      // a passage is followed this far beyond its target

// How long a passage that leaves event k is followed.
double limit_s(const Problem& problem, std::size_t k) {
  if (k + 1 < problem.marks.size()) return kLateShare * problem.target_s(k);
  return problem.marks.ending == Ending::rest ? kLongestRest_s : kOpenTail_s;
}

PlausibleRegion region_of(const Body& body, const Onset& onset) {
  return PlausibleRegion(onset.after.velocity - onset.before.velocity,
                         onset.after.angular_velocity - onset.before.angular_velocity,
                         body.bounding_radius_m());
}

Vec6 random_change(double largest_excess, RandomStream& random) {
  Vec6 y;
  for (int i = 0; i < 6; ++i) y[i] = random.normal();
  return y * (std::sqrt(largest_excess) * std::sqrt(random.uniform()) / y.norm());
}

double ratio_of(double a, double b) { return std::max(a, b) / std::min(a, b); }

bool hits(const Passage& passage) { return passage.next == Next::hit || passage.next == Next::dubious; }

// Of two ways to meet a mark, the milder one.
double worth(const Trial& t, double target_s) {
  const double time = ratio_of(t.passage.interval_s, target_s) - 1.0;
  return -t.excess - 100.0 * time * time;  // log f_v f_t
}

// A root search between a trial that comes early and one that comes late.
struct Closing {
  std::size_t candidate;
  Vec6 from, along;
  Bracket bracket;
  Trial best;
  double best_worth;
  bool open = true;
};

}  // namespace

Expander::Expander(const Problem& problem, int body, const Progress* progress)
    : problem_(problem),
      body_index_(body),
      body_(problem.bodies[static_cast<std::size_t>(body)]),
      progress_(progress),
      passages_(body_, problem.physics) {}

// The state after the change `trial.y`; false if it is not allowed.
bool Expander::prepare(const Candidate& candidate, double largest_excess, Trial& trial) const {
  const Onset& onset = candidate.onset;
  const PlausibleRegion region = region_of(body_, onset);
  trial.excess = trial.y.squaredNorm();
  trial.after = onset.after;
  trial.after.velocity += region.velocity_offset(trial.y);
  trial.after.angular_velocity += region.spin_offset(trial.y);
  if (passages_.settle(trial.after)) {
    trial.excess = region.excess(trial.after.velocity - onset.after.velocity,
                                 trial.after.angular_velocity - onset.after.angular_velocity);
    if (trial.excess > largest_excess) return false;
  }
  // f_E (paper eq. 10)
  return kinetic_energy(body_, trial.after) <=
         kinetic_energy(body_, onset.before) + problem_.physics.energy_gain_j;
}

void Expander::run(std::span<const Candidate> candidates, std::size_t k, std::vector<Trial>& trials) {
  departures_.clear();
  for (const Trial& t : trials)
    departures_.push_back(
        {candidates[t.candidate].onset.hit, t.after, problem_.marks.durations_s[k], limit_s(problem_, k)});
  arrivals_.resize(trials.size());
  passages_.run(departures_, arrivals_, progress_);
  for (std::size_t i = 0; i < trials.size(); ++i) {
    trials[i].passage = arrivals_[i];
    const bool meets = k + 1 < problem_.marks.size() && hits(arrivals_[i]);
    trials[i].lateness_s = meets ? arrivals_[i].interval_s - problem_.target_s(k) : kNever;
  }
}

void Expander::add_child(const Candidate& parent, std::size_t index, std::size_t k,
                         const Tolerance& tolerance, const Trial& trial,
                         std::vector<Candidate>& children) const {
  const Marks& marks = problem_.marks;
  const Passage& passage = trial.passage;
  if (passage.next != Next::hit || trial.excess > tolerance.excess) return;
  const double interval = passage.interval_s, target = problem_.target_s(k);
  const double ratio = ratio_of(interval, target);
  if (ratio > 1.0 + tolerance.retime) return;
  // Retiming must not carry a hit out of the span that excuses it, nor part hits that the merge gap holds
  // together.
  const double stretch = target / interval;
  if (passage.event.loose_s * stretch > marks.durations_s[k]) return;
  if (passage.event.gap_s * stretch >= problem_.physics.hearing.merge_gap_s) return;
  Candidate child;
  child.onset = passage.onset;
  child.parent = static_cast<int>(index);
  child.start = k == 0 ? child.parent : parent.start;
  child.body = body_index_;
  child.from = {trial.after, trial.excess, interval};
  child.first_amplitude = k == 0 ? passage.event.amplitude : parent.first_amplitude;
  Factors f = sound_factors(passage.event, marks, k, child.first_amplitude);
  f.velocity = velocity_factor(trial.excess);
  f.time = time_factor(interval, target);
  child.log_weight = parent.log_weight + log_product(f);
  child.violations =
      parent.violations + (trial.excess > kPlausible.excess || ratio > 1.0 + kPlausible.retime ? 1 : 0);
  children.push_back(child);
}

// What look_ahead has seen.
Trial Expander::unchanged_trial(const Candidate& candidate, std::size_t index, std::size_t k) const {
  const Passage& passage = candidate.unchanged;
  return {index,
          Vec6(Vec6::Zero()),
          candidate.onset.after,
          0.0,
          passage,
          hits(passage) ? passage.interval_s - problem_.target_s(k) : kNever};
}

void Expander::expand(std::span<const Candidate> parents, std::size_t first, std::size_t k,
                      const ExpandOptions& options, std::span<RandomStream> random,
                      std::vector<Candidate>& children) {
  const Tolerance& tolerance = options.tolerance;
  const double target = problem_.target_s(k);
  const double reach = std::sqrt(tolerance.excess);
  std::vector<Trial> trials;
  for (std::size_t i = 0; i < parents.size(); ++i) {
    for (int j = options.round == 0 ? 1 : 0; j < kPool; ++j) {
      Trial trial{};
      trial.candidate = i;
      if (options.round == 0 && j <= 2) {  // a livelier and a duller bounce
        trial.y.setZero();
        trial.y[0] = (j == 1 ? 0.95 : -0.95) * reach;
      } else {
        trial.y = random_change(tolerance.excess, random[i]);
      }
      if (prepare(parents[i], tolerance.excess, trial)) trials.push_back(trial);
    }
  }
  run(parents, k, trials);

  // Pairs that enclose the target, the mildest changes first, each trial used once.
  std::vector<Closing> closings;
  std::vector<std::vector<std::size_t>> early(parents.size()), late(parents.size());
  const std::size_t tried = trials.size();
  for (std::size_t i = 0; i < parents.size(); ++i) {  // the unchanged one was looked at before
    trials.push_back(unchanged_trial(parents[i], i, k));
  }
  for (std::size_t t = 0; t < trials.size(); ++t)
    (trials[t].lateness_s < 0.0 ? early : late)[trials[t].candidate].push_back(t);
  std::vector<char> used(trials.size(), 0);
  if (options.round > 0) std::fill(used.begin() + static_cast<std::ptrdiff_t>(tried), used.end(), char{1});
  const auto milder = [&](std::size_t a, std::size_t b) { return trials[a].excess < trials[b].excess; };
  for (std::size_t i = 0; i < parents.size(); ++i) {
    std::stable_sort(early[i].begin(), early[i].end(), milder);
    std::stable_sort(late[i].begin(), late[i].end(), milder);
    const std::size_t pairs =
        std::min({early[i].size(), late[i].size(), static_cast<std::size_t>(options.proposals)});
    for (std::size_t pair = 0; pair < pairs; ++pair) {
      const Trial &a = trials[early[i][pair]], &b = trials[late[i][pair]];
      used[early[i][pair]] = used[late[i][pair]] = 1;
      Closing c{i, a.y, b.y - a.y, Bracket({0.0, a.lateness_s}, {1.0, b.lateness_s}), {}, -kNever};
      for (const Trial* end : {&a, &b})
        if (end->passage.next == Next::hit && worth(*end, target) > c.best_worth) {
          c.best = *end;
          c.best_worth = worth(*end, target);
        }
      closings.push_back(c);
    }
  }
  const double on_time = std::max(kOnTime_s, kOnTimeShare * target);
  std::vector<Trial> steps;
  std::vector<std::size_t> owners;
  std::vector<double> where;
  for (int refinement = 0; refinement < kRefinements; ++refinement) {
    steps.clear();
    owners.clear();
    where.clear();
    for (std::size_t c = 0; c < closings.size(); ++c) {
      if (!closings[c].open) continue;
      const double x = closings[c].bracket.next();
      Trial trial{};
      trial.candidate = closings[c].candidate;
      trial.y = closings[c].from + x * closings[c].along;
      if (!prepare(parents[trial.candidate], tolerance.excess, trial)) {
        closings[c].open = false;
        continue;
      }
      steps.push_back(trial);
      owners.push_back(c);
      where.push_back(x);
    }
    if (steps.empty()) break;
    run(parents, k, steps);
    for (std::size_t s = 0; s < steps.size(); ++s) {
      Closing& c = closings[owners[s]];
      c.bracket.add({where[s], steps[s].lateness_s});
      if (steps[s].passage.next == Next::hit && worth(steps[s], target) > c.best_worth) {
        c.best = steps[s];
        c.best_worth = worth(steps[s], target);
      }
      if (std::abs(steps[s].lateness_s) <= on_time) c.open = false;
    }
  }
  const std::size_t begin = children.size();
  for (const Closing& c : closings)
    if (c.best_worth > -kNever)
      add_child(parents[c.candidate], first + c.candidate, k, tolerance, c.best, children);
  for (std::size_t t = 0; t < trials.size(); ++t)
    if (!used[t])
      add_child(parents[trials[t].candidate], first + trials[t].candidate, k, tolerance, trials[t], children);
  look_ahead(std::span(children).subspan(begin), k + 1);
}

void Expander::follow(std::span<const Candidate> parents, std::size_t first, std::size_t k,
                      const Tolerance& tolerance, std::vector<Candidate>& children) {
  const std::size_t begin = children.size();
  for (std::size_t i = 0; i < parents.size(); ++i)
    add_child(parents[i], first + i, k, tolerance, unchanged_trial(parents[i], i, k), children);
  look_ahead(std::span(children).subspan(begin), k + 1);
}

void Expander::look_ahead(std::span<Candidate> candidates, std::size_t k) {
  const Marks& marks = problem_.marks;
  std::vector<Trial> trials(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    trials[i].candidate = i;
    trials[i].after = candidates[i].onset.after;
  }
  run(candidates, k, trials);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Candidate& c = candidates[i];
    c.unchanged = trials[i].passage;
    c.outlook = 0.0;
    if (!marks.amplitudes.empty() && k > 0) {
      const Factors f = sound_factors(c.unchanged.event, marks, k, c.first_amplitude);
      c.outlook += std::log(std::max(f.amplitude, 1e-300));
    }
    if (k + 1 == marks.size()) {
      if (marks.ending == Ending::rest && c.unchanged.next != Next::rest) c.outlook -= 3.0;
      continue;
    }
    // A change moves the next hit by some ten percent.
    constexpr double kReach = 0.25, kRest = 0.8, kLate = 0.5;
    double miss = hits(c.unchanged)                ? std::log(c.unchanged.interval_s / problem_.target_s(k))
                  : c.unchanged.next == Next::late ? kLate
                                                   : kRest;
    miss /= kReach;
    c.outlook -= 0.5 * miss * miss;
  }
}

std::vector<Trial> Expander::finish(std::span<const Candidate> candidates, int changes, double largest_excess,
                                    std::span<RandomStream> random) {
  const Marks& marks = problem_.marks;
  const std::size_t k = marks.size() - 1;
  const bool rest = marks.ending == Ending::rest;
  std::vector<Trial> trials;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (int j = 0; j < changes; ++j) {
      Trial trial{};
      trial.candidate = i;
      trial.y.setZero();
      if (j > 0) {
        trial.y = random_change(largest_excess, random[i]);
        if (rest && j % 2 == 1) trial.y[0] = -std::abs(trial.y[0]);  // a duller bounce rests sooner
      }
      if (prepare(candidates[i], largest_excess, trial)) trials.push_back(trial);
    }
  }
  run(candidates, k, trials);
  std::vector<Trial> best(candidates.size());
  for (Trial& b : best) b.excess = kNever;
  for (const Trial& t : trials) {
    if (t.passage.next == Next::dubious || (rest && t.passage.next != Next::rest)) continue;
    if (t.excess < best[t.candidate].excess) best[t.candidate] = t;
  }
  return best;
}

}  // namespace ifa
