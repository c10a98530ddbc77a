#include "ifa/graph/search.hpp"

#include <cmath>

#include "ifa/base/counted.hpp"

namespace ifa {

Targets::Targets(const Marks& marks, const SoundTerms& judged_terms)
    : durations_s(marks.durations_s),
      centroids_s(marks.centroids_s),
      rest(marks.ending == Ending::rest),
      judged(judged_terms) {
  for (std::size_t k = 0; k + 1 < marks.size(); ++k)
    intervals_s.push_back(marks.times_s[k + 1] - marks.times_s[k]);
  for (const double a : marks.amplitudes) amplitudes.push_back(a / marks.amplitudes.front());
}

NodeBrief brief_of(const Nodes& nodes, std::size_t i) {
  return {nodes.delay_s[i],  nodes.flight_s[i],   nodes.amplitude[i],
          nodes.length_s[i], nodes.centroid_s[i], nodes.flags[i]};
}

bool fits(const NodeBrief& node, const Targets& targets, std::size_t k) {
  if ((node.flags & kDubious) != 0) return false;
  if (k + 1 < targets.size()) return (node.flags & kEdge) != 0;
  return !targets.rest || (node.flags & kTerminal) != 0;
}

double log_sound(const NodeBrief& node, const Targets& targets, std::size_t k, double first_amplitude) {
  double log = 0.0;
  if (!targets.amplitudes.empty() && k > 0) {
    count_run(Effect::amplitude_matching);
    log += log_amplitude_factor(node.amplitude / first_amplitude, targets.amplitudes[k]);
  }
  const double duration_s = targets.durations_s[k];
  if (duration_s == 0.0) return node.length_s > 0.0f ? log + log_length_factor(node.length_s, 0.0) : log;
  if (targets.judged.length) {
    count_run(Effect::length_matching);
    log += log_length_factor(node.length_s, duration_s);
  }
  if (!std::isnan(targets.centroids_s[k])) {
    count_run(Effect::centroid_matching);
    log += log_length_factor(node.centroid_s, targets.centroids_s[k]);
  }
  return log;
}

}  // namespace ifa
