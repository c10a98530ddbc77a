// Plain data that every width of the kernels shares.
#pragma once

#include <cstdint>

namespace ifa::lanes {

// Points that bear a body in one step: those that touch (at most eight, or eight directions and the fastest),
// and those that may come down to the ground while it settles.
inline constexpr int kMostBearing = 9, kMostSettling = 8, kSlots = kMostBearing + kMostSettling;
inline constexpr int kMostRings = 8;
inline constexpr int kRingPoints = 8;  // a circular edge stands on up to so many points

struct Ring {                                  // a circular edge, in principal axes
  double centre[3], axis[3], side[3], radius;  // `side` is a unit vector across the axis
};

// A body in principal axes. Indices of points: first the vertices, then kRingPoints for each ring.
struct BodyView {
  const double* vertex = nullptr;  // x y z of each
  int vertices = 0;
  Ring ring[kMostRings];
  int rings = 0;
  double rounding, bounding_radius;
  double mass, inertia[3];
  bool isotropic;
  bool centred;       // its one point is its centre of mass: a ball, whose contacts do not depend on its pose
  bool couples_spin;  // else it turns with a constant spin about a fixed axis
  bool cone;          // Coulomb's cone is solved, be it of friction 0
  double restitution, friction, rolling_friction_m, spin_friction_m;
};

struct Settings {
  double gravity[3];
  double step_s, micro_speed, rest_speed, rest_duration_s;
  double step_speed;       // m/s: what gravity adds in one step; the scale of tolerances
  double least_bounce;     // m/s: touching points that leave more slowly need sustained contact
  bool sustained_contact;  // else a simulation ends where that begins
};

enum class Stop : std::int32_t { none, impact, rest, time_limit, contact };
enum class Stage : std::int32_t { flight, contact, rest };

// One simulation in progress. World axes; the orientation maps principal axes to world axes, w x y z.
struct Sim {
  double position[3], orientation[4], velocity[3], spin[3];
  double time_s, until_s;
  double slow_since_s;
  Stage stage;
  std::int32_t slow, still_steps;
  std::int32_t touching;  // points that touch the ground at an impact, or did in the last contact step
  // Points that bore the last contact step, their forces, N, and the torque of rolling and spin friction, N
  // m: the next step begins from them.
  std::int32_t bearing;
  std::int32_t point[kSlots];
  double force[kSlots][3], torque[3];
};

struct HitData {
  double impulse[3], position[3], approach_speed;
};

struct LoadData {  // of one step of sustained contact
  double begin_s, length_s, normal_impulse, slip_speed;
};

// The steps of the event engine, for up to `width` simulations of one body at once.
struct Kernels {
  const char* name;
  int width;
  // The least normal velocity over the touching points, 1e100 where none touches.
  double (*separation_speed)(const BodyView&, const Sim&);
  // From flight to the instant of the next impact (the state is that just before it), or to until_s;
  // Stop::none: on the way there.
  void (*fly)(const BodyView&, const Settings&, Sim* const* sims, int count, Stop* stops);
  // Resolves the impact at a state that touches the ground, and chooses what comes next: flight or contact.
  void (*resolve)(const BodyView&, const Settings&, Sim* const* sims, int count, HitData* hits);
  // One step of sustained contact. Stop::impact: a point has landed. `loads` may be null.
  void (*step)(const BodyView&, const Settings&, Sim* const* sims, int count, Stop* stops, LoadData* loads);
};

extern const Kernels kScalarKernels, kSse2Kernels, kAvx2Kernels, kAvx512Kernels;  // x86-64: all of them

}  // namespace ifa::lanes
