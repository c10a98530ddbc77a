#include "ifa/forward/closing.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/forward/steepest.hpp"

namespace ifa {
namespace {

constexpr int kRefinements = 8, kCorrections = 2;
constexpr int kLengthRounds = 4, kAround = 3;
constexpr double kAside = 0.5;  // of the region's radius: how far variants lie apart
constexpr double kEdge = 0.98;  // of the region's radius: as far as variants go
// What is left is retimed away: nobody could see it.
constexpr double kOnTime_s = 1e-5, kOnTimeShare = 1e-4;

constexpr double kLengthOff_s = 1e-3;  // a tenth of what halves f_l (paper eq. 7)

double on_time_s(double target_s) { return std::max(kOnTime_s, kOnTimeShare * target_s); }

void keep_better(Closing& closing, const Trial& trial, double worth) {
  if (!trial.meets || worth <= closing.worth) return;
  closing.best = trial;
  closing.worth = worth;
}

}  // namespace

Vec6 within(const Vec6& y, const Tolerance& tolerance) {
  const double most = kEdge * std::sqrt(tolerance.excess), size = y.norm();
  return size > most ? Vec6(y * (most / size)) : y;
}

double ratio_of(double a, double b) { return std::max(a, b) / std::min(a, b); }

std::vector<Closing> enclose(const Problem& problem, std::span<const Trial> trials,
                             std::span<const Candidate> candidates, std::size_t k, std::size_t most,
                             std::vector<char>& used) {
  std::vector<std::vector<std::size_t>> early(candidates.size()), late(candidates.size());
  for (std::size_t t = 0; t < trials.size(); ++t)
    (trials[t].lateness_s < 0.0 ? early : late)[trials[t].candidate].push_back(t);
  const auto milder = [&](std::size_t a, std::size_t b) { return trials[a].excess < trials[b].excess; };
  std::vector<Closing> closings;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    std::stable_sort(early[i].begin(), early[i].end(), milder);
    std::stable_sort(late[i].begin(), late[i].end(), milder);
    const std::size_t pairs = std::min({early[i].size(), late[i].size(), most});
    for (std::size_t pair = 0; pair < pairs; ++pair) {
      const Trial &a = trials[early[i][pair]], &b = trials[late[i][pair]];
      used[early[i][pair]] = used[late[i][pair]] = 1;
      Closing closing{a.y, b.y - a.y, Bracket({0.0, a.lateness_s}, {1.0, b.lateness_s}), {}};
      closing.best.candidate = i;
      closing.best.excess = kNever;
      if (std::isfinite(b.lateness_s))
        closing.slope_s = b.lateness_s - a.lateness_s;  // early ones are finite
      for (const Trial* t : {&a, &b})
        keep_better(closing, *t, t->log_factors(problem, k, candidates[i].first_amplitude));
      closings.push_back(std::move(closing));
    }
  }
  return closings;
}

void close_in(Trials& trials, std::span<const Candidate> candidates, std::size_t k, double largest_excess,
              std::vector<Closing>& closings) {
  const bool at_end = k + 1 == trials.problem().marks.size();
  const double on_time = at_end ? kLengthOff_s : on_time_s(trials.problem().target_s(k));
  std::vector<Trial> tried;
  std::vector<std::size_t> owner;
  std::vector<double> where;
  std::vector<RootPoint> last(closings.size(), {0.0, kNever});
  for (int refinement = 0; refinement < kRefinements; ++refinement) {
    tried.clear();
    owner.clear();
    where.clear();
    for (std::size_t c = 0; c < closings.size(); ++c) {
      Closing& closing = closings[c];
      if (!closing.open) continue;
      const double x = closing.bracket.next();
      const auto trial = trials.propose(candidates, closing.best.candidate, closing.from + x * closing.along,
                                        largest_excess);
      closing.open = trial.has_value();
      if (!trial) continue;
      tried.push_back(*trial);
      owner.push_back(c);
      where.push_back(x);
    }
    if (tried.empty()) return;
    trials.run(candidates, k, tried);
    for (std::size_t t = 0; t < tried.size(); ++t) {
      Closing& closing = closings[owner[t]];
      const RootPoint now{where[t], tried[t].lateness_s};
      RootPoint& before = last[owner[t]];
      if (std::isfinite(now.value) && std::isfinite(before.value) && now.x != before.x)
        closing.slope_s = (now.value - before.value) / (now.x - before.x);
      before = now;
      closing.bracket.add(now);
      keep_better(closing, tried[t],
                  tried[t].log_factors(trials.problem(), k, candidates[tried[t].candidate].first_amplitude));
      if (std::abs(now.value) <= on_time) closing.open = false;
    }
  }
}

std::vector<Anchor> anchors_of(const std::vector<Closing>& closings, double target_s,
                               const Tolerance& tolerance) {
  std::vector<Anchor> anchors;
  for (const Closing& c : closings)
    if (std::isfinite(c.best.excess) && c.slope_s != 0.0 &&
        ratio_of(c.best.passage.interval_s, target_s) <= 1.0 + tolerance.retime)
      anchors.push_back({c.best, c.along, c.slope_s});
  return anchors;
}

