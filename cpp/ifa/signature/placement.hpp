// Where on the ground a motion takes place. Physics does not care: a motion may be shifted along the ground
// and turned about the vertical as a whole, and its constraints say how.
#pragma once

#include "ifa/rigid/state.hpp"
#include "ifa/signature/constraints.hpp"

namespace ifa {

// A turn about z, then a shift along the ground.
struct Placement {
  double cosine = 1.0, sine = 0.0;
  Vec2 shift_m = Vec2::Zero();

  Vec2 turned(const Vec2& v) const { return {cosine * v.x() - sine * v.y(), sine * v.x() + cosine * v.y()}; }
  Vec2 turned_back(const Vec2& v) const {
    return {cosine * v.x() + sine * v.y(), cosine * v.y() - sine * v.x()};
  }
  Vec3 turned(const Vec3& v) const;
  Vec2 placed(const Vec2& position_m) const { return turned(position_m) + shift_m; }
  Vec3 placed(const Vec3& position_m) const;
  State placed(const State& state) const;
};

// The placement that a motion's constraints ask for, in closed form and updated constraint by constraint:
// that which makes the sum of weight times squared distance least, of positions on the ground and of
// directions on the unit sphere. (Umeyama 1991 in the plane, without a mirror or a scale; the paper aligns
// the first edge.) With weights c_p and c_o, exp(-cost) is the product of all f_p and f_o, since for small
// angles the squared distance of directions is the squared angle between them; it is never larger than that.
class Alignment {
 public:
  // `own` in the motion's axes.
  void add_position(const Vec2& own, const Vec2& wanted, double weight = kPositionWeight);
  void add_direction(const Vec3& own, const Vec3& wanted, double weight = kOrientationWeight);

  // What `asked` says of the pose at a mark or at rest, in principal axes.
  void add(const Constraints& asked, std::size_t mark, const Body& body, const State& pose);

  // Without a position nothing is shifted; where every turn is as good, nothing is turned.
  Placement best() const;
  double cost() const;  // the least sum

 private:
  double weight_ = 0.0;  // of the positions
  Vec2 mean_own_ = Vec2::Zero(), mean_wanted_ = Vec2::Zero();
  double squares_ = 0.0;            // of both
  double dot_ = 0.0, cross_ = 0.0;  // of own with wanted, about the means
};

// A direction of the body, given in body axes, in the world; the pose in principal axes.
Vec3 seen(const Body& body, const State& pose, const Vec3& body_direction);

}  // namespace ifa
