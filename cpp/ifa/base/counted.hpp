// Counting where an effect's code runs, for code that is compiled once. (The kernels count by hand: see
// effects.hpp.)
#pragma once

#include "ifa/base/effects.hpp"

namespace ifa {

constexpr std::size_t index_of(Effect effect) { return static_cast<std::size_t>(effect); }

inline void count_run(Effect effect) { ++effect_counts.runs[index_of(effect)]; }

// This thread's counts since `before`.
inline EffectCounts counted_since(const EffectCounts& before) {
  EffectCounts since = effect_counts;
  for (std::size_t e = 0; e < kEffects; ++e) since.runs[e] -= before.runs[e];
  return since;
}

inline void add_counts(EffectCounts& sum, const EffectCounts& more) {
  for (std::size_t e = 0; e < kEffects; ++e) sum.runs[e] += more.runs[e];
}

}  // namespace ifa
