// Under which elements of the body's symmetry group a take-off is seen from another one, as numbers of a byte.
#pragma once

#include <cstdint>
#include <vector>

#include "ifa/graph/nodes.hpp"
#include "ifa/rigid/symmetry.hpp"

namespace ifa {

// For a finite group, its elements. Where the body may be turned by any angle, both take-offs are first folded,
// so that their `up` agree as far as they can, and a number stands for one of Symmetry::elements() with one of
// evenly spaced turns about the axis; what is between these is missed.
class Images {
 public:
  explicit Images(const Symmetry& symmetry);

  std::size_t size() const { return elements_.size(); }  // 256 at most; 0 is the identity
  const SymmetryElement& operator[](std::size_t number) const { return elements_[number]; }

  // The turn that a state is given before its images are taken: the identity for a finite group.
  Mat3 folding(const Vec3& up) const;

  // The element of the group under which `seen` is looked at from `from`.
  SymmetryElement element(std::size_t number, const Vec3& from_up, const Vec3& seen_up) const;

 private:
  Symmetry symmetry_;
  std::vector<SymmetryElement> elements_;
};

TakeOffView image(const SymmetryElement& element, const TakeOffView& view);

}  // namespace ifa
