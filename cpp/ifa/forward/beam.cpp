#include "ifa/forward/beam.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ifa/base/parallel.hpp"
#include "ifa/forward/expand.hpp"
#include "ifa/forward/select.hpp"
#include "ifa/forward/start.hpp"

namespace ifa {
namespace {

constexpr std::size_t kStartsPerState = 12;
constexpr std::size_t kStartChunk = 32, kChunk = 16;  // what one thread takes at once
constexpr double kPerfect = 1e-9;                     // of a log weight: no other start could do better
constexpr std::size_t kStartGroup = 8;                // first contacts tried at once for a single mark
constexpr std::size_t kBatches = 4;
constexpr std::size_t kFewTracked = 6;  // children that keep to a known motion
constexpr int kFinishRounds = 4;
constexpr double kFinishPerState_s = 20.0;  // simulated in search of an ending, for each state of the beam
constexpr int kRounds = 3;                  // of plausible proposals for a level, at most
constexpr double kDear = 4.0;               // what constraints ahead may cost a candidate that is kept gladly
constexpr int kLooseRounds = 2;             // of those beyond, where too few are plausible

struct Chunk {
  int body;
  std::size_t from, size;
};

// Neighbours of one body.
template <class BodyOf>
std::vector<Chunk> chunks_of(std::size_t from, std::size_t to, std::size_t most, BodyOf&& body_of) {
  std::vector<Chunk> chunks;
  for (std::size_t i = from; i < to; ++i) {
    if (chunks.empty() || chunks.back().body != body_of(i) || chunks.back().size == most)
      chunks.push_back({body_of(i), i, 0});
    ++chunks.back().size;
  }
  return chunks;
}

class Search {
 public:
  Search(const Problem& problem, const BeamOptions& options, Progress* progress, Beam& beam)
      : problem_(problem), options_(options), progress_(progress), beam_(beam) {}

  std::size_t room() const { return static_cast<std::size_t>(options_.beam); }

  // First contacts, the bodies in turn.
  void begin() {
    beam_.levels.emplace_back();
    begin(0, starts(), kStartChunk);
  }

  // Of a single mark: a few after the other, until the motion ends soundly after some just so; whether it
  // does.
  bool begin_with_few() {
    const std::vector<Candidate>& level = beam_.levels.emplace_back().candidates;
    for (std::size_t from = 0; from < starts() && !ended_perfectly_; from += kStartGroup) {
      const std::size_t known = level.size();
      begin(from, std::min(starts(), from + kStartGroup), kStartGroup / 2);
      add_unchanged(known);
    }
    sort_leaves();
    if (!ended_soundly_) beam_.leaves.clear();
    return ended_soundly_;
  }

  // The last level again, for marks that have changed after it, and for this beam's width.
  void look_again() {
    std::vector<Candidate>& level = beam_.levels.back().candidates;
    const auto chunks = chunks_of(0, level.size(), kChunk, [&](std::size_t i) { return level[i].body; });
    each_chunk(chunks, [&](std::size_t c, Expander& expander) {
      expander.look_ahead(std::span(level).subspan(chunks[c].from, chunks[c].size), beam_.levels.size() - 1);
    });
    if (beam_.levels.size() > 1)
      beam_.levels.back() = select(std::move(level), problem_, room(), kBatches, false);
  }

  // Children of the last level.
  void advance(std::size_t k) {
    const std::vector<Candidate>& parents = beam_.levels[k].candidates;
    fewest_violations_ = std::ranges::min(parents, {}, &Candidate::violations).violations;
    fewest_unmet_ = std::ranges::min(parents, {}, &Candidate::unmet).unmet;
    const std::vector<std::size_t>& ends = beam_.levels[k].batch_ends;
    const auto chunks_between = [&](std::size_t from, std::size_t to) {
      return chunks_of(from, to, kChunk, [&](std::size_t i) { return parents[i].body; });
    };
    std::vector<Candidate> all;
    const auto add = [&](std::vector<Candidate>&& more) {
      std::move(more.begin(), more.end(), std::back_inserter(all));
    };
    if (k == 0)  // the starts were chosen so that they meet the second mark
      add(collect(chunks_between(0, parents.size()),
                  [&](const Chunk& chunk, Expander& expander, std::vector<Candidate>& out) {
                    expander.follow(std::span(parents).subspan(chunk.from, chunk.size), chunk.from, k, out);
                  }));
    const auto expand = [&](std::size_t from, std::size_t to, int round, const Tolerance& tolerance) {
      const ExpandOptions how{options_.proposals.roots, options_.proposals.variants, tolerance, round == 0};
      add(collect(chunks_between(from, to), [&](const Chunk& chunk, Expander& expander,
                                                std::vector<Candidate>& out) {
        std::vector<RandomStream> random;
        for (std::size_t i = 0; i < chunk.size; ++i)
          random.push_back(
              stream((k + 1) * (kRounds + kLooseRounds) + static_cast<std::size_t>(round), chunk.from + i));
        expander.expand(std::span(parents).subspan(chunk.from, chunk.size), chunk.from, k, how, random, out);
      }));
    };
    // The best ones, then those that were left out, then all again, until there are enough.
    std::size_t from = 0;
    for (const std::size_t end : ends) {
      if (fitting(all, k) >= (from == 0 ? room() : room() / 2)) break;
      expand(from, end, 0, kPlausible);
      from = end;
    }
    for (int round = 1; round < kRounds && fitting(all, k) < room() / 2; ++round) {
      if (fitting(all, k) == 0) break;  // out of reach: more of the same would not help
      expand(0, ends.back(), round, kPlausible);
    }
    for (int round = 0; round < kLooseRounds && fitting(all, k) < room() / 8; ++round)
      expand(0, ends.front(), kRounds + round, kTolerable);
    const bool even = 2 * k <= problem_.marks.size();
    beam_.levels[k].forget(std::max(from, ends.front()));
    auto next = select(std::move(all), problem_, room(), kBatches, even);
    if (!next.candidates.empty()) beam_.levels.push_back(std::move(next));
  }

