// Which effects a solve simulates and judges: what marks, body and options call for, and what is forced.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ifa/base/counted.hpp"
#include "ifa/rigid/body.hpp"
#include "ifa/rigid/effects.hpp"
#include "ifa/rigid/event_engine.hpp"
#include "ifa/signature/events.hpp"
#include "ifa/signature/factors.hpp"
#include "ifa/signature/marks.hpp"

namespace ifa {

struct PlannedEffect {
  bool on = true, forced = false;
  std::string because;  // a clause
};

using ForcedEffects = std::array<std::optional<bool>, kEffects>;  // by Effect

struct PlanOptions {
  Events events = Events::audible;
  bool fit_material = false;
  double lead_in_s = 0.5;
  bool graph = false;  // method="graph"
  ForcedEffects forced = {};
};

class Plan {
 public:
  const PlannedEffect& operator[](Effect e) const { return effects_[index_of(e)]; }
  PlannedEffect& operator[](Effect e) { return effects_[index_of(e)]; }
  bool on(Effect e) const { return (*this)[e].on; }

  bool constrains() const { return on(Effect::orientation_constraints) || on(Effect::position_constraints); }

  // What is seen of the marks: without the amplitudes, centroids and constraints that are left out, and with
  // an open ending where settling to rest is.
  Marks seen(Marks marks) const;

  // Of events: what is measured; of marks: which factors are judged.
  void apply(HearingOptions& hearing) const;
  SoundTerms sound_terms() const;

  EngineEffects engine_effects() const;

  // Whether both have the same effects forced on and off.
  bool same_forced(const Plan& other) const;

 private:
  std::array<PlannedEffect, kEffects> effects_;
};

// Throws ArgumentError where there is no effect of that name.
Effect effect_named(std::string_view name);

// Takes microseconds (forcing the hull's off takes a new hull). Throws ArgumentError naming an effect that
// cannot be forced so.
Plan make_plan(const Body& body, const Marks& marks, const PlanOptions& options);

}  // namespace ifa
