// method="forward": from marks to a motion with its report.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/forward/beam.hpp"
#include "ifa/solution/solution.hpp"

namespace ifa {

// What ends a climb; constraints have to be met with either.
enum class Goal { plausible, succeeded };

struct SolveOptions {
  std::uint64_t seed = 0;
  double time_budget_s = 10.0;  // once over, no further rung is begun
  int threads = 0;              // 0: one for each core
  bool fit_material = false;    // choose restitution and friction from the marks
  double energy_gain_j = 0.0;   // that a change may add to one impact, above the energy before it
  int rung = -1;                // run just this rung, whatever the clock says; -1: climb
  Events events = Events::audible;
  int takes = 1;           // clearly different motions, at most
  double lead_in_s = 0.5;  // of flight before the first mark, at most; less where an earlier contact comes
  // An earlier solve of this body with these options: what its marks and these have in common is gone on
  // from.
  std::shared_ptr<const KeptSearch> reuse;
  ForcedEffects forced = {};     // on or off, whatever the scene calls for
  std::vector<int> ladder = {};  // states in the beam of each rung, growing; empty: the standard ladder
  Goal goal = Goal::plausible;   // that ends the climb
  int least_rung = 0;            // which is climbed to even where a lower one reaches the goal
  Proposals proposals = {};
};

// The ladder: beams grow from rung to rung, as `standard_ladder` or as the options say. On each, the
// materials to choose from share one beam, and a mark that no plausible motion reaches may be met beyond the
// plausible region (a larger excess and more retiming, which may still succeed). The first motion from
// `least_rung` on that reaches the goal ends the climb; otherwise the best so far is returned, if need be one
// that misses marks. The clock only decides whether another rung begins, so a rung's result depends on the
// arguments alone. With `reuse`, narrow beams first go on from the last event that the marks before have in
// common; if none finds a plausible motion, the ladder is climbed as without. Throws NoMotionError,
// Cancelled, or ArgumentError.
Solution solve_forward(const Body& body, const Marks& marks, const SolveOptions& options, Progress* progress);

int rung_count();  // of the standard ladder

std::span<const int> standard_ladder();

}  // namespace ifa
