// A spatial index of flights modulo the body's symmetry: which are the best to splice after a given take-off.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "ifa/graph/images.hpp"
#include "ifa/graph/weights.hpp"

namespace ifa {

struct FoundSplice {
  double cost;           // -log(f_v f_q)
  std::uint32_t node;    // whose flight it is
  std::uint8_t element;  // number in Images, under which it is seen
};

// Take-offs are folded, so that one stands for all its images, and sorted into cells of similar `up`. Within
// a cell their velocities are turned by the smallest turns to one `up`, the cell's centre. The turn of a
// splice is then one for the whole cell, but for the little by which turns do not commute; so what a
// plausible region admits of a cell is an ellipsoid in (velocity, spin), and boxes bound the costs of many
// splices at once. The boxes form trees of 16 branches, which are looked at side by side.
class FlightIndex {
 public:
  // Of the flights of `members`. `nodes`, `body` and `images` must outlive it.
  FlightIndex(const Nodes& nodes, const Body& body, const Images& images,
              std::span<const std::uint32_t> members);

  // The `most` best flights after node i's take-off, best first: both factors above kLeastLogFactor, not i's
  // own flight, each flight once under its best element, and those alone that `admits`. Thread-safe.
  std::vector<FoundSplice> best(std::size_t i, std::size_t most,
                                const std::function<bool(std::uint32_t, const Splice&)>& admits) const;

 private:
  static constexpr std::size_t kLanes = 16;
  using Lanes = std::array<float, kLanes>;

  // Velocity with what heights add to it, 3; 1 / flight time; spin, 3; flight time as f_q has it.
  using Place = std::array<float, 8>;

  struct Member {
    Place place;
    std::array<float, 3> up;
    std::uint32_t node;
    std::uint8_t fold;  // number of the element that it was folded by
  };
  // Largest parts of velocity and spin across `up`, and altogether, of members close to one another: they are
  // what a turn, and rounding, can move.
  struct Reach {
    float across_velocity = 0.0f, across_spin = 0.0f, velocity = 0.0f, spin = 0.0f;
  };
  struct Branch {
    std::uint32_t first;  // of members_, or of boxes_ (one item)
    std::uint32_t count;  // of members; 0: boxes
    Reach reach;
  };
  struct alignas(64) Boxes {
    std::array<Lanes, 8> centre, half;
    std::array<Branch, kLanes> branch;
    std::uint32_t size;
  };
  struct Cell {
    Vec3 centre;
    double radius_rad;
    double least_cosine;  // of the angle to an `up` from which a member may be reached
    float most_flight_s;
    Branch root;
  };
  struct Frame;

  std::uint8_t fold(const Vec3& up) const;
  void add_cell(std::vector<Member>& inside);
  Branch build(std::uint32_t first, std::uint32_t count, const Vec3& up);
  std::size_t widest(std::span<const Member> inside) const;
  std::vector<Frame> frames(const TakeOffView& from, const PlausibleRegion& region) const;

  const Nodes& nodes_;
  const Body& body_;
  const Images& images_;
  double height_m_ = 0.0;              // that heights are relative to
  Place weight_{};                     // of extents, where boxes are cut
  std::vector<std::uint8_t> between_;  // [a][b]: the number of a^-1 b
  std::vector<Member> members_;
  std::array<std::vector<float>, 8> columns_;  // of their places
  std::vector<Boxes> boxes_;
  std::vector<Cell> cells_;
};

}  // namespace ifa
