// What a solve returns: a motion, measured.
#pragma once

#include <memory>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/motion/motion.hpp"
#include "ifa/signature/factors.hpp"
#include "ifa/solution/found.hpp"
#include "ifa/solution/plan.hpp"

namespace ifa {

// There is no motion to show: no first contact was found at all. ifa.NoMotionError
class NoMotionError : public Error {
 public:
  using Error::Error;
};

struct KeptSearch;  // of the forward search, for the next one

struct EventReport {
  double target_s, achieved_s;
  double error_s;          // of the simulated interval that leads here, before retiming
  double error_retimed_s;  // of the motion
  double retime;           // the interval that leads here: in the motion over simulated
  double excess;    // of the change that leads here; of the last event also the change after it, if larger
  Factors factors;  // of the transition that leads here, and of this event's sound
};

// How a constraint was met, on the motion as it is placed: at its mark's time, or at the end.
struct ConstraintReport {
  double error;   // m of a position, rad of an orientation
  double factor;  // f_p or f_o
};

// What a solve had after one of its rungs: of the best motion so far.
struct Stage {
  double time_s;  // since the solve began; unlike all else it depends on the clock
  int rung;       // that had just been run
  double score;
  bool succeeded, plausible;
};

struct Solution {
  std::shared_ptr<const Motion> motion;
  double score = 0.0, score_without_sound = 0.0;
  bool succeeded = false, plausible = false;
  std::vector<EventReport> events;
  std::vector<ConstraintReport> constraints;  // positions, then orientations, in the order of the marks' own
  double max_abs_error_s = 0.0;
  int missed_hits = 0, extra_hits = 0;  // audible hits that no event's chain holds are extra
  double max_penetration_m = 0.0, max_energy_gain_j = 0.0;
  double simulated_s = 0.0;                  // in all, on the motion's own rung
  double restitution = 0.0, friction = 0.0;  // that the motion was made with
  int rung = 0;
  // Of the graph's search: the log weight of the path, and what no path of it exceeds (Score = exp(it / 6
  // n)).
  double search_log_weight = 0.0, search_log_bound = 0.0;
  Plan plan;
  EffectCounts effect_runs{};    // of the whole solve
  std::vector<Stage> history;    // by rung run; of the solve's own motion, not of further takes
  std::vector<Solution> others;  // further takes, best first; this motion is the one that `takes` = 1 gives
  std::shared_ptr<const KeptSearch> kept;

  bool constraints_met() const;
  double log_constraints() const;  // log of the product of their factors
  // What a search is after: no other motion need be looked for.
  bool satisfies() const { return plausible && constraints_met(); }
};

Stage stage_of(const Solution& best, int rung, double time_s);

// Simulates what was found once more, retimes it to its marks, places it on the ground as the constraints
// ask, and measures it: as far as the plan has these on. Without settling to rest, the motion ends before
// what comes after the last mark, and after kOpenTail_s at most.
Solution make_solution(const Body& body, const SearchPhysics& physics, const Marks& marks, const Plan& plan,
                       const Found& found, double lead_in_s, const Progress* progress = nullptr);

// Whether a is better: plausible, then succeeded, then fewer missed and extra hits, then the Score; with
// constraints the product of all factors, theirs included.
bool better(const Solution& a, const Solution& b);

}  // namespace ifa
