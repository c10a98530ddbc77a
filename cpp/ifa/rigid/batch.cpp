#include "ifa/rigid/batch.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <numeric>
#include <string>
#include <utility>

#include "ifa/base/parallel.hpp"
#include "ifa/rigid/kernels.hpp"
#include "ifa/rigid/views.hpp"

namespace ifa {
namespace {

constexpr std::size_t kLeastChunk = 16, kMostChunk = 512;  // samples a thread takes at once
constexpr int kInFlight = 96;  // of these, under way at once: enough to fill packs of one kind

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

// Simulations of one body, advanced side by side. Those that need the same step next wait in one queue, by
// the number of points that touch, so that the lanes of a pack have alike work. What a simulation yields does
// not depend on its company.
class Flock {
 public:
  Flock(const Body& body, const lanes::Kernels& kernels, const BatchOptions& options, const BatchOutputs& out)
      : kernels_(kernels),
        body_(view_of(body)),
        settings_(settings_of(body, options.simulation)),
        options_(options),
        out_(out) {
    for (int i = kInFlight - 1; i >= 0; --i) idle_.push_back(&members_[i]);
  }

  // `finished` is called once for each sample.
  void run(std::span<const std::size_t> samples, std::span<const State> states, Progress* progress,
           const std::function<void()>& finished) {
    finished_ = finished;
    std::size_t next = 0;
    for (;;) {
      if (progress) progress->throw_if_cancelled();
      while (!idle_.empty() && next < samples.size()) {
        begin(samples[next], states[samples[next]]);
        ++next;
      }
      auto& fullest = *std::max_element(queues_.begin(), queues_.end(),
                                        [](const auto& a, const auto& b) { return a.size() < b.size(); });
      if (fullest.empty()) return;
      advance(fullest, static_cast<int>(&fullest - queues_.data()));
    }
  }

 private:
  struct Member : lanes::Sim {
    std::size_t sample;
    int hits;                                             // all of them
    std::vector<std::pair<double, lanes::HitData>> kept;  // as many as there is room for, with their times
  };
  static constexpr int kFly = 0, kResolve = 1, kStep = 5, kQueues = 9;  // four each, by touching points
  static constexpr int kWidest = 8;

  void begin(std::size_t sample, const State& state) {
    Member& m = *idle_.back();
    idle_.pop_back();
    static_cast<lanes::Sim&>(m) = begin_sim(body_, settings_, state, 0.0);
    m.until_s = options_.until_s;
    m.sample = sample;
    m.hits = 0;
    m.kept.clear();
    if (lanes::kScalarKernels.separation_speed(body_, m) < 0.0)
      queues_[kResolve].push_back(&m);
    else
      wait(m);
  }

  static int rank(const Member& m) { return std::clamp(m.touching, 1, 4) - 1; }

  void wait(Member& m) { queues_[m.stage == lanes::Stage::flight ? kFly : kStep + rank(m)].push_back(&m); }

  void advance(std::vector<Member*>& queue, int kind) {
    std::array<Member*, kWidest> members;
    std::array<lanes::Sim*, kWidest> sims;
    std::array<lanes::Stop, kWidest> stops{};
    const int count = std::min<int>(kernels_.width, static_cast<int>(queue.size()));
    for (int i = 0; i < count; ++i) {
      sims[i] = members[i] = queue.back();
      queue.pop_back();
    }
    if (kind >= kResolve && kind < kStep) {
      std::array<lanes::HitData, kWidest> hits;
      kernels_.resolve(body_, settings_, sims.data(), count, hits.data());
      for (int i = 0; i < count; ++i) {
        record(*members[i], hits[i]);
        if (members[i]->hits < options_.simulation.max_impacts)
          wait(*members[i]);
        else
          finish(*members[i], SampleStatus::impact_limit);
      }
      return;
    }
    if (kind == kFly)
      kernels_.fly(body_, settings_, sims.data(), count, stops.data());
    else
      kernels_.step(body_, settings_, sims.data(), count, stops.data(), nullptr);
    for (int i = 0; i < count; ++i) {
      switch (stops[i]) {
        case lanes::Stop::none:
          wait(*members[i]);
          break;
        case lanes::Stop::impact:
          queues_[kResolve + rank(*members[i])].push_back(members[i]);
          break;
        case lanes::Stop::rest:
          finish(*members[i], SampleStatus::rest);
          break;
        case lanes::Stop::time_limit:
          finish(*members[i], SampleStatus::time_limit);
          break;
      }
    }
  }

  void record(Member& m, const lanes::HitData& hit) {
    if (static_cast<std::size_t>(m.hits++) < out_.hits_per_sample) m.kept.push_back({m.time_s, hit});
  }

  // A sample is written once it is whole: one that is cancelled leaves its rows as they were.
  void finish(Member& m, SampleStatus status) {
    const std::size_t i = m.sample;
    const State end = state_of(m);
    if (!is_finite(end)) {
      if (!out_.status.empty()) out_.status[i] = SampleStatus::failed;
      idle_.push_back(&m);
      finished_();
      return;
    }
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
    if (!out_.status.empty()) out_.status[i] = status;
    idle_.push_back(&m);
    finished_();
  }

  const lanes::Kernels& kernels_;
  lanes::BodyView body_;
  lanes::Settings settings_;
  const BatchOptions& options_;
  const BatchOutputs& out_;
  std::function<void()> finished_;
  std::array<Member, kInFlight> members_;
  std::vector<Member*> idle_;
  std::array<std::vector<Member*>, kQueues> queues_;
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
        Flock(*body_of(chunks[c].front()), kernels, options, outputs).run(chunks[c], states, progress, [&] {
          if (progress) progress->raise_to(static_cast<double>(++done) / static_cast<double>(states.size()));
        });
      },
      progress);
}

}  // namespace ifa
