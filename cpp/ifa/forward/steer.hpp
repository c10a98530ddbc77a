// Changes after which the body comes where the constraints of the next mark want it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "ifa/forward/closing.hpp"

namespace ifa {

using Mat36 = Eigen::Matrix<double, 3, 6>;

// How the pose at the next mark depends on a change y in R^6, to first order: as in flight, the centre of
// mass is carried by the velocity and the body turned by the spin for the whole interval.
struct Arrival {
  State pose;  // principal axes
  Eigen::Matrix<double, 2, 6> position;
  Mat36 turn;  // a rotation vector, world axes

  // y changes velocity and spin, which is `spin` without it, by so much in all.
  Arrival(const State& pose, const Vec3& spin, double interval_s, const Mat36& velocities,
          const Mat36& spins);
  // y of a plausible region.
  Arrival(const State& pose, const Vec3& spin, double interval_s, const PlausibleRegion& region);
};

// What the constraints ask of a pose at one mark. Where no position is asked there, but before and after,
// the body shall come near the straight line between these, in proportion to the time.
class Aim {
 public:
  Aim(const Marks& marks, const Body& body, std::size_t mark);

  bool any() const { return position_ || !directions_.empty(); }

  // How late a change comes, s, to first order: it shall stay in time.
  struct Lateness {
    double now_s, target_s;
    Vec6 gradient_s;
  };

  struct Step {
    Vec6 y;
    double cost;  // what is left: |y|^2 and by how much the alignment's cost grows
  };

  // From a change y that arrives so, the change within `radius` that should make excess and constraints
  // together cost least.
  Step step(const Alignment& before, const Arrival& arrival, const Vec6& y, double radius,
            const std::optional<Lateness>& lateness) const;

 private:
  struct Wanted {
    Vec2 position_m;
    double weight;
  };
  struct Direction {
    Vec3 principal, world;
  };

  Alignment with(Alignment alignment, const Vec2& position_m, const std::vector<Vec3>& directions) const;

  std::optional<Wanted> position_;
  std::vector<Direction> directions_;
};

// The rotation vector that takes a direction of the body, as it is, to one as steep as is wanted: headings
// are free.
Vec3 turn_to(const Vec3& now, const Vec3& wanted);

// A guess of what the constraints at rest will cost a candidate that goes on so unchanged. A change may yet
// mend it; the less energy the body has, the less: on its way to rest it stays on the face it lies on once it
// cannot tip over any more.
double toll_at_rest(const Problem& problem, const Candidate& candidate, const Passage& passage);

// Whether it lies otherwise than is asked at rest, with too little energy to tip over any more.
bool lies_for_good(const Problem& problem, const Candidate& candidate);

// More that come in time, and to where the constraints want the body: from the best of each candidate's
// anchors, the change that a linear model of lateness, place and turn says. `seen` are other trials, for this
// model. Some of them miss.
std::vector<Anchor> steer(Trials& trials, std::span<const Candidate> candidates, std::size_t k,
                          const Tolerance& tolerance, std::span<const Anchor> anchors,
                          std::span<const Trial> seen);

}  // namespace ifa
