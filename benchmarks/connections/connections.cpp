// Motion connections beside the paper's scheme: how many converge, and what one costs. Random pairs of states
// within the paper's cut-off, log f_v > -10 and log f_q > -10: the take-off of a simulated node, and that of
// another motion, which is the first one changed at random within the cut-off and whose flight leads to the
// target. Prints a table and writes CSV to the file named.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "ifa/base/random.hpp"
#include "ifa/graph/connection.hpp"
#include "ifa/graph/harvest.hpp"
#include "ifa/graph/paper_shooting.hpp"
#include "ifa/rigid/flight.hpp"
#include "ifa/rigid/views.hpp"
#include "ifa/signature/factors.hpp"

namespace {

using namespace ifa;

constexpr int kProblems = 2000, kRounds = 1;
constexpr int kPaperIterations = 200;  // then it is given up
constexpr double kPaperTolerance_rad = 1e-3, kLogCutOff = -10.0;

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

struct Problem {
  State from, like, to;
  double duration_s;
};

// Eq. 4: the largest tilt between the two.
double most_tilt_rad(double duration_s) {
  constexpr double kWeight = 0.85, kScale_s = 0.2;
  return std::sqrt(-kLogCutOff / kWeight) * std::min(duration_s, kScale_s);
}

std::vector<Problem> problems_of(const Body& body) {
  const NodeColumns columns = harvest(body, {}, {}, 1, 0, 1500, 30.0);
  const Nodes nodes = view_of(columns);
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (nodes.flight_s[i] > 0.0f && nodes.delay_s[i] == 0.0f) usable.push_back(i);
  std::vector<Problem> problems;
  Flight flight(body);
  for (int k = 0; k < kProblems; ++k) {
    RandomStream random(2, static_cast<std::uint64_t>(k));
    const std::size_t i = usable[static_cast<std::size_t>(random.uniform() * double(usable.size()))];
    Problem p;
    p.from = onset_of(nodes, i);
    p.duration_s = random.uniform(0.02, 0.5);
    const float* change = nodes.change.data() + 6 * i;
    const Quat& q = p.from.orientation;
    const PlausibleRegion region(q * Vec3(change[0], change[1], change[2]),
                                 q * Vec3(change[3], change[4], change[5]), body.bounding_radius_m());
    // Registration leaves no yaw: the axis of the tilt is level.
    const double heading = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double tilt = random.uniform(0.0, most_tilt_rad(p.duration_s));
    p.like = p.from;
    p.like.orientation =
        rotation_exp(tilt * Vec3(std::cos(heading), std::sin(heading), 0.0)) * p.from.orientation;
    Vec6 y;  // uniform in the 6-ball of the cut-off
    for (double& v : y) v = random.normal();
    y *= std::sqrt(-kLogCutOff) * std::pow(random.uniform(), 1.0 / 6.0) / y.norm();
    p.like.velocity += region.velocity_offset(y);
    p.like.angular_velocity += region.spin_offset(y);
    flight.start(p.like, kGravity);
    p.to = flight.at(p.duration_s);
    problems.push_back(p);
  }
  return problems;
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

double mean(const std::vector<double>& v) {
  double sum = 0.0;
  for (const double x : v) sum += x;
  return sum / double(v.size());
}

template <class F>
double microseconds(F&& f) {
  const auto begin = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

int main(int, char**) {
  for (const Body& body : {box("d6", Vec3::Constant(0.016), 0.005), box("card", {0.0856, 0.054, 0.00076}, 0.005),
                           box("needle", {0.1, 0.001, 0.001}, 0.001), box("eraser", {0.043, 0.017, 0.01}, 0.01)}) {
    const auto problems = problems_of(body);
    const Connector connector(body);
    const lanes::BodyView view = view_of(body);
    std::vector<double> ours(problems.size(), 1e300), theirs = ours, iterations, pits;
    int outcome[4] = {}, paper = 0;
    for (int round = 0; round < kRounds; ++round)
      for (std::size_t k = 0; k < problems.size(); ++k) {
        const Problem& p = problems[k];
        Connection c;
        ours[k] = std::min(ours[k], microseconds([&] { c = connector.connect(p.from, p.like, p.to, p.duration_s, kGravity); }));
        const Quat target = p.from.orientation.conjugate() * p.to.orientation;
        PaperShooting s;
        theirs[k] = std::min(theirs[k], microseconds([&] {
          const Vec3 guess = p.duration_s * paper_guess(view, p.from.orientation, p.from.orientation.conjugate() * p.from.angular_velocity,
                                         p.like.orientation, p.like.orientation.conjugate() * p.like.angular_velocity);
          s = shoot_as_paper(view, target, guess, kPaperTolerance_rad, kPaperIterations);
        }));
        if (round) continue;
        ++outcome[int(c.shooting.outcome)];
        paper += s.converged;
        iterations.push_back(c.shooting.iterations);
        pits.push_back(s.iterations);
        if (c.shooting.outcome != Shot::converged && getenv("V")) std::printf("  %zu T %.3f outcome %d spin %.2f dspin %.2f err %.3f its %d fold %.3f slope %g\n", k, p.duration_s, int(c.shooting.outcome), p.from.angular_velocity.norm()*p.duration_s, (p.from.angular_velocity-p.like.angular_velocity).norm()*p.duration_s, c.shooting.error_rad, c.shooting.iterations, c.shooting.fold_at, c.shooting.fold_slope);
      }
    std::vector<double> ratio;
    for (std::size_t k = 0; k < ours.size(); ++k) ratio.push_back(theirs[k] / ours[k]);
    std::printf("%s conv %d fold %d fast %d stalled %d | its %.0f mean %.2f | us median %.3f mean %.3f | paper conv %d its %.0f mean %.1f us %.2f mean %.2f | ratio median %.1f of means %.1f\n", body.name().c_str(), outcome[0], outcome[1],
                outcome[2], outcome[3], median(iterations), mean(iterations), median(ours), mean(ours), paper, median(pits), mean(pits), median(theirs), mean(theirs), median(ratio), mean(theirs) / mean(ours));
  }
  return 0;
}