  // The ways in which candidates of the last level end as asked. At first nothing is changed any more; if
  // none then ends so, the last impact may be changed too, and its excess counts.
  void finish() {
    const std::vector<Candidate>& last = beam_.levels.back().candidates;
    add_unchanged(0);
    // In groups, until there is one, or so much is simulated that more of this beam is not worth it: bodies
    // that roll on for long cost most.
    // Where some end so but lie otherwise than is asked, more of the same is tried of fewer.
    const bool lying = ended_soundly_;
    const std::size_t group = lying ? kChunk : 4 * kChunk;
    const double most_s = beam_.simulated_s + kFinishPerState_s * static_cast<double>(options_.beam);
    for (const Tolerance& tolerance : {kPlausible, kTolerable})
      for (std::size_t from = 0; from < last.size() && !ended_well_ && beam_.simulated_s < most_s;
           from += group)
        if (!ended_soundly_ || tolerance.excess <= kPlausible.excess)
          end(from, std::min(last.size(), from + group), lying ? 1 : kFinishRounds, tolerance);
    sort_leaves();
  }

 private:
  std::size_t starts_of_each() const {
    return (room() * kStartsPerState + problem_.bodies.size() - 1) / problem_.bodies.size();
  }
  std::size_t starts() const { return starts_of_each() * problem_.bodies.size(); }

  // The first contacts with these indices.
  void begin(std::size_t from, std::size_t to, std::size_t at_once) {
    const std::size_t each = starts_of_each();
    const auto chunks =
        chunks_of(from, to, at_once, [&](std::size_t i) { return static_cast<int>(i / each); });
    std::vector<Candidate> more =
        collect(chunks, [&](const Chunk& chunk, Expander& expander, std::vector<Candidate>& out) {
          std::vector<RandomStream> random;
          for (std::size_t i = 0; i < chunk.size; ++i) random.push_back(stream(0, chunk.from + i));
          begin_candidates(problem_, chunk.body, expander.passages(), random, out, progress_);
          expander.look_ahead(out, 0);
        });
    Level& level = beam_.levels.front();
    std::move(more.begin(), more.end(), std::back_inserter(level.candidates));
    level.batch_ends = {level.candidates.size()};
  }

  // Those from `from` on that end as asked just so.
  void add_unchanged(std::size_t from) {
    const std::vector<Candidate>& last = beam_.levels.back().candidates;
    for (std::size_t i = from; i < last.size(); ++i) {
      if (!ends_as_asked(*last[i].unchanged, problem_.marks.ending)) continue;
      add_leaf(i, {last[i].onset.after, 0.0, 0.0}, *last[i].unchanged);
    }
  }

  void sort_leaves() {
    std::stable_sort(beam_.leaves.begin(), beam_.leaves.end(), [](const Leaf& a, const Leaf& b) {
      if (a.violations != b.violations) return a.violations < b.violations;
      if (a.unmet != b.unmet) return a.unmet < b.unmet;
      if (a.violations == 0 && a.stretched != b.stretched) return a.stretched < b.stretched;
      return a.log_weight > b.log_weight;
    });
  }

