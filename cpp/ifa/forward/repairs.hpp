// What could be changed so that marks can be met: proposals, not yet tried.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "ifa/forward/conflicts.hpp"
#include "ifa/forward/estimate.hpp"

namespace ifa {

enum class RepairKind { shift, drop, energy, restitution, friction, ending };
std::string_view name_of(RepairKind kind);

// What a solve is given, whole: the request as it stands, or with one change.
struct Request {
  Body body;
  Marks marks;
  double energy_gain_j;
  bool fit_material;
};

// One thing that can be changed, more or less. A size counts steps of the smallest change worth telling
// apart: 1 ms of a shift, 0.01 of a material's number, a tenth more energy.
struct Line {
  RepairKind kind;
  std::size_t mark;        // of shift, drop and ending; of energy, where it leads to
  int sign;                // which way; of no account for drop, energy and ending
  double least_j, unit_j;  // of energy: the smallest gain, and what one unit of cost stands for
  std::vector<int> sizes;  // to be tried in turn, growing
};

// The lines for these conflicts, in the order of their marks: shift and drop each conflicting mark and its
// neighbours; energy where a mark is missed or strained; restitution and friction unless they are fitted
// anyway; an open ending where it is the rest that fails. Every size of a line gives a valid request, with
// marks at least `merge_gap_s` apart.
std::vector<Line> lines_for(const Request& request, const std::vector<Conflict>& conflicts,
                            const Estimate& estimate, double merge_gap_s);

Request changed(const Request& request, const Line& line, int size);

// How much a viewer or listener is asked to put up with: 1 is a mark that is shifted by 7 % of the shorter
// gap beside it (what retiming could hide), as much energy as makes the bounce before the conflict last 7 %
// longer (1.07^2 - 1 of its energy), or 0.1 of restitution or friction. A dropped mark and an open ending
// cost 5.
double cost(const Request& request, const Line& line, int size);

// The change in its own unit: s, J, "mark", or a plain number.
double amount(const Request& request, const Line& line, int size);
std::string_view unit_of(RepairKind kind);

std::string text_of(const Request& request, const Line& line, int size);

}  // namespace ifa
