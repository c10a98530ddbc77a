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

// Take-offs are folded, so that one stands for all its images, and sorted into cells of similar `up`. Within a
// cell their velocities are turned by the smallest turns to one `up`, the cell's centre. The turn of a splice
// is then one for the whole cell, but for the little by which turns do not commute; so what a plausible region
// admits of a cell is an ellipsoid in (velocity, spin), and a tree of boxes bounds the costs of many splices at
// once.
class FlightIndex {
 public:
  // Of the flights of `members`. `nodes`, `body` and `images` must outlive it.
  FlightIndex(const Nodes& nodes, const Body& body, const Images& images,
              std::span<const std::uint32_t> members);

  // The `most` best flights after node i's take-off, best first: both factors above kLeastLogFactor, not i's own
  // flight, each flight once under its best element, and those alone that `admits`. Thread-safe.
  std::vector<FoundSplice> best(std::size_t i, std::size_t most,
                                const std::function<bool(std::uint32_t, const Splice&)>& admits) const;

 private:
  // Velocity with what heights add to it, 3; 1 / flight time; spin, 3; flight time as f_q has it.
  using Place = std::array<float, 8>;

  struct Member {
    Place place;
    std::array<float, 3> up;
    std::uint32_t node;
    std::uint8_t fold;  // number of the element that it was folded by
  };
  struct alignas(16) Box {
    Place centre, half;
    float across_velocity, across_spin;  // the largest parts across `up`
    float velocity, spin;                // the largest altogether
    std::uint32_t first, count;          // of members_
    std::uint32_t right;                 // second child; the first is the next box. 0: a leaf
  };
  struct Cell {
    Vec3 centre;
    double radius_rad;
    double least_cosine;  // of the angle to an `up` from which a member may be reached
    std::uint32_t root;
  };
  struct Frame;

  std::uint8_t fold(const Vec3& up) const;
  std::uint32_t add_cell(std::span<Member> members, const Vec3& centre);
  std::uint32_t build(std::uint32_t first, std::uint32_t count, const Vec3& up);
  std::vector<Frame> frames(const TakeOffView& from, const PlausibleRegion& region) const;

  const Nodes& nodes_;
  const Body& body_;
  const Images& images_;
  double height_m_ = 0.0;              // that heights are relative to
  Place weight_{};                     // of extents, where boxes are cut
  std::vector<std::uint8_t> between_;  // [a][b]: the number of a^-1 b
  std::vector<Member> members_;
  std::vector<Box> boxes_;
  std::vector<Cell> cells_;
};

}  // namespace ifa