  // Changes the last impact of some candidates of the last level.
  void end(std::size_t from, std::size_t to, int rounds, const Tolerance& tolerance) {
    const std::vector<Candidate>& last = beam_.levels.back().candidates;
    const auto chunks = chunks_of(from, to, kChunk, [&](std::size_t i) { return last[i].body; });
    std::vector<std::vector<Trial>> trials(chunks.size());
    each_chunk(chunks, [&](std::size_t c, Expander& expander) {
      std::vector<RandomStream> random;
      for (std::size_t i = 0; i < chunks[c].size; ++i)
        random.push_back(stream(problem_.marks.size() * (kRounds + kLooseRounds), chunks[c].from + i));
      trials[c] = expander.finish(std::span(last).subspan(chunks[c].from, chunks[c].size), rounds,
                                  tolerance.excess, random);
    });
    for (std::size_t c = 0; c < chunks.size(); ++c)
      for (const Trial& t : trials[c])
        if (t.excess <= tolerance.excess)
          add_leaf(chunks[c].from + t.candidate, {t.after, t.excess, 0.0}, t.passage);
  }

  RandomStream stream(std::size_t round, std::size_t index) const {
    return RandomStream(options_.seed, (static_cast<std::uint64_t>(round + 1) << 32) | index);
  }

  // Calls work(index, expander) for each chunk, in parallel.
  template <class Work>
  void each_chunk(const std::vector<Chunk>& chunks, Work&& work) {
    std::vector<double> simulated_s(chunks.size(), 0.0);
    parallel_for(
        chunks.size(), options_.threads,
        [&](std::size_t c) {
          Expander expander(problem_, chunks[c].body, progress_);
          work(c, expander);
          simulated_s[c] = expander.simulated_s();
        },
        progress_);
    beam_.simulated_s += std::accumulate(simulated_s.begin(), simulated_s.end(), 0.0);
  }

  // The candidates that work(chunk, expander, out) makes, in the order of the chunks.
  template <class Work>
  std::vector<Candidate> collect(const std::vector<Chunk>& chunks, Work&& work) {
    std::vector<std::vector<Candidate>> made(chunks.size());
    each_chunk(chunks, [&](std::size_t c, Expander& expander) { work(chunks[c], expander, made[c]); });
    std::vector<Candidate> all;
    for (auto& part : made) std::move(part.begin(), part.end(), std::back_inserter(all));
    return all;
  }

  // How many of them would be kept for their own sake: plausible as far as the marks before allowed it, and
  // not too many of one parent.
  std::size_t fitting(const std::vector<Candidate>& all, std::size_t k) const {
    const bool last = k + 2 == problem_.marks.size();
    std::vector<std::size_t> born;
    std::size_t n = 0;
    for (const Candidate& c : all) {
      if (c.violations > fewest_violations_ || c.unmet > fewest_unmet_) continue;
      if (c.toll > kDear) continue;
      if (last && ends_as_asked(*c.unchanged, problem_.marks.ending) &&
          c.log_rest(problem_, *c.unchanged) >= std::log(kMetFactor))
        return room();
      const auto parent = static_cast<std::size_t>(c.parent);
      if (parent >= born.size()) born.resize(parent + 1, 0);
      if (born[parent]++ < kMostChildren) ++n;
    }
    return n;
  }

  void add_leaf(std::size_t i, const Leave& leave, const Passage& passage) {
    const Candidate& c = beam_.levels.back().candidates[i];
    const std::size_t k = problem_.marks.size() - 1;
    const double log_factors = problem_.log_sound(passage.event, k, c.first_amplitude) - leave.excess;
    const bool sound = leave.excess <= kPlausible.excess && log_factors >= kLeastLogFactors;
    const double log_rest = c.log_rest(problem_, passage);
    const bool met = log_rest >= std::log(kMetFactor);
    ended_soundly_ |= sound;
    ended_perfectly_ |= sound && c.log_weight + log_factors > -kPerfect;
    ended_well_ |= sound && met;
    beam_.leaves.push_back({static_cast<int>(i), leave,
                            c.log_weight + log_factors + c.log_constraints + log_rest,
                            c.violations + (sound ? 0 : 1), c.unmet + (met ? 0 : 1), c.stretched});
  }

