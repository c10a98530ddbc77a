#include "ifa/forward/beam.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "ifa/base/parallel.hpp"
#include "ifa/forward/root.hpp"
#include "ifa/forward/start.hpp"

namespace ifa {
namespace {

constexpr double kOnTime = 1e-5;  // s: what is left is retimed away, by less than 0.1 %
constexpr int kRefinements = 8;
constexpr int kStartsPerState = 6;
constexpr int kPool = 8;    // changes tried for a state in one round
constexpr int kRounds = 6;  // of proposals for a state, at most
constexpr int kFinalBatch = 64;
constexpr double kLateShare = 1.35;  // a passage is followed this far beyond its target
constexpr double kEnergyBand = 0.4;  // width of a band of energy, in its logarithm
constexpr std::size_t kMostChildren = 4;
constexpr std::size_t kFewestStarts = 10;  // that a full beam descends from

// A state of the beam: it has reached event k.
struct Candidate {
  Onset onset;
  int parent = -1, start = -1;  // indices at the level before, and at the first
  Link from;                    // the parent's link
  double log_weight = 0.0;      // all factors of the events before, and of the transitions
  double first_amplitude = 0.0;
  double rank = 0.0, energy = 0.0;
  bool hopeless = false;
};

struct Search {
  const Body& body;
  const SearchPhysics& physics;
  const Marks& marks;
  const BeamOptions& options;

  double target(std::size_t k) const { return marks.times_s[k + 1] - marks.times_s[k]; }

  RandomStream stream(std::size_t level, std::size_t index) const {
    return RandomStream(options.seed, (static_cast<std::uint64_t>(level + 1) << 32) | index);
  }

  // Whether energy allows leaving event with `after`: f_E (paper eq. 10).
  bool allowed(const Onset& onset, const State& after) const {
    return kinetic_energy(body, after) <= kinetic_energy(body, onset.before) + physics.energy_gain_j;
  }

  void add_child(std::vector<Candidate>& children, Runner& runner, const Candidate& parent, int parent_index,
                 std::size_t k, const State& after, double excess, const Passage& passage) const {
    const double interval = passage.interval_s;
    const double ratio = std::max(interval, target(k)) / std::min(interval, target(k));
    if (ratio > 1.0 + options.largest_retime) return;
    // Retiming must not carry a hit out of the span that excuses it, nor part hits that the merge gap holds
    // together.
    const double stretch = target(k) / interval;
    if (passage.event.loose_s * stretch > marks.durations_s[k]) return;
    if (passage.event.gap_s * stretch >= physics.hearing.merge_gap_s) return;
    Candidate child;
    child.parent = parent_index;
    child.start = k == 0 ? parent_index : parent.start;
    child.from = {parent.onset, after, excess, interval};
    child.first_amplitude = k == 0 ? passage.event.amplitude : parent.first_amplitude;
    Factors f = sound_factors(passage.event, marks, k, child.first_amplitude);
    f.velocity = velocity_factor(excess);
    f.time = time_factor(interval, target(k));
    child.log_weight = parent.log_weight + log_product(f);
    child.onset = runner.strike(passage.before);
    child.energy = kinetic_energy(body, child.onset.after);
    child.rank = child.log_weight;
    if (!marks.amplitudes.empty()) {  // a first guess from the first hit alone
      const double relative = child.onset.hit.impulse_n_s.norm() / child.first_amplitude;
      child.rank += std::log(
          std::max(1e-300, amplitude_factor(relative, marks.amplitudes[k + 1] / marks.amplitudes[0])));
    }
    children.push_back(child);
  }

  // One way to leave an event: a point of the plausible ball, and what became of it.
  struct Trial {
    Vec6 y;
    State after;
    double excess;
    Passage passage;
    double lateness;  // s; infinite where no hit came in time
  };

  std::optional<Trial> attempt(const Onset& onset, const PlausibleRegion& region, std::size_t k,
                               const Vec6& y, double limit_s, Runner& runner) const {
    Trial trial{y, onset.after, y.squaredNorm(), {}, kNever};
    trial.after.velocity += region.velocity_offset(y);
    trial.after.angular_velocity += region.spin_offset(y);
    if (runner.settle(trial.after)) {
      trial.excess = region.excess(trial.after.velocity - onset.after.velocity,
                                   trial.after.angular_velocity - onset.after.angular_velocity);
      if (trial.excess > options.largest_excess) return std::nullopt;
    }
    if (!allowed(onset, trial.after)) return std::nullopt;
    trial.passage = runner.pass(onset, trial.after, marks.durations_s[k], limit_s);
    if (k + 1 < marks.size() && (trial.passage.next == Next::hit || trial.passage.next == Next::dubious))
      trial.lateness = trial.passage.interval_s - target(k);
    return trial;
  }

