// How different two motions of one body are.
#pragma once

#include "ifa/motion/motion.hpp"

namespace ifa {

// The root mean square, over the body's mass and the time from `from_s` to `to_s`, of the distance between
// where a material point is in `a` and in `b`, in bounding radii. Before, b is shifted in x and y and turned
// about z, once for the whole time, so that this is least: the plane is the same everywhere, so is every
// direction on it. Heights are compared as they are. 0 for the same motion elsewhere on the ground; symmetric
// in a and b.
//
// At the midpoints of equal intervals, 240 a second (fewer over more than 400 s). Outside of a motion its
// body is still. Throws ArgumentError unless both motions are of one body (whose material may differ) and the
// times are finite and in order.
double difference(const Motion& a, const Motion& b, double from_s, double to_s);

}  // namespace ifa
