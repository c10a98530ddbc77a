// The kernels of one instruction set. Included by each kernels_*.cpp, which chooses the namespace and the width.
#include "ifa/rigid/lanes/flight.hpp"
#include "ifa/rigid/lanes/step.hpp"

namespace ifa::IFA_LANES_NAMESPACE {
namespace {

double separation_speed(const BodyView& body, const Sim& sim) {
  Sim copy = sim;
  Sim* const sims[1] = {&copy};
  const Motion m = load(sims, 1);
  const Rotation r = rotation(m.orientation);
  return -get(approach_speed(body, Points(body, r.up()), m, r), 0);
}

void fly(const BodyView& body, const Settings& settings, Sim* const* sims, int count, Stop* stops) {
  const Motion start = load(sims, count);
  Pack limit{};
  for (int l = 0; l < kWidth; ++l) {
    const Sim& s = *sims[l < count ? l : 0];
    set(limit, l, s.until_s - s.time_s);
  }
  const Mask lanes = first_lanes(count);
  FlightPath path(body, broadcast(settings.gravity), start, lanes);
  const FlightPath::Contact contact = path.next_contact(limit, lanes);
  const Mask in_time = contact.time_s <= limit;
  const Motion end = path.at(select(in_time, contact.time_s, limit), lanes);
  for (int l = 0; l < count; ++l) {
    Sim& s = *sims[l];
    const bool goes_on = get_bit(in_time, l);  // without a landing: so fast a spin that the search takes turns
    stops[l] = get_bit(contact.landed, l) ? Stop::impact : goes_on ? Stop::none : Stop::time_limit;
    s.time_s = goes_on ? s.time_s + get(contact.time_s, l) : s.until_s;
  }
  const Rotation r = rotation(end.orientation);
  const Bearing bearing = touching_points(body, Points(body, r.up()), end, r, contact.landed);
  for (int l = 0; l < count; ++l) sims[l]->touching = bearing.count[l];
  store(end, sims, count);
}

void resolve(const BodyView& body, const Settings& settings, Sim* const* sims, int count,
             lanes::HitData* hits) {
  Motion m = load(sims, count);
  const Mask lanes = first_lanes(count);
  const Rotation r = rotation(m.orientation);
  const Points points(body, r.up());
  const Pack approach = approach_speed(body, points, m, r);
  const Bearing bearing = touching_points(body, points, m, r, lanes);
  ContactSlot slot[kSlots];
  const int n = make_slots(body, points, bearing, r, slot);
  const ImpactOutcome outcome = resolve_impact(body, broadcast(settings.micro_speed), slot, n, lanes, r, m);
  const Pack separation = -approach_speed(body, points, m, r);
  for (int l = 0; l < count; ++l) {
    Sim& s = *sims[l];
    const bool stays = get(separation, l) < settings.least_bounce;
    s.stage = stays ? Stage::contact : Stage::flight;
    if (!stays) s.slow = 0;
    s.bearing = 0;
    s.touching = bearing.count[l];
    hits[l] = {{get(outcome.impulse.x, l), get(outcome.impulse.y, l), get(outcome.impulse.z, l)},
               {get(outcome.position.x, l), get(outcome.position.y, l), get(outcome.position.z, l)},
               get(approach, l) > 0.0 ? get(approach, l) : 0.0};
  }
  store(m, sims, count);
}

void step(const BodyView& body, const Settings& settings, Sim* const* sims, int count, Stop* stops,
          lanes::LoadData* loads) {
  if constexpr (compiled(Effect::sustained_contact)) ContactStep(body, settings, sims, count).run(stops, loads);
}

}  // namespace
}  // namespace ifa::IFA_LANES_NAMESPACE
