#include "ifa/solution/plan.hpp"

#include <algorithm>
#include <cmath>

#include "ifa/base/error.hpp"
#include "ifa/base/message.hpp"
#include "ifa/solution/passage.hpp"

namespace ifa {
namespace {

std::string name_of(Effect effect) { return std::string(kEffectNames[index_of(effect)]); }

// Decides effect after effect: what the scene calls for, unless it is forced.
class Planner {
 public:
  Planner(const Body& body, const Marks& marks, const PlanOptions& options)
      : body_(body), marks_(marks), options_(options), ball_(is_ball(body)) {}

  Plan plan() {
    of_the_body();
    of_the_ending();
    of_the_sound();
    of_the_poses();
    decide(Effect::sustained_contact, contact_can_matter(), contact_reason());
    decide(Effect::pre_roll_flight, true, "lead_in_s is " + number(options_.lead_in_s));
    const bool intervals = marks_.size() > 1;
    decide(Effect::retiming, intervals,
           intervals ? "every interval is brought to its marks" : "a single mark has no interval");
    decide(Effect::material_fit, options_.fit_material,
           options_.fit_material ? "the material is to be fitted" : "the material is given");
    check_sense();
    return std::move(plan_);
  }

 private:
  void decide(Effect effect, bool called_for, std::string because) {
    PlannedEffect& planned = plan_[effect];
    const std::optional<bool>& forced = options_.forced[index_of(effect)];
    planned = {forced.value_or(called_for), forced.has_value(), std::move(because)};
    called_for_[index_of(effect)] = called_for;
  }

  void of_the_body() {
    const EngineEffects needed = needed_effects(body_);
    const std::string body = ball_ ? "the body is a ball: " : "";
    decide(Effect::spin_coupling, needed.spin_coupling,
           body + (needed.spin_coupling ? "the body's moments differ" : "its moments are equal"));
    decide(Effect::friction, needed.friction,
           needed.friction ? "the material has friction" : "the material has no friction");
    decide(Effect::rounding, needed.rounding,
           needed.rounding ? "the hull is rounded by " + number(1e3 * body_.radius_m()) + " mm"
                           : "the hull is not rounded");
    decide(Effect::circular_edges, needed.circular_edges,
           needed.circular_edges ? "the hull has circular edges" : "the hull has no circular edges");
  }

  void of_the_ending() {
    const bool rest = marks_.ending == Ending::rest;
    decide(Effect::settling_to_rest, rest,
           rest ? "the body shall come to rest after the last mark" : "the ending is open");
  }

  void of_the_sound() {
    const std::size_t n = marks_.size();
    const bool heard = !marks_.amplitudes.empty();
    decide(Effect::amplitude_matching, heard && n > 1,
           !heard   ? "the marks have no amplitudes"
           : n == 1 ? "a single mark has no other to be louder than"
                    : "the marks have amplitudes");
    std::size_t spans = 0, centred = 0;
    for (std::size_t k = 0; k < n; ++k) {
      if (!(marks_.durations_s[k] > 0.0)) continue;
      ++spans;
      if (!std::isnan(marks_.centroids_s[k])) ++centred;
    }
    const auto of_marks = [&](std::size_t count, const std::string& what) {
      if (count == 0) return "no mark has a " + what;
      return number(static_cast<double>(count)) + " of " + number(static_cast<double>(n)) +
             (n == 1 ? " mark has a " : " marks have a ") + what;
    };
    decide(Effect::length_matching, spans > 0, of_marks(spans, "duration"));
    decide(Effect::centroid_matching, centred > 0, of_marks(centred, "centroid"));
  }

  void of_the_poses() {
    const bool settles = plan_.on(Effect::settling_to_rest);
    const auto asked =
        std::ranges::count_if(marks_.constraints.orientations,
                              [&](const OrientationConstraint& c) { return settles || c.mark != kAtRest; });
    const auto of_marks = [](auto count, const std::string& what) {
      return count == 0   ? "no " + what + " is asked for"
             : count == 1 ? "an " + what + " is asked for"
                          : number(static_cast<double>(count)) + " " + what + "s are asked for";
    };
    decide(Effect::orientation_constraints, asked > 0, of_marks(asked, "orientation"));
    const std::size_t places = marks_.constraints.positions.size();
    decide(Effect::position_constraints, places > 0,
           places == 1 ? "a position is asked for" : of_marks(places, "position"));
  }

  bool open() const { return !plan_.on(Effect::settling_to_rest); }

