// What the beam holds: states that have reached an event, and how they came there.
#pragma once

#include <memory>
#include <tuple>
#include <vector>

#include "ifa/signature/factors.hpp"
#include "ifa/signature/marks.hpp"
#include "ifa/signature/placement.hpp"
#include "ifa/solution/found.hpp"
#include "ifa/solution/plan.hpp"
#include "ifa/solution/standard.hpp"

namespace ifa {

// As far as the search goes where nothing plausible is found.
inline constexpr Tolerance kTolerable{4.0, 0.25};
inline constexpr double kLateShare = 1.35;  // of an interval: how long a passage is followed beyond it

inline constexpr double kUnnoticed = 0.02;  // retiming (ratio - 1): what no viewer could see

// What is to be solved, and with which bodies: they differ in their materials alone.
struct Problem {
  const std::vector<Body>& bodies;
  const SearchPhysics& physics;
  const Marks& marks;
  Plan plan = make_plan(bodies.front(), marks, {physics.hearing.events});

  // How fast a body can travel after event k and still come to rest at the last mark's end, about: what
  // friction takes in the contacts that are marked. Infinite where contact may go on in silence.
  double travel_budget_m_s(int body, std::size_t k) const;

  // Of the event that a candidate at mark k leaves: log f_a f_l f_c.
  double log_sound(const Event& event, std::size_t k, double first_amplitude) const {
    return log_product(
        sound_factors(event, marks, k, k == 0 ? event.amplitude : first_amplitude, plan.sound_terms()));
  }

  // Whether event k is to last as long as its mark.
  bool fits_length(std::size_t k) const {
    return marks.durations_s[k] > 0.0 && plan.on(Effect::length_matching);
  }

  // Whether a passage that leaves event k is watched for how the motion ends.
  bool settles_after(std::size_t k) const {
    return k + 1 == marks.size() && plan.on(Effect::settling_to_rest);
  }

  double target_s(std::size_t k) const { return marks.times_s[k + 1] - marks.times_s[k]; }
};

struct Candidate {
  Onset onset;
  int parent = -1, start = -1;  // indices at the level before, and at the first
  int body = 0;
  Leave from;                    // the parent's event
  double log_weight = 0.0;       // all factors of the events before, and of the transitions
  double first_amplitude = 0.0;  // of the first event
  double drift_s = 0.0;          // how late it is at its mark, where nothing is retimed
  int violations = 0;            // marks that were met, but not plausibly or with too low a Score
  int stretched = 0;    // marks that were met by retiming more than kUnnoticed; 0 where constraints weigh too
  Alignment alignment;  // of what the constraints have asked so far
  double log_constraints = 0.0;  // of it: the factors of the constraints
  int unmet = 0;                 // orientations that were off by more than half their factor
  double toll = 0.0;             // a guess of what the constraints of the next mark, or of rest, will cost
  double outlook = 0.0;          // a guess of the log weight to come
  // How it goes on without a change; dropped once its children are chosen.
  std::shared_ptr<const Passage> unchanged;

  // Takes in what the constraints ask of its pose at mark k.
  void constrain(const Problem& problem, std::size_t k);

  // What the constraints at rest add to the log weight where it ends with this passage: 0 or less.
  double log_rest(const Problem& problem, const Passage& passage) const;

  double rank() const { return log_weight + outlook + log_constraints; }

  // Whether it is to be preferred to `other`, whatever their ranks.
  bool sounder(const Candidate& other) const {
    return std::tuple(violations, unmet, stretched) <
           std::tuple(other.violations, other.unmet, other.stretched);
  }
};

}  // namespace ifa
