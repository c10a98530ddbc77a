// One object for progress and cancellation, shared by the worker and whoever watches it.
#pragma once

#include <atomic>

#include "ifa/base/error.hpp"

namespace ifa {

// Thread-safe. The worker raises `fraction` and asks `throw_if_cancelled` at least every few
// milliseconds; any other thread reads `fraction` and may call `cancel`. The fraction never falls.
class Progress {
 public:
  double fraction() const { return fraction_.load(std::memory_order_relaxed); }

  void raise_to(double fraction) {
    double seen = fraction_.load(std::memory_order_relaxed);
    while (fraction > seen && !fraction_.compare_exchange_weak(seen, fraction)) {
    }
  }

  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }
  void throw_if_cancelled() const {
    if (cancelled()) throw Cancelled();
  }

 private:
  std::atomic<double> fraction_{0.0};
  std::atomic<bool> cancelled_{false};
};

}  // namespace ifa
