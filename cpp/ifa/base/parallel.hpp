// Parallel loops. Each index writes only its own results, so the outcome does not depend on the
// number of threads. What effects the threads count is counted for the caller's.
#pragma once

#include <cstddef>
#include <functional>

#include "ifa/base/progress.hpp"

namespace ifa {

// The number of threads that `requested` stands for: itself if positive, else one for each core.
int thread_count(int requested);

// Calls body(i) for each i in [0, n) on up to `threads` threads. Of the exceptions that
// were thrown, the one of the lowest index is rethrown here once all threads have stopped; a cancelled
// `progress` (may be null) ends the loop with Cancelled.
void parallel_for(std::size_t n, int threads, const std::function<void(std::size_t)>& body,
                  const Progress* progress = nullptr);

}  // namespace ifa
