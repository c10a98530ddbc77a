// Many simulations of one body, advanced side by side in the lanes of the kernels.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/rigid/kernels.hpp"
#include "ifa/rigid/views.hpp"

namespace ifa {

// Simulations that need the same step next wait in one queue, by the number of points that touch, so that the
// lanes of a pack have alike work. What a simulation yields does not depend on its company.
//
// `Member` derives from lanes::Sim and holds what the client keeps for one simulation. The client says
// whether points that approach at the start strike there (kStrikesAtStart), whether it wants loads
// (kWantsLoads), and has
//
//   bool begin(Member&)                            fills in the next simulation; false: there is none left
//   void impact(Member&)                           at an impact, before it is resolved
//   bool resolved(Member&, const lanes::HitData&)  after; false ends the simulation
//   bool loaded(Member&, const lanes::LoadData&)   after a step of contact; false ends the simulation
//
//   void ended(Member&, lanes::Stop)               at rest, at until_s, or in contact where that is off
template <class Member>
class Flock {
 public:
  Flock(const Body& body, const SimulationOptions& options, const lanes::Kernels& kernels)
      : kernels_(kernels), body_(view_of(body)), settings_(settings_of(body, options)) {
    for (int i = kInFlight - 1; i >= 0; --i) idle_.push_back(&members_[i]);
  }

  Flock(const Flock&) = delete;  // the queues point into it
  Flock& operator=(const Flock&) = delete;

  const lanes::BodyView& body() const { return body_; }
  const lanes::Settings& settings() const { return settings_; }

  // Until the client has no more and all have ended. `progress` may be null; Cancelled leaves the flock unfit
  // for further use.
  template <class Client>
  void run(Client& client, const Progress* progress) {
    bool more = true;
    for (;;) {
      if (progress) progress->throw_if_cancelled();
      while (more && !idle_.empty()) {
        Member& m = *idle_.back();
        more = client.begin(m);
        if (!more) break;
        idle_.pop_back();
        if (Client::kStrikesAtStart && lanes::kScalarKernels.separation_speed(body_, m) < 0.0)
          queues_[kResolve].push_back(&m);
        else
          wait(client, m);
      }
      auto& fullest = *std::max_element(queues_.begin(), queues_.end(),
                                        [](const auto& a, const auto& b) { return a.size() < b.size(); });
      if (fullest.empty()) return;
      advance(client, fullest, static_cast<int>(&fullest - queues_.data()));
    }
  }

 private:
  static constexpr int kInFlight = 96;  // under way at once: enough to fill packs of one kind
  static constexpr int kFly = 0, kResolve = 1, kStep = 5, kQueues = 9;  // four each, by touching points
  static constexpr int kWidest = 8;

  static int rank(const Member& m) { return std::clamp(m.touching, 1, 4) - 1; }

  template <class Client>
  void wait(Client& client, Member& m) {
    if (m.stage == lanes::Stage::flight) {
      queues_[kFly].push_back(&m);
    } else if (settings_.sustained_contact) {
      queues_[kStep + rank(m)].push_back(&m);
    } else {
      client.ended(m, lanes::Stop::contact);
      idle_.push_back(&m);
    }
  }

  template <class Client>
  void advance(Client& client, std::vector<Member*>& queue, int kind) {
    std::array<Member*, kWidest> members{};
    std::array<lanes::Sim*, kWidest> sims{};
    std::array<lanes::Stop, kWidest> stops{};
    std::array<bool, kWidest> over{};
    const int count = std::min<int>(kernels_.width, static_cast<int>(queue.size()));
    for (int i = 0; i < count; ++i) {
      sims[i] = members[i] = queue.back();
      queue.pop_back();
    }
    if (kind >= kResolve && kind < kStep) {
      for (int i = 0; i < count; ++i) client.impact(*members[i]);
      std::array<lanes::HitData, kWidest> hits;
      kernels_.resolve(body_, settings_, sims.data(), count, hits.data());
      for (int i = 0; i < count; ++i) {
        if (client.resolved(*members[i], hits[i]))
          wait(client, *members[i]);
        else
          idle_.push_back(members[i]);
      }
      return;
    }
    if (kind == kFly) {
      kernels_.fly(body_, settings_, sims.data(), count, stops.data());
    } else {
      std::array<lanes::LoadData, kWidest> loads{};
      std::array<double, kWidest> before_s;
      for (int i = 0; i < count; ++i) before_s[i] = sims[i]->time_s;
      kernels_.step(body_, settings_, sims.data(), count, stops.data(),
                    Client::kWantsLoads ? loads.data() : nullptr);
      if constexpr (Client::kWantsLoads)
        for (int i = 0; i < count; ++i)
          if (sims[i]->time_s > before_s[i]) over[i] = !client.loaded(*members[i], loads[i]);
    }
    for (int i = 0; i < count; ++i) {
      if (over[i]) {
        idle_.push_back(members[i]);
      } else if (stops[i] == lanes::Stop::none) {
        wait(client, *members[i]);
      } else if (stops[i] == lanes::Stop::impact) {
        queues_[kResolve + rank(*members[i])].push_back(members[i]);
      } else {
        client.ended(*members[i], stops[i]);
        idle_.push_back(members[i]);
      }
    }
  }

  const lanes::Kernels& kernels_;
  lanes::BodyView body_;
  lanes::Settings settings_;
  std::array<Member, kInFlight> members_;
  std::vector<Member*> idle_;
  std::array<std::vector<Member*>, kQueues> queues_;
};

}  // namespace ifa
