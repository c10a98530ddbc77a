#include "ifa/forward/trial.hpp"

#include <algorithm>
#include <cmath>

namespace ifa {
namespace {

// How long a passage is followed to rest.
double settling_limit_s(const Problem& problem, const Body& body, std::size_t k, const State& after) {
  count_run(Effect::settling_to_rest);
  // Without friction what slides never stops, and is not worth watching.
  const bool stops = problem.plan.on(Effect::friction) && body.material().friction > 0.0;
  const bool slides = after.velocity.head<2>().norm() >= problem.physics.simulation.rest_speed_m_s;
  if (!stops && slides) return problem.marks.ending == Ending::rest ? 0.0 : kOpenTail_s;
  // A contact that goes on longer than its mark has no length factor left (eq. 7: 0.1 s costs all of it).
  constexpr double kLonger_s = 1.0;
  const bool contact = problem.physics.hearing.events == Events::contact;
  return contact ? problem.marks.durations_s[k] + kLonger_s : kLongestRest_s;
}

// How a body leaves event k, and how long it is followed: to the next mark, to rest, or until the last event
// is over.
Departure departure(const Problem& problem, const Body& body, std::size_t k, const Hit& hit,
                    const State& after) {
  const double span_s = problem.marks.durations_s[k];
  const bool contact = problem.physics.hearing.events == Events::contact;
  if (k + 1 < problem.marks.size()) return {hit, after, span_s, kLateShare * problem.target_s(k)};
  if (problem.settles_after(k)) return {hit, after, span_s, settling_limit_s(problem, body, k, after)};
  if (contact) return {hit, after, span_s, kOpenTail_s};  // an event may last
  return {hit, after, span_s, span_s + problem.physics.event_over_s(), true};
}

void judge(const Problem& problem, std::size_t k, Trial& trial) {
  const Passage& passage = trial.passage;
  trial.lateness_s = kNever;
  if (k + 1 == problem.marks.size()) {
    trial.meets = ends_as_asked(passage, problem.marks.ending);
    if (trial.meets) trial.lateness_s = passage.event.length_s - problem.marks.durations_s[k];
  } else {
    trial.meets = passage.next == Next::hit;
    if (passage.hits()) trial.lateness_s = passage.interval_s - problem.target_s(k);
  }
}

}  // namespace

bool ends_as_asked(const Passage& passage, Ending ending) {
  return passage.next != Next::dubious && (ending == Ending::open || passage.next == Next::rest);
}

Trials::Trials(const Problem& problem, int body, const Progress* progress)
    : problem_(problem),
      body_index_(body),
      body_(problem.bodies[static_cast<std::size_t>(body)]),
      progress_(progress),
      passages_(body_, problem.physics) {}

std::optional<Trial> Trials::propose(std::span<const Candidate> candidates, std::size_t index, const Vec6& y,
                                     double largest_excess) const {
  const Onset& onset = candidates[index].onset;
  const PlausibleRegion region = this->region(onset);
  Trial trial;
  trial.candidate = index;
  trial.y = y;
  trial.excess = y.squaredNorm();
  trial.after = onset.after;
  trial.after.velocity += region.velocity_offset(y);
  trial.after.angular_velocity += region.spin_offset(y);
  if (passages_.settle(trial.after)) {
    trial.excess = region.excess(trial.after.velocity - onset.after.velocity,
                                 trial.after.angular_velocity - onset.after.angular_velocity);
    if (trial.excess > largest_excess) return std::nullopt;
  }
  if (kinetic_energy(body_, trial.after) >
      kinetic_energy(body_, onset.before) + problem_.physics.energy_gain_j)
    return std::nullopt;
  return trial;
}

PlausibleRegion Trials::region(const Onset& onset) const {
  return PlausibleRegion(onset.after.velocity - onset.before.velocity,
                         onset.after.angular_velocity - onset.before.angular_velocity,
                         body_.bounding_radius_m());
}

Vec6 Trials::change(const Onset& onset, const State& after) const {
  return region(onset).coordinates(after.velocity - onset.after.velocity,
                                   after.angular_velocity - onset.after.angular_velocity);
}

Trial Trials::unchanged(std::span<const Candidate> candidates, std::size_t index, std::size_t k) const {
  Trial trial;
  trial.candidate = index;
  trial.after = candidates[index].onset.after;
  trial.passage = *candidates[index].unchanged;
  judge(problem_, k, trial);
  return trial;
}

void Trials::run(std::span<const Candidate> candidates, std::size_t k, std::span<Trial> trials) {
  departures_.clear();
  for (const Trial& t : trials)
    departures_.push_back(departure(problem_, body_, k, candidates[t.candidate].onset.hit, t.after));
  arrivals_.resize(trials.size());
  passages_.run(departures_, arrivals_, progress_);
  for (std::size_t i = 0; i < trials.size(); ++i) {
    trials[i].passage = arrivals_[i];
    judge(problem_, k, trials[i]);
  }
}

std::vector<Passage> Trials::follow(std::span<const Onset> onsets, std::size_t k) {
  departures_.clear();
  for (const Onset& onset : onsets)
    departures_.push_back(departure(problem_, body_, k, onset.hit, onset.after));
  std::vector<Passage> passages(onsets.size());
  passages_.run(departures_, passages, progress_);
  return passages;
}

double Trial::log_factors(const Problem& problem, std::size_t k, double first_amplitude) const {
  double sum = -excess + problem.log_sound(passage.event, k, first_amplitude);  // eq. 3
  if (meets && k + 1 < problem.marks.size())
    sum += std::log(std::max(1e-300, time_factor(passage.interval_s, problem.target_s(k))));
  return sum;
}

Vec6 random_change(double largest_excess, RandomStream& random) {
  Vec6 y;
  for (int i = 0; i < 6; ++i) y[i] = random.normal();
  return y * (std::sqrt(largest_excess) * std::sqrt(random.uniform()) / y.norm());
}

}  // namespace ifa
