// The effects that a solve can simulate or leave out, and how often the code of each has run. Which are on is
// planned from marks, body and options (solution/plan.hpp).
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace ifa {

enum class Effect : std::uint8_t {
  spin_coupling,            // the gyroscopic term of torque-free rotation
  friction,                 // of impacts and of sustained contact
  sustained_contact,        // slide, roll, rock, chatter
  rounding,                 // of the hull
  circular_edges,           // of the hull
  pre_roll_flight,          // before the first mark
  settling_to_rest,         // after the last mark
  amplitude_matching,       // f_a, paper eq. 6
  length_matching,          // f_l, paper eq. 7
  centroid_matching,        // f_c, paper eq. 8
  orientation_constraints,  // f_o, paper section 6
  position_constraints,     // f_p, paper section 6
  retiming,                 // paper section 5.3
  material_fit              // restitution and friction chosen from the marks
};
inline constexpr std::array<std::string_view, 14> kEffectNames = {
    "spin_coupling",   "friction",          "sustained_contact",       "rounding",
    "circular_edges",  "pre_roll_flight",   "settling_to_rest",        "amplitude_matching",
    "length_matching", "centroid_matching", "orientation_constraints", "position_constraints",
    "retiming",        "material_fit"};
inline constexpr std::size_t kEffects = kEffectNames.size();

// Bit i is set where the build has effect i. Some are left out in tests, to compare with: what a scene does
// not call for must cost it no bit of its results. Of the engine's: spin_coupling, sustained_contact,
// circular_edges.
#ifndef IFA_EFFECTS_COMPILED
#define IFA_EFFECTS_COMPILED 0xffff
#endif
consteval bool compiled(Effect effect) {
  return (IFA_EFFECTS_COMPILED >> static_cast<unsigned>(effect) & 1u) != 0;
}

// How often the code of each effect has run: counted where that code is, not where it is decided on.
struct EffectCounts {
  std::uint64_t runs[kEffects];
};

// Of this thread, since it began: a search sums up what its workers have added. Direct access, no function:
// the kernels of each instruction set are compiled apart and must not share any.
extern constinit thread_local EffectCounts effect_counts;

}  // namespace ifa