  bool discrete() const {
    return std::ranges::all_of(marks_.durations_s, [](double d) { return d == 0.0; });
  }

  bool contact_can_matter() const {
    return options_.graph || options_.events == Events::contact || !open() || !discrete() ||
           !(ball_ || marks_.size() == 1);
  }

  std::string contact_reason() const {
    if (options_.graph) return "the database was simulated with it";
    if (options_.events == Events::contact) return "contact makes the events";
    if (!open()) return "the body comes to rest in it";
    if (!discrete()) return "a mark has a duration";
    if (!ball_ && marks_.size() > 1) return "the body may rock, slide or roll from mark to mark";
    if (ball_)
      return "the body is a ball: it never leaves the ground that it stays on, and the ending is open";
    return "nothing is asked after the only mark";
  }

  // What cannot be forced so.
  void check_sense() const {
    const auto refuse = [](Effect effect, const std::string& why) {
      throw ArgumentError(name_of(effect) + ": " + why);
    };
    const auto forced = [&](Effect effect, bool to) { return options_.forced[index_of(effect)] == to; };
    if (options_.graph) {
      for (const Effect e : {Effect::spin_coupling, Effect::friction, Effect::sustained_contact,
                             Effect::rounding, Effect::circular_edges})
        if (options_.forced[index_of(e)].value_or(called_for_[index_of(e)]) != called_for_[index_of(e)])
          refuse(e,
                 "cannot be forced with method=\"graph\": the database was simulated as its body calls for");
      if (plan_.on(Effect::material_fit))
        refuse(Effect::material_fit, "cannot be on with method=\"graph\": the database has one material");
      if (forced(Effect::retiming, false))
        refuse(Effect::retiming, "cannot be off with method=\"graph\": its motions meet the marks by it");
    }
    if (forced(Effect::sustained_contact, false) && plan_.on(Effect::settling_to_rest))
      refuse(Effect::sustained_contact, "cannot be off where the body comes to rest: that is contact");
    if (forced(Effect::sustained_contact, false) && options_.events == Events::contact)
      refuse(Effect::sustained_contact, "cannot be off with events=\"contact\"");
    if (forced(Effect::rounding, false) || forced(Effect::circular_edges, false))
      with_effects(body_, plan_.engine_effects());  // throws where nothing solid is left
  }

  const Body& body_;
  const Marks& marks_;
  const PlanOptions& options_;
  bool ball_;
  Plan plan_;
  std::array<bool, kEffects> called_for_{};
};

}  // namespace

Marks Plan::seen(Marks marks) const {
  if (!on(Effect::amplitude_matching)) marks.amplitudes.clear();
  if (!on(Effect::centroid_matching)) std::ranges::fill(marks.centroids_s, std::nan(""));
  if (!on(Effect::orientation_constraints)) marks.constraints.orientations.clear();
  if (!on(Effect::position_constraints)) marks.constraints.positions.clear();
  if (!on(Effect::settling_to_rest)) {
    marks.ending = Ending::open;
    marks.constraints.forget_rest();
  }
  return marks;
}

void Plan::apply(HearingOptions& hearing) const {
  hearing.amplitudes = on(Effect::amplitude_matching);
  hearing.lengths = on(Effect::length_matching);
  hearing.centroids = on(Effect::centroid_matching);
}

SoundTerms Plan::sound_terms() const {
  return {on(Effect::amplitude_matching), on(Effect::length_matching), on(Effect::centroid_matching)};
}

EngineEffects Plan::engine_effects() const {
  return {on(Effect::spin_coupling), on(Effect::friction), on(Effect::rounding), on(Effect::circular_edges)};
}

bool Plan::same_forced(const Plan& other) const {
  return std::ranges::equal(effects_, other.effects_, [](const PlannedEffect& a, const PlannedEffect& b) {
    return a.forced == b.forced && (!a.forced || a.on == b.on);
  });
}

Effect effect_named(std::string_view name) {
  const auto found = std::ranges::find(kEffectNames, name);
  if (found == kEffectNames.end()) {
    std::string all;
    for (const std::string_view n : kEffectNames) all += (all.empty() ? "" : ", ") + std::string(n);
    throw ArgumentError("effects: there is no \"" + std::string(name) + "\"; there are " + all);
  }
  return static_cast<Effect>(found - kEffectNames.begin());
}

Plan make_plan(const Body& body, const Marks& marks, const PlanOptions& options) {
  return Planner(body, marks, options).plan();
}

}  // namespace ifa