namespace {

// Brings trials, one for each anchor, back to the mark along the anchor's line, as far as two steps do.
void correct(Trials& trials, std::span<const Candidate> candidates, std::size_t k, const Tolerance& tolerance,
             std::vector<Anchor>& anchors) {
  const double target = trials.problem().target_s(k);
  for (int correction = 0; correction < kCorrections; ++correction) {
    std::vector<Trial> corrected;
    std::vector<std::size_t> index;
    for (std::size_t v = 0; v < anchors.size(); ++v) {
      const Trial& t = anchors[v].trial;
      if (!std::isfinite(t.lateness_s) || std::abs(t.lateness_s) <= on_time_s(target)) continue;
      const Vec6 y = within(t.y - t.lateness_s / anchors[v].slope_s * anchors[v].along, tolerance);
      const auto trial = trials.propose(candidates, t.candidate, y, tolerance.excess);
      if (!trial) continue;
      corrected.push_back(*trial);
      index.push_back(v);
    }
    trials.run(candidates, k, corrected);
    for (std::size_t c = 0; c < corrected.size(); ++c) {
      Trial& t = anchors[index[c]].trial;
      if (corrected[c].meets && std::abs(corrected[c].lateness_s) < std::abs(t.lateness_s)) t = corrected[c];
    }
  }
}

}  // namespace

std::vector<Anchor> run_anchors(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                                const Tolerance& tolerance, std::vector<Anchor> anchors) {
  std::vector<Trial> own;
  for (const Anchor& a : anchors) own.push_back(a.trial);
  trials.run(candidates, k, own);
  for (std::size_t i = 0; i < own.size(); ++i) anchors[i].trial = std::move(own[i]);
  correct(trials, candidates, k, tolerance, anchors);
  return anchors;
}

namespace {

// Trials in place of the anchors' own, run and corrected.
class Neighbours {
 public:
  Neighbours(Trials& trials, std::span<const Candidate> candidates, std::size_t k, const Tolerance& tolerance)
      : trials_(trials), candidates_(candidates), k_(k), tolerance_(tolerance) {}

  void add(const Anchor& anchor, const Vec6& y) {
    const auto trial =
        trials_.propose(candidates_, anchor.trial.candidate, within(y, tolerance_), tolerance_.excess);
    if (trial) anchors_.push_back({*trial, anchor.along, anchor.slope_s});
  }

  // Off to the side of the anchor's line, by up to `spread` of the region's radius.
  void add_aside(const Anchor& anchor, double spread, RandomStream& random) {
    const Vec6 line = anchor.along.normalized();
    Vec6 aside = random_change(tolerance_.excess, random);
    aside -= aside.dot(line) * line;
    add(anchor, anchor.trial.y + spread * aside);
  }

  std::vector<Anchor> run() { return run_anchors(trials_, candidates_, k_, tolerance_, std::move(anchors_)); }

 private:
  Trials& trials_;
  std::span<const Candidate> candidates_;
  std::size_t k_;
  const Tolerance& tolerance_;
  std::vector<Anchor> anchors_;
};

}  // namespace

std::vector<Anchor> vary(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                         const Tolerance& tolerance, std::span<const Anchor> anchors, int count,
                         std::span<RandomStream> random) {
  Neighbours neighbours(trials, candidates, k, tolerance);
  for (const Anchor& anchor : anchors)
    for (int v = 0; v < count; ++v) neighbours.add_aside(anchor, kAside, random[anchor.trial.candidate]);
  return neighbours.run();
}

std::vector<Anchor> fit_length(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                               const Tolerance& tolerance, std::span<const Anchor> anchors,
                               std::span<RandomStream> random) {
  const double duration = trials.problem().marks.durations_s[k], target = trials.problem().target_s(k);
  const double reach = std::sqrt(tolerance.excess);
  std::vector<std::vector<Anchor>> own(candidates.size());
  const auto sort_in = [&](std::span<const Anchor> more) {
    for (const Anchor& a : more)
      if (a.trial.meets && ratio_of(a.trial.passage.interval_s, target) <= 1.0 + tolerance.retime)
        own[a.trial.candidate].push_back(a);
  };
  sort_in(anchors);
  std::vector<Anchor> found;
  double spread = kAside;
  for (int round = 0; round < kLengthRounds; ++round) {
    Neighbours neighbours(trials, candidates, k, tolerance);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (own[i].empty()) continue;
      const auto worth = [&](const Anchor& a) {
        return a.trial.log_factors(trials.problem(), k, candidates[i].first_amplitude);
      };
      const Anchor& best = *std::ranges::max_element(own[i], {}, worth);
      std::vector<Sample6> samples;
      for (const Anchor& a : own[i])
        samples.push_back({a.trial.y - best.trial.y, a.trial.passage.event.length_s - duration});
      if (const auto model = steepest(samples)) {
        const double excess = best.trial.passage.event.length_s - duration;
        const double step = std::clamp(-excess / model->slope, -spread * reach, spread * reach);
        neighbours.add(best, best.trial.y + step * model->along);
      }
      for (int v = 0; v < kAround; ++v) neighbours.add_aside(best, spread, random[i]);
    }
    const auto more = neighbours.run();
    sort_in(more);
    found.insert(found.end(), more.begin(), more.end());
    spread *= 0.6;
  }
  return found;
}

}  // namespace ifa
