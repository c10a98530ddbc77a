#include "ifa/forward/expand.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/forward/closing.hpp"
#include "ifa/forward/steepest.hpp"
#include "ifa/forward/steer.hpp"
#include "ifa/forward/track.hpp"

namespace ifa {
namespace {

constexpr std::size_t kLengthClosings = 3;  // root searches of the last event's length for a candidate
constexpr int kScattered = 8;               // changes tried for a candidate in one round
constexpr double kSecondWeight = 0.3;       // of what is seen beyond the next mark, where changes will matter
constexpr double kNoticed = 1.0;            // of the log weight: as much as 12 mm off a position
constexpr double kEdge = 0.99;              // of the region's radius: as far as a change goes along a line
constexpr double kOvershoot = 1.2;          // beyond where the mark should be, so that it is enclosed

// The slices of `trials`, which are ordered by candidate, with the unchanged one of each.
template <class Use>
void for_each_candidate(std::span<const Trial> trials, std::size_t candidates, Use&& use) {
  std::size_t from = 0;
  for (std::size_t i = 0; i < candidates; ++i) {
    std::size_t to = from;
    while (to < trials.size() && trials[to].candidate == i) ++to;
    use(i, trials.subspan(from, to - from));
    from = to;
  }
}

}  // namespace

std::vector<Trial> Expander::scatter(std::span<const Candidate> parents, std::size_t k,
                                     const ExpandOptions& options, std::span<RandomStream> random) {
  const double excess = options.tolerance.excess, reach = kEdge * std::sqrt(excess);
  std::vector<Trial> trials;
  const auto add = [&](std::vector<Trial>& to, std::size_t i, const Vec6& y) {
    if (const auto trial = trials_.propose(parents, i, y, excess)) to.push_back(*trial);
  };
  for (std::size_t i = 0; i < parents.size(); ++i) {
    const int axes = options.first_round ? 2 : 0;
    for (int j = 0; j < axes; ++j) {  // a livelier and a duller bounce
      Vec6 y = Vec6::Zero();
      y[0] = j == 0 ? reach : -reach;
      add(trials, i, y);
    }
    for (int j = axes; j < kScattered; ++j) add(trials, i, random_change(excess, random[i]));
  }
  trials_.run(parents, k, trials);

  std::vector<Trial> steps;
  for_each_candidate(trials, parents.size(), [&](std::size_t i, std::span<const Trial> own) {
    std::vector<Sample6> samples{{Vec6(Vec6::Zero()), trials_.unchanged(parents, i, k).lateness_s}};
    for (const Trial& t : own) samples.push_back({t.y, t.lateness_s});
    if (const auto model = steepest(samples))
      add(steps, i, std::clamp(kOvershoot * model->root(), -reach, reach) * model->along);
  });
  trials_.run(parents, k, steps);
  trials.insert(trials.end(), steps.begin(), steps.end());
  return trials;
}

void Expander::expand(std::span<const Candidate> parents, std::size_t first, std::size_t k,
                      const ExpandOptions& options, std::span<RandomStream> random,
                      std::vector<Candidate>& children) {
  const std::size_t begin = children.size();
  std::vector<Trial> trials = scatter(parents, k, options, random);
  const std::size_t scattered = trials.size();
  for (std::size_t i = 0; i < parents.size(); ++i) trials.push_back(trials_.unchanged(parents, i, k));
  std::vector<char> used(trials.size(), 0);
  if (!options.first_round)  // it has been a child before
    std::fill(used.begin() + static_cast<std::ptrdiff_t>(scattered), used.end(), char{1});

  auto closings =
      enclose(trials_.problem(), trials, parents, k, static_cast<std::size_t>(options.proposals), used);
  close_in(trials_, parents, k, options.tolerance.excess, closings);

  const auto add = [&](const Trial& t) {
    add_child(parents[t.candidate], first + t.candidate, k, options.tolerance, t, children);
  };
  for (std::size_t t = 0; t < trials.size(); ++t)
    if (!used[t]) add(trials[t]);
  for (const Closing& c : closings) add(c.best);
  auto anchors = anchors_of(closings, trials_.problem().target_s(k), options.tolerance);
  const auto varied = vary(trials_, parents, k, options.tolerance, anchors, options.variants, random);
  for (const Anchor& a : varied) add(a.trial);
  anchors.insert(anchors.end(), varied.begin(), varied.end());
  if (trials_.problem().fits_length(k))
    for (const Anchor& a : fit_length(trials_, parents, k, options.tolerance, anchors, random)) add(a.trial);
  if (trials_.problem().plan.constrains())
    for (const Anchor& a : steer(trials_, parents, k, options.tolerance, anchors, trials)) add(a.trial);
  look_ahead(std::span(children).subspan(begin), k + 1);
}

void Expander::follow(std::span<const Candidate> parents, std::size_t first, std::size_t k,
                      std::vector<Candidate>& children) {
  const std::size_t begin = children.size();
  for (std::size_t i = 0; i < parents.size(); ++i)
    add_child(parents[i], first + i, k, kPlausible, trials_.unchanged(parents, i, k), children);
  look_ahead(std::span(children).subspan(begin), k + 1);
}

void Expander::track(std::span<const Candidate> parents, std::size_t first, std::size_t k, const Link& link,
                     const Onset& wanted, std::span<RandomStream> random, std::vector<Candidate>& children) {
  const std::size_t begin = children.size();
  const Vec6 y = trials_.change(link.onset, link.leave.after);
  for (const Trial& t : ifa::track(trials_, parents, k, wanted, y, random))
    add_child(parents[t.candidate], first + t.candidate, k, kPlausible, t, children);
  look_ahead(std::span(children).subspan(begin), k + 1);
}

void Expander::add_child(const Candidate& parent, std::size_t index, std::size_t k,
                         const Tolerance& tolerance, const Trial& trial,
                         std::vector<Candidate>& children) const {
  const Problem& problem = trials_.problem();
  const Marks& marks = problem.marks;
  const Passage& passage = trial.passage;
  if (!trial.meets || trial.excess > tolerance.excess) return;
  const double interval = passage.interval_s, target = problem.target_s(k);
  const double ratio = ratio_of(interval, target);
  if (ratio > 1.0 + tolerance.retime) return;
  const bool retimes = problem.plan.on(Effect::retiming);
  const double drift_s = retimes ? 0.0 : parent.drift_s + interval - target;
  if (std::abs(drift_s) > kMostError_s) return;
  // Retiming must not carry a hit out of the span that excuses it, nor part hits that the merge gap holds
  // together.
  const double stretch = retimes ? target / interval : 1.0;
  if (passage.event.loose_s * stretch > marks.durations_s[k]) return;
  if (passage.event.gap_s * stretch >= problem.physics.hearing.merge_gap_s) return;
  Candidate child;
  child.onset = passage.onset;
  child.parent = static_cast<int>(index);
  child.start = k == 0 ? child.parent : parent.start;
  child.body = trials_.body_index();
  child.from = {trial.after, trial.excess, interval};
  child.drift_s = drift_s;
  child.first_amplitude = k == 0 ? passage.event.amplitude : parent.first_amplitude;
  const double log_factors = trial.log_factors(problem, k, parent.first_amplitude);
  child.log_weight = parent.log_weight + log_factors;
  const bool plausible = trial.excess <= kPlausible.excess && ratio <= 1.0 + kPlausible.retime &&
                         log_factors >= kLeastLogFactors;
  child.violations = parent.violations + (plausible ? 0 : 1);
  child.alignment = parent.alignment;
  child.unmet = parent.unmet;
  child.constrain(problem, k + 1);
  child.stretched = parent.stretched;
  if (ratio > 1.0 + kUnnoticed) {
    // Where poses are asked too, what can be seen of a retiming is weighed against them.
    if (marks.constraints.empty())
      ++child.stretched;
    else
      child.log_weight -= kNoticed;
  }
  children.push_back(child);
}

// How far an unchanged passage that leaves event k is from what the marks ask, in units of what a change can
// mend.
double Expander::miss(const Passage& passage, std::size_t k) const {
  const Problem& problem = trials_.problem();
  const Marks& marks = problem.marks;
  if (k + 1 < marks.size()) {
    constexpr double kReach = 0.25;  // a change moves the next hit by some such share
    constexpr double kRest = 0.8, kLate = 0.5;
    return (passage.hits()               ? std::log(passage.interval_s / problem.target_s(k))
            : passage.next == Next::late ? kLate
                                         : kRest) /
           kReach;
  }
  // How much too loud the hit is that should not come; a change makes it softer by some such share.
  constexpr double kReach = 0.7, kDubious = 1.0;
  if (ends_as_asked(passage, marks.ending)) return 0.0;
  if (passage.next != Next::hit) return kDubious / kReach;
  return (kDubious +
          std::log(passage.onset.hit.approach_speed_m_s / problem.physics.hearing.audible_speed_m_s)) /
         kReach;
}

double Expander::toll(const Candidate& candidate, const Passage& passage, std::size_t k) const {
  const Problem& problem = trials_.problem();
  const double at_rest = toll_at_rest(problem, candidate, passage);
  if (k + 1 == problem.marks.size() || !passage.hits()) return at_rest;
  const Aim aim(problem.marks, trials_.body(), k + 1);
  if (!aim.any()) return at_rest;
  const Onset& onset = candidate.onset;
  State pose = passage.onset.before;  // in time: as much farther or less far
  pose.position = onset.before.position +
                  problem.target_s(k) / passage.interval_s * (pose.position - onset.before.position);
  const Arrival arrival(pose, onset.after.angular_velocity, problem.target_s(k), trials_.region(onset));
  return at_rest + aim.step(candidate.alignment, arrival, Vec6::Zero(), 1.0, {}).cost;
}

void Expander::look_ahead(std::span<Candidate> candidates, std::size_t k) {
  const Marks& marks = trials_.problem().marks;
  std::vector<Onset> onsets;
  for (const Candidate& c : candidates) onsets.push_back(c.onset);
  std::vector<Passage> passages = trials_.follow(onsets, k);
  std::vector<std::size_t> of;
  onsets.clear();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Candidate& c = candidates[i];
    const double miss1 = miss(passages[i], k);
    c.outlook = -0.5 * miss1 * miss1;
    if (k > 0) {
      const double log_sound = trials_.problem().log_sound(passages[i].event, k, c.first_amplitude);
      const double amiss = std::max(0.0, kLeastLogFactors - log_sound);  // a change may yet mend it
      c.outlook += log_sound + amiss - std::log1p(amiss);
    }
    if (k + 1 < marks.size()) {
      if (passages[i].next == Next::hit && std::abs(miss1) < 2.0) {
        of.push_back(i);
        onsets.push_back(passages[i].onset);
      } else {
        c.outlook -= kSecondWeight * 2.0;
      }
    }
    constexpr double kTooFast = 0.3;
    const double travel = c.onset.after.velocity.head<2>().norm();
    const double too_fast =
        std::max(0.0, travel / trials_.problem().travel_budget_m_s(trials_.body_index(), k) - 1.0) / kTooFast;
    c.outlook -= 0.5 * too_fast * too_fast;
    if (trials_.problem().plan.constrains()) {
      c.toll = toll(c, passages[i], k);
      c.outlook -= c.toll;
    }
    c.unchanged = std::make_shared<const Passage>(std::move(passages[i]));
  }
  if (k + 1 >= marks.size()) return;
  passages = trials_.follow(onsets, k + 1);
  for (std::size_t j = 0; j < of.size(); ++j) {
    const double miss2 = std::clamp(miss(passages[j], k + 1), -3.0, 3.0);
    Candidate& c = candidates[of[j]];
    c.outlook -= kSecondWeight * 0.5 * miss2 * miss2;
    if (!trials_.problem().plan.constrains()) continue;
    constexpr double kMostToll = 12.0;  // changes will come between
    Candidate next = c;
    next.onset = onsets[j];
    next.constrain(trials_.problem(), k + 1);
    c.outlook -= kSecondWeight * std::min(kMostToll, toll(next, passages[j], k + 1));
  }
}

