#include "ifa/forward/conflicts.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/base/message.hpp"
#include "ifa/solution/standard.hpp"

namespace ifa {
namespace {

// "1 mark", "3 marks".
std::string count(std::size_t n, const char* what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

std::string percent(double share) { return brief(100.0 * share) + " %"; }

std::string missed_text(std::size_t k, std::size_t n) {
  std::string text = k == 0 ? "no first contact was found from which the next mark could be met"
                            : "no motion that meets the marks before it has a hit there";
  if (k + 1 < n) text += "; " + count(n - k - 1, "mark") + " after it not tried";
  return text;
}

std::string retimed_text(const EventReport& event) {
  const bool slower = event.retime > 1.0;
  return std::string("the gap before it must be ") + (slower ? "stretched" : "squeezed") + " by " +
         percent(slower ? event.retime - 1.0 : 1.0 / event.retime - 1.0) + ", and more than " +
         percent(kPlausible.retime) + " shows";
}

// Factors that only the sound decides, as a product.
double sound_factor(const Factors& f) { return f.amplitude * f.length * f.centroid; }

}  // namespace

std::string_view name_of(ConflictKind kind) {
  constexpr std::string_view kNames[] = {"missed", "implausible", "retimed",
                                         "unrest", "sound",       "penetration"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::vector<Conflict> conflicts_of(const Marks& marks, const Estimate& estimate, const Solution* solution) {
  const std::size_t n = marks.size();
  std::vector<Conflict> conflicts;
  const auto add = [&](std::size_t mark, ConflictKind kind, std::string text) {
    conflicts.push_back({mark, kind, std::move(text), {}});
  };
  if (!solution) {
    add(0, ConflictKind::missed, missed_text(0, n));
  } else if (!solution->plausible) {
    std::size_t missed = n;
    for (std::size_t k = 0; k < n && missed == n; ++k) {
      const EventReport& event = solution->events[k];
      if (event.factors.time == 0.0) {
        missed = k;
        add(k, ConflictKind::missed, missed_text(k, n));
        continue;
      }
      if (event.excess > kPlausible.excess + kStandardRounding)
        add(k, ConflictKind::implausible,
            "it is met only by changing an impact beyond what looks like physics (excess " +
                brief(event.excess) + ", plausible up to 1)");
      if (std::max(event.retime, 1.0 / event.retime) > 1.0 + kPlausible.retime + kStandardRounding)
        add(k, ConflictKind::retimed, retimed_text(event));
    }
    if (missed == n && solution->extra_hits > 0)
      add(n - 1, ConflictKind::unrest,
          "the body does not come to rest after it: " +
              count(static_cast<std::size_t>(solution->extra_hits), "hit") + " without a mark");
    if (conflicts.empty() && solution->score < kLeastScore) {
      const auto worst = std::min_element(solution->events.begin(), solution->events.end(),
                                          [](const EventReport& a, const EventReport& b) {
                                            return sound_factor(a.factors) < sound_factor(b.factors);
                                          });
      add(static_cast<std::size_t>(worst - solution->events.begin()), ConflictKind::sound,
          "it is met in time, but not as loud or as long as it sounds (Score " + brief(solution->score) +
              ", at least " + brief(kLeastScore) + " is needed)");
    }
    if (conflicts.empty() && solution->max_penetration_m > kMostPenetration_m)
      add(n - 1, ConflictKind::penetration,
          "up to it the body sinks " + measure(solution->max_penetration_m, "m") + " into the ground");
    if (conflicts.empty()) add(n - 1, ConflictKind::unrest, "the body does not come to rest after it");
  }
  if (conflicts.empty()) return conflicts;
  for (const Finding& finding : estimate.findings) {
    const auto same = std::find_if(conflicts.begin(), conflicts.end(),
                                   [&](const Conflict& c) { return c.mark == finding.mark; });
    if (same == conflicts.end()) continue;
    if (!same->finding.empty()) same->finding += "; ";
    same->finding += finding.text;
  }
  return conflicts;
}

}  // namespace ifa