  PlausibleRegion region_of(const Onset& onset) const {
    return PlausibleRegion(onset.after.velocity - onset.before.velocity,
                           onset.after.angular_velocity - onset.before.angular_velocity,
                           body.bounding_radius_m());
  }

  Vec6 random_change(RandomStream& random) const {
    Vec6 y;
    for (int i = 0; i < 6; ++i) y[i] = random.normal();
    return y * (std::sqrt(options.largest_excess) * std::sqrt(random.uniform()) / y.norm());
  }

  // The children of one state. A handful of changes is tried; between one that comes early and one that comes
  // late lies one that comes in time (the ball is convex), found along the line between them unless the
  // interval jumps there.
  void expand(const Candidate& parent, int parent_index, std::size_t k, int round, Runner& runner,
              RandomStream random, std::vector<Candidate>& children) const {
    const PlausibleRegion region = region_of(parent.onset);
    const double limit = kLateShare * target(k);
    std::vector<Trial> pool;
    for (int j = 0; j < kPool; ++j) {
      Vec6 y = Vec6::Zero();
      if (round > 0 || j > 2)
        y = random_change(random);
      else if (j > 0)  // a livelier and a duller bounce
        y[0] = (j == 1 ? 0.95 : -0.95) * std::sqrt(options.largest_excess);
      if (auto trial = attempt(parent.onset, region, k, y, limit, runner)) pool.push_back(*trial);
    }
    const auto usable = [&](const Trial& t) { return t.passage.next == Next::hit; };
    const auto worth = [&](const Trial& t) {
      const double time =
          std::max(t.passage.interval_s, target(k)) / std::min(t.passage.interval_s, target(k)) - 1.0;
      return -t.excess - 100.0 * time * time;
    };
    // Pairs that enclose the target, the mildest changes first, each trial used once.
    std::vector<std::size_t> early, late;
    for (std::size_t i = 0; i < pool.size(); ++i) (pool[i].lateness < 0.0 ? early : late).push_back(i);
    const auto milder = [&](std::size_t p, std::size_t q) { return pool[p].excess < pool[q].excess; };
    std::stable_sort(early.begin(), early.end(), milder);
    std::stable_sort(late.begin(), late.end(), milder);
    const std::size_t pairs =
        std::min({early.size(), late.size(), static_cast<std::size_t>(options.proposals)});
    std::vector<char> used(pool.size(), 0);
    for (std::size_t pair = 0; pair < pairs; ++pair) {
      const Trial &a = pool[early[pair]], &b = pool[late[pair]];
      used[early[pair]] = used[late[pair]] = 1;
      std::vector<Trial> seen{a, b};
      const auto lateness = [&](double x) -> std::optional<double> {
        auto trial = attempt(parent.onset, region, k, a.y + x * (b.y - a.y), limit, runner);
        if (!trial) return std::nullopt;
        seen.push_back(*trial);
        return trial->lateness;
      };
      close_in({0.0, a.lateness}, {1.0, b.lateness}, lateness, kOnTime, kRefinements);
      const Trial* best = nullptr;
      for (const Trial& t : seen)
        if (usable(t) && (!best || worth(t) > worth(*best))) best = &t;
      if (best)
        add_child(children, runner, parent, parent_index, k, best->after, best->excess, best->passage);
    }
    for (std::size_t i = 0; i < pool.size(); ++i)
      if (!used[i] && usable(pool[i]))
        add_child(children, runner, parent, parent_index, k, pool[i].after, pool[i].excess, pool[i].passage);
  }

  // How a motion goes on after its last event, if it ends as the marks ask: the mildest of `changes`.
  struct Final {
    double log_weight = -kNever;
    State after;
    double excess = 0.0;
  };

  Final finish(const Candidate& candidate, int changes, Runner& runner, RandomStream random) const {
    const std::size_t k = marks.size() - 1;
    const bool rest = marks.ending == Ending::rest;
    const PlausibleRegion region = region_of(candidate.onset);
    Final best;
    for (int j = 0; j < changes; ++j) {
      Vec6 y = j == 0 ? Vec6(Vec6::Zero()) : random_change(random);
      if (rest && j % 2 == 1) y[0] = -std::abs(y[0]);  // a duller bounce rests sooner
      const auto trial = attempt(candidate.onset, region, k, y, rest ? kLongestRest_s : kOpenTail_s, runner);
      if (!trial || trial->passage.next == Next::dubious || (rest && trial->passage.next != Next::rest))
        continue;
      const double first = k == 0 ? trial->passage.event.amplitude : candidate.first_amplitude;
      Factors f = sound_factors(trial->passage.event, marks, k, first);
      f.velocity = velocity_factor(trial->excess);
      const double weight = candidate.log_weight + log_product(f);
      if (weight > best.log_weight) best = {weight, trial->after, trial->excess};
    }
    return best;
  }

