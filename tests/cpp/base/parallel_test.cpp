#include "ifa/base/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "ifa/base/random.hpp"

namespace ifa {
namespace {

TEST(ThreadCount, IsTheRequestOrOneForEachCore) {
  EXPECT_EQ(thread_count(1), 1);
  EXPECT_EQ(thread_count(37), 37);
  EXPECT_GE(thread_count(0), 1);
  EXPECT_EQ(thread_count(-1), thread_count(0));
}

TEST(ParallelFor, CallsEachIndexOnce) {
  for (const std::size_t n : {0, 1, 2, 7, 1000}) {
    for (const int threads : {0, 1, 2, 5, 16}) {
      std::vector<std::atomic<int>> calls(n);
      parallel_for(n, threads, [&](std::size_t i) { ++calls[i]; });
      for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(calls[i], 1) << n << " " << threads << " " << i;
    }
  }
}

TEST(ParallelFor, ResultsDoNotDependOnTheNumberOfThreads) {
  const auto run = [](int threads) {
    std::vector<double> results(500);
    parallel_for(results.size(), threads, [&](std::size_t i) {
      RandomStream stream(42, i);
      for (std::size_t draw = 0; draw <= i % 50; ++draw) results[i] += stream.normal();
    });
    return results;
  };
  const auto serial = run(1);
  for (const int threads : {2, 3, 8}) EXPECT_EQ(run(threads), serial) << threads;
}

TEST(ParallelFor, UsesNoMoreThreadsThanAsked) {
  std::atomic<int> running{0}, most{0};
  parallel_for(200, 3, [&](std::size_t) {
    const int now = ++running;
    int seen = most;
    while (now > seen && !most.compare_exchange_weak(seen, now)) {
    }
    std::this_thread::yield();
    --running;
  });
  EXPECT_LE(most, 3);
}

// Every index below one that was handed out is run as well, so the lowest failing index always is.
TEST(ParallelFor, RethrowsTheErrorOfTheLowestIndex) {
  for (const int threads : {1, 2, 4, 8}) {
    for (int repeat = 0; repeat < 50; ++repeat) {
      try {
        parallel_for(100, threads, [](std::size_t i) {
          if (i == 17 || i >= 40) throw ArgumentError("index " + std::to_string(i));
        });
        FAIL() << "no error on " << threads << " threads";
      } catch (const ArgumentError& e) {
        EXPECT_STREQ(e.what(), "index 17") << threads;
      }
    }
  }
}

TEST(ParallelFor, StopsAfterAnError) {
  std::size_t calls = 0;
  EXPECT_THROW(parallel_for(1000, 1,
                            [&](std::size_t i) {
                              ++calls;
                              if (i == 9) throw Error("stop");
                            }),
               Error);
  EXPECT_EQ(calls, 10u);
}

TEST(ParallelFor, PassesOnErrorsOfAnyType) {
  EXPECT_THROW(parallel_for(10, 4, [](std::size_t) { throw 1; }), int);
}

TEST(ParallelFor, DoesNothingOnceCancelled) {
  Progress progress;
  progress.cancel();
  std::atomic<int> calls{0};
  EXPECT_THROW(parallel_for(100, 4, [&](std::size_t) { ++calls; }, &progress), Cancelled);
  EXPECT_EQ(calls, 0);
}

TEST(ParallelFor, CancelEndsTheLoopFromInside) {
  Progress progress;
  std::size_t calls = 0;
  const auto body = [&](std::size_t i) {
    ++calls;
    if (i == 20) progress.cancel();
  };
  EXPECT_THROW(parallel_for(1000, 1, body, &progress), Cancelled);
  EXPECT_EQ(calls, 21u);
}

// The loop would never end by itself: each index waits until the cancel of another thread is seen.
TEST(ParallelFor, CancelFromAnotherThreadEndsTheLoop) {
  Progress progress;
  std::atomic<bool> started{false};
  std::jthread watcher([&] {
    while (!started) std::this_thread::yield();
    progress.cancel();
  });
  const auto body = [&](std::size_t) {
    started = true;
    while (!progress.cancelled()) std::this_thread::yield();
    progress.throw_if_cancelled();
  };
  EXPECT_THROW(parallel_for(100, 2, body, &progress), Cancelled);
}

TEST(Progress, FractionNeverFalls) {
  Progress progress;
  EXPECT_EQ(progress.fraction(), 0.0);
  progress.raise_to(0.5);
  progress.raise_to(0.25);
  EXPECT_EQ(progress.fraction(), 0.5);
  progress.raise_to(1.0);
  EXPECT_EQ(progress.fraction(), 1.0);
}

TEST(Progress, KeepsTheHighestOfManyThreads) {
  Progress progress;
  parallel_for(1001, 4, [&](std::size_t i) {
    const double mine = static_cast<double>(i * 5 % 1001) / 1000.0;
    progress.raise_to(mine);
    EXPECT_GE(progress.fraction(), mine);
  });
  EXPECT_EQ(progress.fraction(), 1.0);
}

TEST(Progress, CancelIsSeenAndStays) {
  Progress progress;
  EXPECT_FALSE(progress.cancelled());
  EXPECT_NO_THROW(progress.throw_if_cancelled());
  progress.cancel();
  EXPECT_TRUE(progress.cancelled());
  EXPECT_THROW(progress.throw_if_cancelled(), Cancelled);
}

// What the bindings rely on to map each to one Python class.
TEST(Errors, EveryErrorIsAnError) {
  EXPECT_THROW(throw ArgumentError("mass_kg: must be positive"), Error);
  EXPECT_THROW(throw FileError("roll.wav: no such file"), Error);
  EXPECT_THROW(throw Cancelled(), Error);
  EXPECT_STREQ(ArgumentError("mass_kg: must be positive").what(), "mass_kg: must be positive");
}

}  // namespace
}  // namespace ifa
