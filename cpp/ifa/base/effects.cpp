#include "ifa/base/effects.hpp"

namespace ifa {

constinit thread_local EffectCounts effect_counts{};

}  // namespace ifa