  // A first contact whose speed is chosen so that the second mark is met without any change.
  std::optional<Candidate> begin(const StartOptions& start, std::size_t index, Runner& runner) const {
    RandomStream random = stream(0, index);
    const bool single = marks.size() == 1 && marks.ending == Ending::rest;
    auto sampled =
        single ? sample_touchdown(body, physics, start, random) : sample_start(body, physics, start, random);
    if (!sampled) return std::nullopt;
    Candidate candidate;
    candidate.onset = runner.strike(*sampled);
    if (marks.size() == 1) return candidate;
    const double speed = sampled->velocity.norm();
    const Vec3 heading = sampled->velocity / speed;
    const auto lateness = [&](double x) -> std::optional<double> {
      State s = *sampled;
      s.velocity = x * heading;
      const Onset onset = runner.strike(s);
      if (onset.hit.approach_speed_m_s < physics.hearing.audible_speed_m_s * (1.0 + physics.margin))
        return std::nullopt;
      const Passage passage = runner.pass(onset, onset.after, marks.durations_s[0], kLateShare * target(0));
      if (passage.next == Next::rest || passage.next == Next::late) return kNever;
      return passage.interval_s - target(0);
    };
    const double least = start.least_speed_m_s, most = start.most_speed_m_s;
    const auto seen = find_root(lateness, {speed, 0.5 * (speed + most), 0.5 * (speed + least), most, least},
                                kOnTime, kRefinements);
    if (seen.empty()) {  // no speed leads to a second hit: of use only where that holds for every start
      candidate.hopeless = true;
      return candidate;
    }
    State s = *sampled;
    s.velocity = seen.back().x * heading;
    if (clear_before(body, s, physics.simulation.gravity_m_s2, start.clear_s) < start.clear_s)
      return std::nullopt;
    candidate.onset = runner.strike(s);
    return candidate;
  }

  // Half of the beam by weight; half shared evenly among bands of energy, the best by weight in each, since
  // the marks to come may need a lively body or a tired one. Few children of one parent, few descendants of
  // one start.
  std::vector<Candidate> select(std::vector<Candidate>&& all) const {
    const std::size_t room = static_cast<std::size_t>(options.beam);
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return all[a].rank > all[b].rank; });

    std::vector<Candidate> kept;
    std::vector<char> taken(all.size(), 0);
    std::map<int, std::size_t> of_parent, of_start;
    bool strict = true;
    const auto take = [&](std::size_t i) {
      if (taken[i]) return false;
      if (strict &&
          (of_parent[all[i].parent] >= kMostChildren || of_start[all[i].start] >= room / kFewestStarts + 1))
        return false;
      taken[i] = 1;
      ++of_parent[all[i].parent];
      ++of_start[all[i].start];
      kept.push_back(all[i]);
      return true;
    };
    for (const std::size_t i : order) {
      if (kept.size() >= (room + 1) / 2) break;
      take(i);
    }
    std::map<int, std::vector<std::size_t>> bands;  // best first
    for (const std::size_t i : order)
      if (!taken[i])
        bands[static_cast<int>(std::floor(std::log(std::max(all[i].energy, 1e-300)) / kEnergyBand))]
            .push_back(i);
    std::map<int, std::size_t> next;
    for (bool more = true; more && kept.size() < room;) {
      more = false;
      for (const auto& [band, members] : bands) {
        std::size_t& at = next[band];
        while (at < members.size() && !take(members[at++])) {
        }
        more |= at < members.size();
        if (kept.size() >= room) break;
      }
    }
    strict = false;  // where too few families are left, what there is
    for (const std::size_t i : order) {
      if (kept.size() >= room) break;
      take(i);
    }
    return kept;
  }
};

}  // namespace

