#include "ifa/rigid/batch.hpp"

#include <algorithm>
#include <atomic>

#include "ifa/base/parallel.hpp"

namespace ifa {
namespace {

void put(std::span<double> row_array, std::size_t row, std::initializer_list<double> values) {
  if (!row_array.empty()) std::copy(values.begin(), values.end(), row_array.begin() + row * values.size());
}

void put(std::span<double> row_array, std::size_t row, const Vec3& v) {
  put(row_array, row, {v.x(), v.y(), v.z()});
}

void write_run(const Run& run, std::size_t i, const BatchOutputs& out) {
  const State& end = run.nodes.back().state;
  if (!out.status.empty()) out.status[i] = static_cast<SampleStatus>(run.status);
  put(out.end_time_s, i, {run.status == RunStatus::rest ? run.rest_s : run.nodes.back().time_s});
  put(out.position_m, i, end.position);
  put(out.quaternion_wxyz, i,
      {end.orientation.w(), end.orientation.x(), end.orientation.y(), end.orientation.z()});
  put(out.velocity_m_s, i, end.velocity);
  put(out.angular_velocity_rad_s, i, end.angular_velocity);
  if (!out.hit_count.empty()) out.hit_count[i] = static_cast<std::int32_t>(run.hits.size());
  for (std::size_t k = 0; k < std::min(run.hits.size(), out.hits_per_sample); ++k) {
    const std::size_t row = i * out.hits_per_sample + k;
    const Hit& hit = run.hits[k];
    put(out.hit_time_s, row, {hit.time_s});
    put(out.hit_impulse_n_s, row, hit.impulse_n_s);
    put(out.hit_approach_speed_m_s, row, {hit.approach_speed_m_s});
    put(out.hit_position_m, row, hit.position_m);
  }
}

}  // namespace

void simulate_batch(std::span<const Body* const> bodies, std::span<const State> states,
                    const BatchOptions& options, const BatchOutputs& outputs, Progress* progress) {
  std::fill(outputs.status.begin(), outputs.status.end(), SampleStatus::not_run);
  std::atomic<std::size_t> done{0};
  parallel_for(
      states.size(), options.threads,
      [&](std::size_t i) {
        const Body& body = *bodies[bodies.size() == 1 ? 0 : i];
        write_run(simulate(body, states[i], options.simulation, options.until_s, progress), i, outputs);
        if (progress) progress->raise_to(static_cast<double>(++done) / static_cast<double>(states.size()));
      },
      progress);
}

}  // namespace ifa
