// method="forward": from marks to a motion with its report.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/forward/beam.hpp"
#include "ifa/motion/motion.hpp"

namespace ifa {

// There is no motion to show: no first contact was found at all. ifa.NoMotionError
class NoMotionError : public Error {
 public:
  using Error::Error;
};

struct SolveOptions {
  std::uint64_t seed = 0;
  double time_budget_s = 10.0;  // once over, no further rung is begun
  int threads = 0;              // 0: one for each core
  bool fit_material = false;    // try materials, else the body's own
  double energy_gain_j = 0.0;   // that a change may add to one impact, above the energy before it
  int rung = -1;                // run just this rung, whatever the clock says; -1: climb
};

struct EventReport {
  double target_s, achieved_s;
  double error_s;          // of the simulated interval that leads here, before retiming
  double error_retimed_s;  // of the motion
  double retime;           // the interval that leads here: in the motion over simulated
  double excess;    // of the change that leads here; of the last event also the change after it, if larger
  Factors factors;  // of the transition that leads here, and of this event's sound
};

struct Solution {
  std::shared_ptr<const Motion> motion;
  double score = 0.0, score_without_sound = 0.0;
  bool succeeded = false, plausible = false;
  std::vector<EventReport> events;
  double max_abs_error_s = 0.0;
  int missed_hits = 0, extra_hits = 0;  // audible hits that no event's chain holds are extra
  double max_penetration_m = 0.0, max_energy_gain_j = 0.0;
  double simulated_s = 0.0;                  // in all, on the motion's own rung
  double restitution = 0.0, friction = 0.0;  // that the motion was made with
  int rung = 0;
};

// The ladder: beams and proposals grow from rung to rung; on each, first within the plausible region, then
// beyond it (a larger excess and more retiming, which may still succeed); with fit_material, each material in
// turn. The first plausible motion ends the climb; otherwise the best so far is returned, if need be one that
// misses marks. The clock only decides whether another rung begins, so a rung's result depends on the
// arguments alone. Throws NoMotionError, Cancelled, or ArgumentError.
Solution solve_forward(const Body& body, const Marks& marks, const SolveOptions& options, Progress* progress);

int rung_count();

}  // namespace ifa
