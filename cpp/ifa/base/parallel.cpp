#include "ifa/base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "ifa/base/counted.hpp"

namespace ifa {

int thread_count(int requested) {
  if (requested > 0) return requested;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallel_for(std::size_t n, int threads, const std::function<void(std::size_t)>& body,
                  const Progress* progress) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::exception_ptr error;
  std::size_t error_index = n;
  EffectCounts others_counts{};

  const auto work = [&] {
    while (!stop.load(std::memory_order_relaxed)) {
      const std::size_t i = next.fetch_add(1);
      if (i >= n) return;
      try {
        if (progress) progress->throw_if_cancelled();
        body(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error || i < error_index) {
          error = std::current_exception();
          error_index = i;
        }
        stop = true;
      }
    }
  };

  const std::size_t workers = std::min(n, static_cast<std::size_t>(thread_count(threads)));
  std::vector<std::jthread> others;
  for (std::size_t t = 1; t < workers; ++t)
    others.emplace_back([&] {
      work();
      const std::lock_guard lock(mutex);
      add_counts(others_counts, effect_counts);  // all of this new thread's
    });
  work();
  others.clear();  // joins
  add_counts(effect_counts, others_counts);
  if (error) std::rethrow_exception(error);
}

}  // namespace ifa
