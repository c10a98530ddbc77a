#include "ifa/rigid/batch.hpp"

#include <algorithm>
#include <atomic>
#include <functional>
#include <numeric>
#include <string>
#include <utility>

#include "ifa/base/parallel.hpp"
#include "ifa/rigid/flock.hpp"

namespace ifa {
namespace {

constexpr std::size_t kLeastChunk = 16, kMostChunk = 512;  // samples a thread takes at once

void put(std::span<double> rows, std::size_t row, const double* values, std::size_t width) {
  if (!rows.empty()) std::copy_n(values, width, rows.begin() + static_cast<std::ptrdiff_t>(row * width));
}

const lanes::Kernels& kernels_named(std::string_view name) {
  const auto all = lanes::available_kernels();
  if (name.empty()) return *all.back();
  std::string names;
  for (const lanes::Kernels* k : all) {
    if (name == k->name) return *k;
    names += (names.empty() ? "" : ", ") + std::string(k->name);
  }
  throw ArgumentError("instruction_set: '" + std::string(name) + "' does not run here; there are " + names);
}

struct Sample : lanes::Sim {
  std::size_t index;
  int hits;                                             // all of them
  std::vector<std::pair<double, lanes::HitData>> kept;  // as many as there is room for, with their times
};

// Writes what the samples of one chunk yield.
class Recorder {
 public:
  static constexpr bool kStrikesAtStart = true, kWantsLoads = false;

  Recorder(Flock<Sample>& flock, std::span<const std::size_t> samples, std::span<const State> states,
           const BatchOptions& options, const BatchOutputs& out, std::function<void()> finished)
      : flock_(flock),
        samples_(samples),
        states_(states),
        options_(options),
        out_(out),
        finished_(std::move(finished)) {}

  bool begin(Sample& m) {
    if (next_ == samples_.size()) return false;
    m.index = samples_[next_++];
    static_cast<lanes::Sim&>(m) = begin_sim(flock_.body(), flock_.settings(), states_[m.index], 0.0);
    m.until_s = options_.until_s;
    m.hits = 0;
    m.kept.clear();
    return true;
  }

  void impact(const Sample&) {}

  bool resolved(Sample& m, const lanes::HitData& hit) {
    if (static_cast<std::size_t>(m.hits++) < out_.hits_per_sample) m.kept.push_back({m.time_s, hit});
    if (m.hits < options_.simulation.max_impacts) return true;
    finish(m, SampleStatus::impact_limit);
    return false;
  }

  void ended(Sample& m, lanes::Stop stop) {
    finish(m, stop == lanes::Stop::rest      ? SampleStatus::rest
              : stop == lanes::Stop::contact ? SampleStatus::contact
                                             : SampleStatus::time_limit);
  }

 private:
  // A sample is written once it is whole: one that is cancelled leaves its rows as they were.
  void finish(const Sample& m, SampleStatus status) {
    const std::size_t i = m.index;
    if (!is_finite(state_of(m))) status = SampleStatus::failed;
    if (!out_.status.empty()) out_.status[i] = status;
    if (status != SampleStatus::failed) write(m, status);
    finished_();
  }

  void write(const Sample& m, SampleStatus status) {
    const std::size_t i = m.index;
    put(out_.end_time_s, i, status == SampleStatus::rest ? &m.slow_since_s : &m.time_s, 1);
    put(out_.position_m, i, m.position, 3);
    put(out_.quaternion_wxyz, i, m.orientation, 4);
    put(out_.velocity_m_s, i, m.velocity, 3);
    put(out_.angular_velocity_rad_s, i, m.spin, 3);
    for (std::size_t k = 0; k < m.kept.size(); ++k) {
      const std::size_t row = i * out_.hits_per_sample + k;
      const auto& [time_s, hit] = m.kept[k];
      put(out_.hit_time_s, row, &time_s, 1);
      put(out_.hit_impulse_n_s, row, hit.impulse, 3);
      put(out_.hit_approach_speed_m_s, row, &hit.approach_speed, 1);
      put(out_.hit_position_m, row, hit.position, 3);
    }
    if (!out_.hit_count.empty()) out_.hit_count[i] = m.hits;
  }

  Flock<Sample>& flock_;
  std::span<const std::size_t> samples_;
  std::span<const State> states_;
  const BatchOptions& options_;
  const BatchOutputs& out_;
  std::function<void()> finished_;
  std::size_t next_ = 0;
};

}  // namespace

std::vector<std::string_view> instruction_sets() {
  std::vector<std::string_view> names;
  for (const lanes::Kernels* k : lanes::available_kernels()) names.emplace_back(k->name);
  return names;
}

void simulate_batch(std::span<const Body* const> bodies, std::span<const State> states,
                    const BatchOptions& options, const BatchOutputs& outputs, Progress* progress) {
  const lanes::Kernels& kernels = kernels_named(options.instruction_set);
  std::fill(outputs.status.begin(), outputs.status.end(), SampleStatus::not_run);
  const auto body_of = [&](std::size_t i) { return bodies[bodies.size() == 1 ? 0 : i]; };
  // Samples of one body side by side, in chunks of one body each.
  std::vector<std::size_t> order(states.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (bodies.size() > 1)
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return std::less<>()(body_of(a), body_of(b)); });
  // Small enough that every thread gets several, large enough to fill packs.
  const std::size_t chunk = std::clamp(
      order.size() / (4 * static_cast<std::size_t>(thread_count(options.threads))), kLeastChunk, kMostChunk);
  std::vector<std::span<const std::size_t>> chunks;
  for (std::size_t from = 0; from < order.size();) {
    std::size_t to = from + 1;
    while (to < order.size() && to - from < chunk && body_of(order[to]) == body_of(order[from])) ++to;
    chunks.push_back(std::span(order).subspan(from, to - from));
    from = to;
  }
  std::atomic<std::size_t> done{0};
  parallel_for(
      chunks.size(), options.threads,
      [&](std::size_t c) {
        Flock<Sample> flock(*body_of(chunks[c].front()), options.simulation, kernels);
        Recorder recorder(flock, chunks[c], states, options, outputs, [&] {
          if (progress) progress->raise_to(static_cast<double>(++done) / static_cast<double>(states.size()));
        });
        flock.run(recorder, progress);
      },
      progress);
}

}  // namespace ifa
