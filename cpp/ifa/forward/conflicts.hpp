// Which marks a motion does not meet as it should, and why.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "ifa/forward/estimate.hpp"
#include "ifa/forward/solve.hpp"

namespace ifa {

enum class ConflictKind {
  missed,       // no motion got there
  implausible,  // an impact is changed beyond the plausible region (excess above 1)
  retimed,      // the gap before it is retimed by more than 7 %
  unrest,       // the last mark: the body does not come to rest after it without a further hit
  sound,        // all marks are met, but the Score is too low, and this mark lowers it most
  penetration   // all is well but that the body sinks into the ground
};
std::string_view name_of(ConflictKind kind);

struct Conflict {
  std::size_t mark;  // index from 0
  ConflictKind kind;
  std::string text;     // without the mark's name
  std::string finding;  // what the estimate says about the mark, with its first conflict only; or empty
};

// In the order of the marks, of a solve's best motion; empty if that is plausible. `solution` may be null: no
// first contact was found. Of marks without a hit only the first is a conflict: the search ended before the
// others.
std::vector<Conflict> conflicts_of(const Marks& marks, const Estimate& estimate, const Solution* solution);

}  // namespace ifa
