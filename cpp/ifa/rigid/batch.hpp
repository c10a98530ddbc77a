// Many simulations at once, into the caller's arrays.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/rigid/event_engine.hpp"

namespace ifa {

// Why a sample ended: as RunStatus, or `not_run`: the batch was cancelled before it.
enum class SampleStatus : std::uint8_t { rest, time_limit, impact_limit, failed, not_run, contact };

// Where results go, sample by sample: row i of each array is sample i's, and what a sample does not have
// stays as it was. An empty span is not wanted. For n samples and room for m hits:
struct BatchOutputs {
  std::span<SampleStatus> status;            // (n)
  std::span<double> end_time_s;              // (n) when it ended; for rest, when rest began
  std::span<double> position_m;              // (n, 3) at the end; principal axes, as all states here
  std::span<double> quaternion_wxyz;         // (n, 4)
  std::span<double> velocity_m_s;            // (n, 3)
  std::span<double> angular_velocity_rad_s;  // (n, 3)
  std::span<std::int32_t> hit_count;         // (n) all hits, also those beyond the m that are kept
  std::span<double> hit_time_s;              // (n, m)
  std::span<double> hit_impulse_n_s;         // (n, m, 3)
  std::span<double> hit_approach_speed_m_s;  // (n, m)
  std::span<double> hit_position_m;          // (n, m, 3)
  std::size_t hits_per_sample = 0;           // m
};

struct BatchOptions {
  SimulationOptions simulation;
  double until_s = 30.0;
  int threads = 0;                   // 0: one for each core
  std::string_view instruction_set;  // "scalar", "sse2", "avx2", "avx512"; empty: the widest that runs here
};

// Sample i is body `bodies[i]` (or `bodies[0]`, if there is one) from `states[i]`, in principal axes. The
// same bytes for any number of threads, order and batch size. A cancelled `progress` ends it with Cancelled;
// the samples that were done by then are whole, the others not_run.
// Throws ArgumentError on an instruction set that this processor does not run.
void simulate_batch(std::span<const Body* const> bodies, std::span<const State> states,
                    const BatchOptions& options, const BatchOutputs& outputs, Progress* progress = nullptr);

// The names of the instruction sets that run here, the narrowest first.
std::vector<std::string_view> instruction_sets();

}  // namespace ifa
