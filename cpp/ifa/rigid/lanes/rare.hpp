// What is rare enough to be done one simulation at a time, the same for all widths.
#pragma once

namespace ifa::lanes {

// One point's Coulomb problem by looking in all directions: of the roots that slip along their direction, the
// one that dissipates most; where there is none, it jams (Painleve): the normal impulse alone, friction
// opposing the free slip, inside the cone. `response` is xx xy xz yy yz zz.
void solve_hard_point(const double response[6], const double free[3], double target, double friction,
                      double impulse[3]);

// Whether the centre is over the points at `xy` (x y of each): seen from above they leave no gap of more than
// half a turn (and 1e-3 rad) around it, or one lies within `near` of it, or it is within `rolling_m` of the line
// between two, where rolling friction holds it. A body that balances on an edge for a moment is not at rest.
bool supports(const double* xy, int points, double near, double rolling_m);

}  // namespace ifa::lanes
