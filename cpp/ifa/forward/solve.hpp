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

struct KeptSearch;

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
  std::vector<Solution> others;  // further takes, best first; this motion is the one that `takes` = 1 gives
  std::shared_ptr<const KeptSearch> kept;
};

// Takes differ by at least so much: Motion difference from the first to the last mark, in bounding radii.
inline constexpr double kClearlyDifferent = 1.0;

// The ladder: beams grow from rung to rung. On each, the materials to choose from share one beam, and a mark
// that no plausible motion reaches may be met beyond the plausible region (a larger excess and more retiming,
// which may still succeed). The first plausible motion ends the climb; otherwise the best so far is returned,
// if need be one that misses marks. The clock only decides whether another rung begins, so a rung's result
// depends on the arguments alone. With `reuse`, narrow beams first go on from the last event that the marks
// before have in common; if none finds a plausible motion, the ladder is climbed as without. Throws
// NoMotionError, Cancelled, or ArgumentError.
Solution solve_forward(const Body& body, const Marks& marks, const SolveOptions& options, Progress* progress);

int rung_count();

}  // namespace ifa
