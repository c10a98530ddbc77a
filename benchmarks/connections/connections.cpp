// Motion connections beside the paper's scheme: how many converge, and what one costs. The problems are those
// of draw_connection_problems. Prints a table, and writes CSV, a row for each problem, to the file named.
//
// The paper's scheme runs twice: with our exact flights, and with Runge-Kutta steps of 1 ms, as the paper
// integrates (a fast needle diverges in these, and gives up at once). Both stop at 1e-3 rad, or after 200
// iterations. All three take turns at each problem, and the
// least of several rounds is its time: what else runs on the machine only adds to it.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "ifa/graph/connection.hpp"
#include "ifa/graph/connection_problems.hpp"
#include "ifa/graph/paper_shooting.hpp"
#include "ifa/rigid/views.hpp"

namespace {

using namespace ifa;

constexpr int kProblems = 2000, kSimulations = 1500, kRounds = 5;
constexpr int kPaperIterations = 200;
constexpr double kPaperTolerance_rad = 1e-3, kPaperStep_s = 1e-3;
constexpr double kPenetration_m = 1e-4;  // what `succeeded` allows (CONVENTIONS.md)

const Vec3 kGravity(0.0, 0.0, -9.81);

Body box(const char* name, const Vec3& size_m, double mass_kg) {
  Body::Definition d;
  d.name = name;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5}) d.vertices_m.push_back(size_m.cwiseProduct(Vec3(x, y, z)));
  const Vec3 squares = size_m.cwiseAbs2();
  d.inertia_kg_m2 = (mass_kg / 12.0 * (Vec3::Constant(squares.sum()) - squares)).asDiagonal();
  d.mass_kg = mass_kg;
  return Body::make(d);
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

double mean(const std::vector<double>& v) {
  double sum = 0.0;
  for (const double x : v) sum += x;
  return sum / static_cast<double>(v.size());
}

template <class F>
void time(double& least_us, F&& f) {
  const auto begin = std::chrono::steady_clock::now();
  f();
  const std::chrono::duration<double, std::micro> gone = std::chrono::steady_clock::now() - begin;
  least_us = std::min(least_us, gone.count());
}

const char* name_of(Shot outcome) {
  static constexpr const char* kNames[] = {"converged", "fold", "too fast", "stalled"};
  return kNames[static_cast<int>(outcome)];
}

void run(const Body& body, std::FILE* csv) {
  const auto problems = draw_connection_problems(body, 1, kSimulations, kProblems, kGravity);
  const Connector connector(body);
  const lanes::BodyView view = view_of(body);
  const std::size_t count = problems.size();
  std::vector<double> ours(count, 1e300), exact = ours, stepped = ours, ground = ours, iterations, theirs;
  std::vector<Connection> found(count);
  std::vector<PaperShooting> by_paper(count), by_steps(count);
  std::size_t below = 0;
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t k = 0; k < count; ++k) {
      const ConnectionProblem& p = problems[k];
      const Quat &q0 = p.from.orientation, &q1 = p.like.orientation;
      const Quat target = q0.conjugate() * p.to.orientation;
      time(ours[k], [&] { found[k] = connector.connect(p.from, p.like, p.to, p.duration_s, kGravity); });
      const auto paper = [&](PaperFlight flight) {
        const Vec3 guess = p.duration_s * paper_guess(view, q0, q0.conjugate() * p.from.angular_velocity, q1,
                                                      q1.conjugate() * p.like.angular_velocity);
        return shoot_as_paper(view, target, guess, kPaperTolerance_rad, kPaperIterations, flight);
      };
      if (round < 2) {  // it is slow
        time(exact[k], [&] { by_paper[k] = paper({}); });
        const int steps = static_cast<int>(std::ceil(p.duration_s / kPaperStep_s));
        time(stepped[k], [&] { by_steps[k] = paper({steps}); });
      }
      bool deep = false;
      time(ground[k], [&] { deep = connector.penetrates(p.from, p.flight_s, kGravity, kPenetration_m); });
      if (round == 0) below += deep;
    }
  std::size_t outcomes[4] = {}, converged = 0, converged_steps = 0;
  std::vector<double> ratio, ratio_steps;
  for (std::size_t k = 0; k < count; ++k) {
    const Shooting& s = found[k].shooting;
    ++outcomes[static_cast<int>(s.outcome)];
    converged += by_paper[k].converged;
    converged_steps += by_steps[k].converged;
    iterations.push_back(s.iterations);
    theirs.push_back(by_paper[k].iterations);
    ratio.push_back(exact[k] / ours[k]);
    ratio_steps.push_back(stepped[k] / ours[k]);
    if (csv)
      std::fprintf(csv, "%s,%zu,%.6f,%s,%.3e,%d,%.6f,%.3f,%d,%.3e,%d,%.3f,%.3f\n", body.name().c_str(), k,
                   problems[k].duration_s, name_of(s.outcome), s.error_rad, s.iterations, s.fold_at, ours[k],
                   by_paper[k].converged, by_paper[k].error_rad, by_paper[k].iterations, exact[k],
                   stepped[k]);
  }
  const double percent = 100.0 / static_cast<double>(count);
  std::printf(
      "| %s | %.2f | %.2f | %.2f | %.0f (%.1f) | %.2f (%.0f) | %.1f, %.1f | %.0f (%.1f) |"
      " %.1f (%.0f) |"
      " %.1f (%.0f) | %.0f (%.0f) | %.0f (%.0f) | %.2f (%zu) |\n",
      body.name().c_str(), static_cast<double>(outcomes[0]) * percent,
      static_cast<double>(outcomes[1]) * percent, static_cast<double>(outcomes[2] + outcomes[3]) * percent,
      median(iterations), mean(iterations), median(ours), mean(ours),
      static_cast<double>(converged) * percent, static_cast<double>(converged_steps) * percent,
      median(theirs), mean(theirs), median(exact), mean(exact), median(stepped), mean(stepped), median(ratio),
      mean(exact) / mean(ours), median(ratio_steps), mean(stepped) / mean(ours), median(ground), below);
  std::fflush(stdout);
}

}  // namespace

int main(int arguments, char** values) {
  std::FILE* csv = arguments > 1 ? std::fopen(values[1], "w") : nullptr;
  if (arguments > 1 && !csv) {
    std::fprintf(stderr, "cannot write %s\n", values[1]);
    return 2;
  }
  if (csv)
    std::fprintf(csv,
                 "body,problem,duration_s,outcome,error_rad,iterations,fold_at,us,paper_converged,"
                 "paper_error_rad,paper_iterations,paper_us,paper_1ms_us\n");
  std::printf(
      "Of %d problems, shares in %%, times in us, medians (means).\n\n"
      "| body | converged to 1e-10 rad | certified fold | neither | iterations | time |"
      " paper, 1e-3 rad: converged, by 1 ms steps | iterations | time, our flights | time, 1 ms steps |"
      " ratio, our flights | ratio, 1 ms steps | ground check, us (below) |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      kProblems);
  for (const Body& body :
       {box("d6", Vec3::Constant(0.016), 0.005), box("card", {0.0856, 0.054, 0.00076}, 0.005),
        box("needle", {0.1, 0.001, 0.001}, 0.001), box("eraser", {0.043, 0.017, 0.011}, 0.012)})
    run(body, csv);
  if (csv) std::fclose(csv);
  return 0;
}