  const Problem& problem_;
  const BeamOptions& options_;
  Progress* progress_;
  Beam& beam_;
  bool ended_soundly_ = false, ended_well_ = false;  // some leaf; and it lies as is asked at rest
  bool ended_perfectly_ = false;                     // some leaf, with all factors 1
  int fewest_violations_ = 0, fewest_unmet_ = 0;     // of the level that is gone on from
};

}  // namespace

Beam search_beam(const Problem& problem, const BeamOptions& options, Progress* progress, const Beam* kept,
                 std::size_t same) {
  Beam beam;
  Search search(problem, options, progress, beam);
  const std::size_t n = problem.marks.size();
  const auto raise_to = [&](double fraction) {
    if (progress) progress->raise_to(fraction);
  };
  if (kept && same > 0 && kept->levels.size() >= same) {
    beam.levels.assign(kept->levels.begin(), kept->levels.begin() + static_cast<std::ptrdiff_t>(same));
    search.look_again();
  } else if (options.few_starts && search.begin_with_few()) {
    return beam;
  } else if (!options.few_starts) {
    search.begin();
  }
  if (beam.levels[0].candidates.empty()) {
    beam.levels.clear();
    return beam;
  }
  for (std::size_t k = beam.levels.size() - 1; k + 1 < n && beam.levels.size() == k + 1; ++k) {
    raise_to(static_cast<double>(k + 1) / static_cast<double>(n + 1));
    search.advance(k);
  }
  raise_to(static_cast<double>(n) / static_cast<double>(n + 1));
  if (beam.levels.size() == n) search.finish();
  return beam;
}

namespace {

Found trace(const Beam& beam, int candidate, const Leave& leave) {
  const Candidate* c = &beam.levels.back().candidates[static_cast<std::size_t>(candidate)];
  Found found{c->body, {{c->onset, leave}}};
  for (std::size_t k = beam.levels.size() - 1; k > 0; --k) {
    const Candidate& parent = beam.levels[k - 1].candidates[static_cast<std::size_t>(c->parent)];
    found.links.push_back({parent.onset, c->from});
    c = &parent;
  }
  std::reverse(found.links.begin(), found.links.end());
  return found;
}

}  // namespace

Beam track_beam(const Problem& problem, const BeamOptions& options, Progress* progress, const Beam& kept,
                std::size_t same) {
  Beam beam;
  const std::size_t n = problem.marks.size();
  if (kept.leaves.empty() || kept.levels.size() != n || same == 0) return beam;
  const Leaf& leaf = kept.leaves.front();
  const Found known = trace(kept, leaf);
  std::vector<int> way(n);  // the candidates it goes through
  way[n - 1] = leaf.candidate;
  for (std::size_t k = n - 1; k > 0; --k)
    way[k - 1] = kept.levels[k].candidates[static_cast<std::size_t>(way[k])].parent;

  beam.levels.assign(kept.levels.begin(), kept.levels.begin() + static_cast<std::ptrdiff_t>(same));
  Expander expander(problem, known.body, progress);
  std::size_t from = static_cast<std::size_t>(way[same - 1]), count = 1;
  for (std::size_t k = same - 1; k + 1 < n; ++k) {
    std::vector<RandomStream> random;
    for (std::size_t i = 0; i < count; ++i)
      random.emplace_back(options.seed, (static_cast<std::uint64_t>(k + 1) << 48) | i);
    std::vector<Candidate> parents(
        beam.levels[k].candidates.begin() + static_cast<std::ptrdiff_t>(from),
        beam.levels[k].candidates.begin() + static_cast<std::ptrdiff_t>(from + count));
    if (k + 1 == same) expander.look_ahead(parents, k);  // which was forgotten
    Level next;
    expander.track(parents, from, k, known.links[k], known.links[k + 1].onset, random, next.candidates);
    if (next.candidates.size() < kFewTracked) {  // about to be lost: what else comes in time?
      const ExpandOptions how{options.proposals.roots, options.proposals.variants, kPlausible, true};
      expander.expand(parents, from, k, how, random, next.candidates);
      next = select(std::move(next.candidates), problem, static_cast<std::size_t>(options.beam), 1, false);
    }
    if (next.candidates.empty()) break;
    from = 0;
    count = next.candidates.size();
    next.batch_ends = {count};
    beam.levels.push_back(std::move(next));
  }
  if (beam.levels.size() == same && same < n) return beam;
  Search search(problem, options, progress, beam);
  if (same == n) search.look_again();  // the ending may be another one
  for (std::size_t k = beam.levels.size() - 1; k + 1 < n && beam.levels.size() == k + 1; ++k)
    search.advance(k);
  if (beam.levels.size() == n) search.finish();
  beam.simulated_s += expander.simulated_s();
  return beam;
}

Found trace(const Beam& beam, const Leaf& leaf) {
  Found found = trace(beam, leaf.candidate, leaf.leave);
  found.complete = true;
  return found;
}

Found best_of(const Beam& beam) {
  if (!beam.leaves.empty()) return trace(beam, beam.leaves.front());
  const auto& last = beam.levels.back().candidates;
  const auto best = std::min_element(last.begin(), last.end(), [](const Candidate& a, const Candidate& b) {
    if (a.sounder(b) || b.sounder(a)) return a.sounder(b);
    return a.rank() > b.rank();
  });
  return trace(beam, static_cast<int>(best - last.begin()), {best->onset.after, 0.0, 0.0});
}

}  // namespace ifa
