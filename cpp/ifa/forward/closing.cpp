#include "ifa/forward/closing.hpp"

#include <algorithm>
#include <cmath>

namespace ifa {
namespace {

constexpr int kRefinements = 8, kCorrections = 2;
constexpr double kEdge = 0.98;  // of the region's radius: as far as variants go
// What is left is retimed away: nobody could see it.
constexpr double kOnTime_s = 1e-5, kOnTimeShare = 1e-4;

double on_time_s(double target_s) { return std::max(kOnTime_s, kOnTimeShare * target_s); }

void keep_better(Closing& closing, const Trial& trial, double worth) {
  if (!trial.hits() || worth <= closing.worth) return;
  closing.best = trial;
  closing.worth = worth;
}

}  // namespace

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
      for (const Trial* t : {&a, &b})
        keep_better(closing, *t, t->log_factors(problem, k, candidates[i].first_amplitude));
      closings.push_back(std::move(closing));
    }
  }
  return closings;
}

void close_in(Trials& trials, std::span<const Candidate> candidates, std::size_t k, double largest_excess,
              std::vector<Closing>& closings) {
  const double target = trials.problem().target_s(k);
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
      if (std::abs(now.value) <= on_time_s(target)) closing.open = false;
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

std::vector<Trial> vary(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                        const Tolerance& tolerance, std::span<const Anchor> anchors, int count, double spread,
                        std::span<RandomStream> random) {
  const double target = trials.problem().target_s(k), reach = std::sqrt(tolerance.excess);
  const auto within = [&](Vec6 y) {
    const double size = y.norm();
    return size > kEdge * reach ? Vec6(y * (kEdge * reach / size)) : y;
  };
  std::vector<Trial> found;
  std::vector<const Anchor*> of;
  for (const Anchor& anchor : anchors) {
    const std::size_t i = anchor.trial.candidate;
    const Vec6 line = anchor.along.normalized();
    for (int v = 0; v < count; ++v) {
      Vec6 aside = random_change(1.0, random[i]);
      aside -= aside.dot(line) * line;
      const auto trial =
          trials.propose(candidates, i, within(anchor.trial.y + spread * reach * aside), tolerance.excess);
      if (!trial) continue;
      found.push_back(*trial);
      of.push_back(&anchor);
    }
  }
  trials.run(candidates, k, found);
  for (int correction = 0; correction < kCorrections; ++correction) {
    std::vector<Trial> corrected;
    std::vector<std::size_t> index;
    for (std::size_t v = 0; v < found.size(); ++v) {
      const Trial& t = found[v];
      if (!std::isfinite(t.lateness_s) || std::abs(t.lateness_s) <= on_time_s(target)) continue;
      const Vec6 y = within(t.y - t.lateness_s / of[v]->slope_s * of[v]->along);
      const auto trial = trials.propose(candidates, t.candidate, y, tolerance.excess);
      if (!trial) continue;
      corrected.push_back(*trial);
      index.push_back(v);
    }
    trials.run(candidates, k, corrected);
    for (std::size_t c = 0; c < corrected.size(); ++c) {
      Trial& t = found[index[c]];
      if (corrected[c].hits() && std::abs(corrected[c].lateness_s) < std::abs(t.lateness_s)) t = corrected[c];
    }
  }
  return found;
}

}  // namespace ifa
