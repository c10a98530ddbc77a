#include "ifa/forward/transition.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/rigid/views.hpp"

namespace ifa {
namespace {

constexpr int kMostImpacts = 60;  // in one passage

}  // namespace

Onset Runner::strike(const State& before) {
  Onset onset;
  onset.before = before;
  simulation_.start(before, 0.0);
  onset.hit = simulation_.resolve();
  onset.after = simulation_.state();
  return onset;
}

bool Runner::settle(State& state) {
  lanes::BodyView dull = view_of(body_);
  dull.restitution = 0.0;
  const lanes::Settings settings = settings_of(body_, physics_.simulation);
  lanes::Sim sim = begin_sim(dull, settings, state, 0.0);
  if (lanes::kScalarKernels.separation_speed(dull, sim) >= -1e-9) return false;
  lanes::Sim* const sims[1] = {&sim};
  lanes::HitData hit;
  lanes::kScalarKernels.resolve(dull, settings, sims, 1, &hit);
  state = state_of(sim);
  return true;
}

Passage Runner::pass(const Onset& onset, const State& after, double span_s, double limit_s, Record* record) {
  const HearingOptions& hearing = physics_.hearing;
  EventBuilder event(hearing, span_s);
  Hit first = onset.hit;
  first.time_s = 0.0;
  event.begin(first);

  loads_.clear();
  simulation_.start(after, 0.0, record ? &record->nodes : nullptr, span_s > 0.0 ? &loads_ : nullptr);
  Passage passage;
  bool dubious = false;
  for (int impacts = 0;; ++impacts) {
    const auto stop = simulation_.advance(limit_s);
    for (const Load& load : loads_) event.add(load);
    loads_.clear();
    passage.interval_s = simulation_.time_s();
    if (stop == EventSimulation::Stop::rest) {
      passage.next = Next::rest;
      passage.rest_s = simulation_.rest_s();
      break;
    }
    if (stop == EventSimulation::Stop::time_limit) {
      passage.next = Next::late;
      break;
    }
    if (impacts >= kMostImpacts) {  // chatter: no viewer could follow it, and each costs time
      dubious = true;
      passage.next = Next::hit;
      break;
    }
    const double speed = simulation_.approach_speed();
    dubious |= std::abs(speed / hearing.audible_speed_m_s - 1.0) < physics_.margin;
    if (speed >= hearing.audible_speed_m_s) {
      const double gap = simulation_.time_s() - event.last_s();
      if (!event.chains(simulation_.time_s())) {
        dubious |= gap < hearing.merge_gap_s * (1.0 + physics_.margin);
        passage.next = Next::hit;
        break;
      }
      dubious |= gap > hearing.merge_gap_s * (1.0 - physics_.margin) && span_s == 0.0;
      const Hit hit = simulation_.resolve();
      event.add(hit);
      if (record) record->hits.push_back(hit);
    } else {
      const Hit hit = simulation_.resolve();
      if (record) record->hits.push_back(hit);
    }
  }
  simulated_s_ += passage.interval_s;
  passage.before = simulation_.state();
  passage.event = event.event();
  if (dubious && passage.next != Next::late) passage.next = Next::dubious;
  return passage;
}

}  // namespace ifa
