#include "ifa/forward/solve.hpp"

#include <chrono>
#include <cmath>
#include <optional>

#include "ifa/base/message.hpp"
#include "ifa/forward/report.hpp"

namespace ifa {
namespace {

struct Rung {
  int beam, proposals;
};
constexpr Rung kLadder[] = {{40, 3}, {120, 3}, {360, 3}, {1080, 3}, {3240, 3}};

std::vector<Material> materials_to_try(const Body& body, bool fit) {
  std::vector<Material> materials{body.material()};
  if (!fit) return materials;
  for (const double restitution : {0.6, 0.45, 0.3, 0.75}) {
    if (std::abs(restitution - body.material().restitution) < 0.05) continue;
    Material material = body.material();
    material.restitution = restitution;
    materials.push_back(material);
  }
  return materials;
}

}  // namespace

int rung_count() { return static_cast<int>(std::size(kLadder)); }

Solution solve_forward(const Body& body, const Marks& marks, const SolveOptions& options,
                       Progress* progress) {
  SearchPhysics physics;
  physics.energy_gain_j = options.energy_gain_j;
  validate(marks, physics.hearing.merge_gap_s);
  if (!(options.time_budget_s > 0.0)) throw ArgumentError("time_budget_s: must be above 0");
  if (!(options.energy_gain_j >= 0.0)) throw ArgumentError("energy_gain_j: must be 0 or more");
  if (options.rung >= rung_count())
    throw ArgumentError("rung: the last one is " + std::to_string(rung_count() - 1));

  const auto began = std::chrono::steady_clock::now();
  const auto seconds_gone = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  std::vector<Body> bodies;
  for (const Material& material : materials_to_try(body, options.fit_material))
    bodies.push_back(body.with_material(material));
  const Problem problem{bodies, physics, marks};

  std::optional<Solution> best;
  const int first = options.rung >= 0 ? options.rung : 0,
            last = options.rung >= 0 ? options.rung : rung_count() - 1;
  const double parts = last - first + 1;
  double rung_s = 0.0;
  for (int rung = first; rung <= last; ++rung) {
    // A rung costs about as much more than the last one as it is larger; if it fails early, less. One that
    // would not get a quarter done within the budget is not begun.
    const double rung_began = seconds_gone();
    if (rung > first) {
      const double more = static_cast<double>(kLadder[rung].beam * kLadder[rung].proposals) /
                          (kLadder[rung - 1].beam * kLadder[rung - 1].proposals);
      if (rung_began + 0.25 * more * rung_s > options.time_budget_s) break;
    }
    const Share share{progress, (rung - first) / parts, (rung - first + 1) / parts};
    const Beam beam = search_beam(
        problem, {kLadder[rung].beam, kLadder[rung].proposals, options.seed, options.threads}, share);
    rung_s = seconds_gone() - rung_began;
    if (beam.levels.empty()) continue;
    const Found found = best_of(beam);
    Solution own =
        make_solution(bodies[static_cast<std::size_t>(found.body)], physics, marks, found, progress);
    own.rung = rung;
    own.simulated_s = beam.simulated_s;
    if (!best || better(own, *best)) best = std::move(own);
    if (best->plausible) break;
  }
  if (progress) progress->raise_to(1.0);
  if (!best)
    throw NoMotionError("no first contact was found from which a flight could reach " +
                        mark_name(0, marks.times_s[0]));
  return *best;
}

}  // namespace ifa
