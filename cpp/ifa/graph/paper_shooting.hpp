// The paper's shooting scheme (section 5.3.2), to compare with.
#pragma once

#include "ifa/graph/turn.hpp"

namespace ifa {

// How it integrates Euler's equations.
struct PaperFlight {
  int steps = 0;  // of Runge and Kutta's fourth-order method; 0: ours, exact
};

struct PaperShooting {
  bool converged;
  Vec3 spin_rad;  // principal axes at the start
  double error_rad;
  int iterations;
};

// The momentum at the start that turns the body by `target`: Newton's method on the squared angle of the
// error, a scalar, as the paper has it: f(L + dL) ~ f(L) + J dL = 0 with the least dL in the norm of W^-1,
// the weight W = I, J by forward differences, and each step scaled so that |I^-1 dL| T < 10 degrees. f has a
// double root, so that at best the error halves in each step.
PaperShooting shoot_as_paper(const lanes::BodyView& body, const Quat& target, const Vec3& guess_rad,
                             double tolerance_rad, int most_iterations, PaperFlight flight = {});

// The paper's guess, (L_i + L_k) / 2 in world axes, as a spin in principal axes at the start: of `w0` in
// orientation `q0`, and of `w1` in `q1`, spins in principal axes.
Vec3 paper_guess(const lanes::BodyView& body, const Quat& q0, const Vec3& w0, const Quat& q1, const Vec3& w1);

}  // namespace ifa
