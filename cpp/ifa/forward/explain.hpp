// Why marks cannot be met as asked, and the cheapest changes with which they can, each of them tried.
#pragma once

#include <vector>

#include "ifa/forward/conflicts.hpp"
#include "ifa/forward/repairs.hpp"
#include "ifa/forward/solve.hpp"

namespace ifa {

// A change with which a solve at `rung` succeeds.
struct Repair {
  RepairKind kind;
  std::size_t mark;  // of shift, drop, energy and ending
  double amount;
  double cost;
  std::string text;
  bool plausible;
  double score;
  Request request;  // to be solved
  int rung;         // that reproduces it
};

struct Explanation {
  bool succeeded, plausible;  // as asked, without a repair
  std::vector<Conflict> conflicts;
  std::vector<Repair> repairs;  // plausible ones first, then by cost
  int trials;                   // solves of repairs
  bool complete;                // false where the time budget ended the trials
};

// `options` as for solve_forward; its rung is of no account. `known` may be null: then rungs 0 to 2 say how
// well the marks can be met. The clock only decides whether another trial (or rung) begins. Throws Cancelled,
// or ArgumentError.
Explanation explain(const Body& body, const Marks& marks, const SolveOptions& options, double merge_gap_s,
                    const Solution* known, Progress* progress);

}  // namespace ifa
