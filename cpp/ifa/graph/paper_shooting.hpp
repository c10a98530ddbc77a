// The paper's shooting scheme (section 5.3.2), to compare with.
#pragma once

#include "ifa/graph/shooting.hpp"

namespace ifa {

// The momentum at the start that turns the body by `target`: Newton's method on the squared angle of the
// error, a scalar, as the paper has it: f(L + dL) ~ f(L) + J dL = 0 with the least dL in the norm of W^-1, the
// weight W = I, J by forward differences, and each step scaled so that |I^-1 dL| T < 10 degrees. Its flights
// are ours, exact; the paper integrates them in steps. f has a double root, so that at best the error halves
// in each step.
struct PaperShooting {
  bool converged;
  Vec3 spin_rad;  // principal axes at the start
  double error_rad;
  int iterations;
};
PaperShooting shoot_as_paper(const lanes::BodyView& body, const Quat& target, const Vec3& guess_rad,
                             double tolerance_rad, int most_iterations);

// The paper's guess, (L_i + L_k) / 2 in world axes, as a spin in principal axes at the start. `q0` and `q1`
// are the orientations in which the spins `w0` and `w1` (principal axes) are had.
Vec3 paper_guess(const lanes::BodyView& body, const Quat& q0, const Vec3& w0, const Quat& q1,
                 const Vec3& w1);

}  // namespace ifa