std::vector<Trial> Expander::finish(std::span<const Candidate> candidates, int rounds, double largest_excess,
                                    std::span<RandomStream> random) {
  const Problem& problem = trials_.problem();
  const std::size_t k = problem.marks.size() - 1;
  const Ending ending = problem.marks.ending;
  const double edge = kEdge * std::sqrt(largest_excess);
  const auto log_factors = [&](const Trial& t) {
    return t.log_factors(problem, k, candidates[t.candidate].first_amplitude) +
           candidates[t.candidate].log_rest(problem, t.passage);
  };
  // How far a trial is from the ending: 0 as asked; less than 0.5 if only its sound or how it lies is amiss,
  // else by the loudness of the hit that is too much.
  const auto flaw = [&](const Trial& t) {
    if (ends_as_asked(t.passage, ending)) {
      const double amiss = std::max(0.0, kLeastLogFactors - log_factors(t));
      return 0.5 * std::min(1.0, 0.1 * std::log1p(amiss));
    }
    if (!t.passage.hits()) return 1.0;
    return 0.5 +
           std::log1p(t.passage.onset.hit.approach_speed_m_s / problem.physics.hearing.audible_speed_m_s);
  };
  std::vector<Trial> done(candidates.size()), best(candidates.size());
  std::vector<char> hopeless(candidates.size(), 0);  // ends as asked but lies wrong, whatever is changed
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    done[i].candidate = i;
    done[i].excess = kNever;
    best[i] = trials_.unchanged(candidates, i, k);
    hopeless[i] = best[i].meets && lies_for_good(problem, candidates[i]);
  }
  const auto keep = [&](const Trial& t) {
    if (flaw(t) < flaw(best[t.candidate])) best[t.candidate] = t;
    Trial& d = done[t.candidate];
    if (t.meets && (!std::isfinite(d.excess) || log_factors(t) > log_factors(d))) d = t;
  };
  std::vector<Trial> ended;  // for root searches of the length
  for (const Trial& t : best)
    if (t.meets) ended.push_back(t);
  for (int round = 0; round < rounds; ++round) {
    std::vector<Trial> trials;
    const auto add = [&](std::vector<Trial>& to, std::size_t i, Vec6 y) {
      if (y.norm() > edge) y *= edge / y.norm();
      if (const auto trial = trials_.propose(candidates, i, y, largest_excess)) to.push_back(*trial);
    };
    const double spread = std::pow(0.6, round);  // about the best so far
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (flaw(best[i]) == 0.0 || hopeless[i]) continue;
      for (int j = 0; j < kScattered; ++j)
        add(trials, i, best[i].y + spread * random_change(largest_excess, random[i]));
    }
    trials_.run(candidates, k, trials);
    std::vector<Trial> steps;
    for_each_candidate(trials, candidates.size(), [&](std::size_t i, std::span<const Trial> own) {
      std::vector<Sample6> samples{{best[i].y, flaw(best[i])}};
      for (const Trial& t : own) samples.push_back({t.y, flaw(t)});
      const auto model = own.empty() ? std::nullopt : steepest(samples);
      if (model) add(steps, i, best[i].y - spread * edge * model->along);
    });
    trials_.run(candidates, k, steps);
    trials.insert(trials.end(), steps.begin(), steps.end());
    for (const Trial& t : trials) {
      keep(t);
      if (t.meets) ended.push_back(t);
    }
  }
  if (problem.fits_length(k)) {
    std::vector<char> used(ended.size(), 0);
    auto closings = enclose(problem, ended, candidates, k, kLengthClosings, used);
    close_in(trials_, candidates, k, largest_excess, closings);
    for (const Closing& c : closings)
      if (c.best.meets) keep(c.best);
  }
  return done;
}

}  // namespace ifa