Found search_beam(const Body& body, const SearchPhysics& physics, const Marks& marks,
                  const BeamOptions& options, Progress* progress, double progress_from, double progress_to,
                  double& simulated_s) {
  const Search search{body, physics, marks, options};
  const std::size_t n = marks.size();
  const StartOptions start = start_options(body, marks, physics.simulation.gravity_m_s2.norm());
  const auto report = [&](std::size_t done) {
    if (progress)
      progress->raise_to(progress_from + (progress_to - progress_from) * static_cast<double>(done) /
                                             static_cast<double>(n + 1));
  };

  std::vector<std::vector<Candidate>> levels(1);
  {
    const std::size_t tries = static_cast<std::size_t>(options.beam) * kStartsPerState;
    std::vector<std::optional<Candidate>> starts(tries);
    std::vector<double> time(tries, 0.0);
    parallel_for(
        tries, options.threads,
        [&](std::size_t i) {
          Runner runner(body, physics);
          starts[i] = search.begin(start, i, runner);
          time[i] = runner.simulated_s();
        },
        progress);
    for (auto& s : starts)
      if (s) levels[0].push_back(*s);
    const bool hope =
        std::any_of(levels[0].begin(), levels[0].end(), [](const Candidate& c) { return !c.hopeless; });
    if (hope) std::erase_if(levels[0], [](const Candidate& c) { return c.hopeless; });
    simulated_s += std::accumulate(time.begin(), time.end(), 0.0);
  }
  report(1);

  Found found;
  for (std::size_t k = 0; k + 1 < n && !levels[k].empty(); ++k) {
    found.reached = k + 1;
    const auto& parents = levels[k];
    // Rounds of proposals until the beam can be filled.
    std::vector<Candidate> all;
    std::vector<std::size_t> born(parents.size(), 0);
    std::size_t fit = 0;
    for (int round = 0; round < kRounds && fit < static_cast<std::size_t>(options.beam); ++round) {
      if (round >= kRounds / 2 && fit == 0) break;  // out of reach: more of the same would not help
      std::vector<std::vector<Candidate>> children(parents.size());
      std::vector<double> time(parents.size(), 0.0);
      parallel_for(
          parents.size(), options.threads,
          [&](std::size_t i) {
            Runner runner(body, physics);
            search.expand(parents[i], static_cast<int>(i), k, round, runner,
                          search.stream((k + 1) * kRounds + round, i), children[i]);
            time[i] = runner.simulated_s();
          },
          progress);
      simulated_s += std::accumulate(time.begin(), time.end(), 0.0);
      for (std::size_t i = 0; i < parents.size(); ++i) {
        fit -= std::min(born[i], kMostChildren);
        born[i] += children[i].size();
        fit += std::min(born[i], kMostChildren);
        all.insert(all.end(), children[i].begin(), children[i].end());
      }
    }
    levels.push_back(search.select(std::move(all)));
    report(k + 2);
  }
  while (!levels.empty() && levels.back().empty()) levels.pop_back();
  if (levels.empty()) return found;
  // The links of a candidate, which leaves its event as `final` says.
  const auto links_of = [&](const Candidate* c, const Search::Final& final) {
    std::vector<Link> links{{c->onset, final.after, final.excess, 0.0}};
    for (std::size_t k = levels.size() - 1; k > 0; --k) {
      links.push_back(c->from);
      c = &levels[k - 1][c->parent];
    }
    std::reverse(links.begin(), links.end());
    return links;
  };
  const auto by_rank = [](const Candidate& a, const Candidate& b) { return a.rank > b.rank; };
  std::stable_sort(levels.back().begin(), levels.back().end(), by_rank);
  found.reached = levels.size();
  if (found.reached < n) {
    const Candidate& c = levels.back().front();
    found.links = links_of(&c, {c.log_weight, c.onset.after, 0.0});
    return found;
  }

  // The ending, best candidates first. At first nothing is changed any more; if no candidate then comes to
  // rest without a further hit, the last impact may be changed too, and its excess counts.
  const auto& last = levels.back();
  int chosen = -1;
  Search::Final final;
  for (const int changes : {1, 12, 80}) {
    if (chosen >= 0) break;
    for (std::size_t from = 0; from < last.size() && chosen < 0; from += kFinalBatch) {
      const std::size_t count = std::min<std::size_t>(kFinalBatch, last.size() - from);
      std::vector<Search::Final> finals(count);
      std::vector<double> time(count, 0.0);
      parallel_for(
          count, options.threads,
          [&](std::size_t i) {
            Runner runner(body, physics);
            finals[i] = search.finish(last[from + i], changes, runner, search.stream(n * kRounds, from + i));
            time[i] = runner.simulated_s();
          },
          progress);
      simulated_s += std::accumulate(time.begin(), time.end(), 0.0);
      for (std::size_t i = 0; i < count; ++i)
        if (finals[i].log_weight > final.log_weight) {
          chosen = static_cast<int>(from + i);
          final = finals[i];
        }
    }
  }
  found.complete = chosen >= 0;
  const Candidate& c = last[found.complete ? chosen : 0];
  if (!found.complete) final = {c.log_weight, c.onset.after, 0.0};
  found.log_weight = final.log_weight;
  found.links = links_of(&c, final);
  return found;
}

}  // namespace ifa
