// The engine's effects: which ones a body calls for, and the body with some of them on or off.
#pragma once

#include "ifa/rigid/body.hpp"

namespace ifa {

// `sustained_contact` is not the body's but the simulation's (SimulationOptions).
struct EngineEffects {
  bool spin_coupling = true;   // off: flight turns with a constant spin about a fixed axis
  bool friction = true;        // off: of impacts, and of sliding, rolling and spinning on the ground
  bool rounding = true;        // off: radius 0, the hull's vertices stay where they are
  bool circular_edges = true;  // off: polygons of kCornersOfRing in their place

  bool operator==(const EngineEffects&) const = default;
};

inline constexpr int kCornersOfRing = 24;

// What the body calls for, whatever is forced: spin coupling where its moments differ, friction where one of
// the material's figures is above 0, rounding and circular edges where it has them.
EngineEffects needed_effects(const Body& body);

// The same body, its mass, inertia and material unchanged, with these effects. Those that are as it calls for
// are left to follow it and its material, and the results keep their bytes; others are forced, and stay so
// with every material (the figures of friction are kept, and not used). Forced on beyond need, spin coupling
// and friction run their general code; rounding and circular edges that it does not have cannot be put on:
// there is nothing to run. Throws ArgumentError where rounding is off and the rest has no volume (a ball, a
// capsule).
Body with_effects(const Body& body, const EngineEffects& effects);

}  // namespace ifa
