// One object for progress and cancellation, shared by the worker and whoever watches it.
#pragma once

#include <atomic>

#include "ifa/base/error.hpp"

namespace ifa {

// Thread-safe. The worker raises `fraction` and asks `throw_if_cancelled` at least every few
// milliseconds; any other thread reads `fraction` and may call `cancel`. The fraction never falls.
class Progress {
 public:
  Progress() = default;

  // Of a call within a longer one, from one fraction of `whole` to another: raising this raises that, and
  // cancelling that cancels this. `whole` may be null; it must outlive this.
  Progress(Progress* whole, double from, double to) : whole_(whole), from_(from), to_(to) {}

  double fraction() const { return fraction_.load(std::memory_order_relaxed); }

  void raise_to(double fraction) {
    double seen = fraction_.load(std::memory_order_relaxed);
    while (fraction > seen && !fraction_.compare_exchange_weak(seen, fraction)) {
    }
    if (whole_) whole_->raise_to(from_ + (to_ - from_) * fraction);
  }

  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const {
    return cancelled_.load(std::memory_order_relaxed) || (whole_ && whole_->cancelled());
  }
  void throw_if_cancelled() const {
    if (cancelled()) throw Cancelled();
  }

 private:
  Progress* whole_ = nullptr;
  double from_ = 0.0, to_ = 1.0;
  std::atomic<double> fraction_{0.0};
  std::atomic<bool> cancelled_{false};
};

}  // namespace ifa
