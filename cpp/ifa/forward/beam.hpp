// The forward search: a beam of states that have all reached event k (design after the paper's section 5.1
// and 5.4; no database). Each state's impact is changed within the plausible region so that the next audible
// hit comes exactly when the next mark asks for it; the best states go on.
#pragma once

#include <cstdint>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/forward/transition.hpp"
#include "ifa/signature/marks.hpp"

namespace ifa {

inline constexpr double kLongestRest_s = 30.0;  // a body that has not come to rest by then is given up
inline constexpr double kOpenTail_s = 0.5;      // how long a motion with an open ending goes on at most

struct BeamOptions {
  int beam = 300;                // states kept at each event
  int proposals = 4;             // changes tried for each state
  double largest_excess = 1.0;   // |C v_eval|^2 of a change, at most
  double largest_retime = 0.07;  // ratio - 1, at most
  std::uint64_t seed = 0;
  int threads = 0;
};

// One event of a found motion.
struct Link {
  Onset onset;
  State after;              // the onset's outcome with its change
  double excess = 0.0;      // of that change
  double interval_s = 0.0;  // to the next event, simulated
};

struct Found {
  std::vector<Link>
      links;  // of the marks that were reached, from the first; empty if there was nothing to begin with
  double log_weight = 0.0;
  std::size_t reached = 0;  // marks
  bool complete = false;    // all of them, and the ending as asked
};

// `simulated_s` is raised by the time that was simulated.
Found search_beam(const Body& body, const SearchPhysics& physics, const Marks& marks,
                  const BeamOptions& options, Progress* progress, double progress_from, double progress_to,
                  double& simulated_s);

}  // namespace ifa
