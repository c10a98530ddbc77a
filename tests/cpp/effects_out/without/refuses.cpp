#include "ifa/base/effects.hpp"
#include "ifa/base/error.hpp"
#include "ifa/rigid/flight.hpp"
#include "sample_bodies.hpp"

namespace ifa {

// Whether this build has none of the effects, and says so.
bool refuses_what_it_has_not() {
  static_assert(!compiled(Effect::spin_coupling) && !compiled(Effect::sustained_contact) &&
                !compiled(Effect::circular_edges));
  const auto refused = [](const Body& body) {
    try {
      Flight flight(body);
    } catch (const ArgumentError&) {
      return true;
    }
    return false;
  };
  SimulationOptions options;
  options.sustained_contact = true;
  const Body cube = sample::box({0.02, 0.02, 0.02}, 0.01);
  State lying;
  lying.position.z() = 0.01;
  return refused(sample::box({0.01, 0.02, 0.03}, 0.01)) && refused(sample::coin()) && !refused(cube) &&
         simulate(cube, lying, options, 1.0).status == RunStatus::contact;
}

}  // namespace ifa
