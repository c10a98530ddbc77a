// What the simulations of a database follow from, as text that says every number exactly.
#pragma once

#include <cstdint>
#include <filesystem>

#include "ifa/graph/array_set.hpp"
#include "ifa/graph/nodes.hpp"
#include "ifa/motion/sampling.hpp"
#include "ifa/solution/passage.hpp"

namespace ifa {

// With a body, all that the nodes depend on.
struct Recipe {
  SearchPhysics physics;  // energy_gain_j is of no account: it is the search's
  SamplingOptions sampling;
  std::uint64_t seed = 0;
  double until_s = 60.0;  // a simulation that has not come to rest by then ends without a terminal node
};

// Throws ArgumentError naming the field that cannot be.
void validate(const Recipe& recipe);

// The body that a database of `body` holds: the same, but that making it from its own definition changes
// nothing.
Body settled(const Body& body);

// `body` is settled. The hashes sum up the shape with its mass, and the material.
Fields to_fields(const Body& body, const Recipe& recipe);

// Throw FileError naming `path` where a field is missing or cannot be read.
Body body_from(const Fields& fields, const std::filesystem::path& path);
Recipe recipe_from(const Fields& fields, const std::filesystem::path& path);

// The name of the first field in which two differ, other than the body's name; empty if they agree.
std::string difference(const Fields& a, const Fields& b);

// How the engine of this program simulates on this processor, as a field: the sum of the nodes of a few
// simulations. Nodes of engines that differ in it must not be mixed.
std::uint64_t engine_sum();

// `value` of a field of `fields`; FileError naming `path` where there is none.
const std::string& value_of(const Fields& fields, const std::string& name, const std::filesystem::path& path);

// "restitution: PATH has 0.5, not 0.4": how a message says that a field differs.
std::string difference_text(const std::string& name, const Fields& theirs, const Fields& ours,
                            const std::filesystem::path& path);

}  // namespace ifa
