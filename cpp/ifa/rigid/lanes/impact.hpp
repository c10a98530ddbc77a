// Impacts of a pack of bodies, with an exact energy guard.
#pragma once

#include "ifa/rigid/lanes/contacts.hpp"
#include "ifa/rigid/lanes/points.hpp"

namespace ifa::IFA_LANES_NAMESPACE {

inline Symmetric inverse_inertia(const BodyView& body, const Rotation& r) {
  const double ix = 1.0 / body.inertia[0], iy = 1.0 / body.inertia[1], iz = 1.0 / body.inertia[2];
  if (body.isotropic) {
    const Pack zero = broadcast(0.0), i = broadcast(ix);
    return {i, zero, zero, i, zero, i};
  }
  return {ix * r.x.x * r.x.x + iy * r.y.x * r.y.x + iz * r.z.x * r.z.x,
          ix * r.x.x * r.x.y + iy * r.y.x * r.y.y + iz * r.z.x * r.z.y,
          ix * r.x.x * r.x.z + iy * r.y.x * r.y.z + iz * r.z.x * r.z.z,
          ix * r.x.y * r.x.y + iy * r.y.y * r.y.y + iz * r.z.y * r.z.y,
          ix * r.x.y * r.x.z + iy * r.y.y * r.y.z + iz * r.z.y * r.z.z,
          ix * r.x.z * r.x.z + iy * r.y.z * r.y.z + iz * r.z.z * r.z.z};
}

// `spin` in principal axes.
inline Pack kinetic_energy(const BodyView& body, const Pack3& velocity, const Pack3& spin) {
  return 0.5 * (body.mass * dot(velocity, velocity) + body.inertia[0] * spin.x * spin.x +
                body.inertia[1] * spin.y * spin.y + body.inertia[2] * spin.z * spin.z);
}

struct ImpactOutcome {
  Pack3 impulse, position;
};

// A Newton target -e v_n at each approaching point (0 where none is faster than `micro_speed`), Coulomb's
// cone, and where the kinetic energy would grow, the whole impulse blended towards that of e = 0 until it
// does not: with e = 0 Coulomb's law cannot raise it, and along the blend it is a parabola in the share of
// the elastic impulse.
inline ImpactOutcome resolve_impact(const BodyView& body, Pack micro_speed, ContactSlot* slot, int n,
                                    Mask where, const Rotation& r, Motion& m) {
  constexpr int kMostSweeps = 200;
  const Pack zero = broadcast(0.0), one = broadcast(1.0);
  Pack scale = zero, fastest = zero;
  for (int i = 0; i < n; ++i) {
    const Pack3 v = m.velocity + cross(m.spin, slot[i].arm);
    slot[i].target = -body.restitution * least(v.z, zero);
    slot[i].impulse = broadcast(0.0, 0.0, 0.0);
    fastest = select(slot[i].valid, greatest(fastest, -v.z), fastest);
    scale = select(slot[i].valid, greatest(scale, norm(v)), scale);
  }
  const Mask bounces = where & (fastest > micro_speed) & mask_of(body.restitution > 0.0);
  for (int i = 0; i < n; ++i) slot[i].target = select(bounces, slot[i].target, zero);
  const Pack before = kinetic_energy(body, m.velocity, r.inverse(m.spin));
  const Pack allowed = before * (1.0 + 4e-16);
  struct Attempt {
    Pack3 velocity, spin;
    Pack energy;
    Mask gains;
  };
  const auto attempt = [&](Mask lanes, bool cone) {
    Attempt a{m.velocity, m.spin, zero, none()};
    for (int i = 0; i < n; ++i) slot[i].impulse = select(lanes, broadcast(0.0, 0.0, 0.0), slot[i].impulse);
    Pack3 torque = broadcast(0.0, 0.0, 0.0);
    const ContactBodies problem{
        broadcast(1.0 / body.mass), inverse_inertia(body, r), cone ? body.friction : 0.0, 0.0, 0.0, cone};
    solve_contacts(problem, slot, n, lanes, 1e-12 * scale, kMostSweeps, a.velocity, a.spin, torque);
    a.energy = kinetic_energy(body, a.velocity, r.inverse(a.spin));
    a.gains = lanes & negated(a.energy <= allowed);  // also where it is not a number
    return a;
  };
  const Attempt wanted = attempt(where, body.cone);
  Pack3 velocity = wanted.velocity, spin = wanted.spin;
  if (any(wanted.gains)) {
    const Mask gains = wanted.gains;
    for (int i = 0; i < n; ++i) {
      slot[i].elastic = slot[i].impulse;
      slot[i].target = select(gains, zero, slot[i].target);
    }
    // A jam can keep the sweeps from Coulomb's law, and rounding rules where moments differ by 1e11: then
    // without friction, else from no impulse at all.
    Attempt dull = attempt(gains, body.cone);
    if (any(dull.gains)) {
      const Attempt smooth = attempt(dull.gains, false);
      dull.velocity = select(dull.gains, smooth.velocity, dull.velocity);
      dull.spin = select(dull.gains, smooth.spin, dull.spin);
      dull.velocity = select(smooth.gains, m.velocity, dull.velocity);
      dull.spin = select(smooth.gains, m.spin, dull.spin);
      for (int i = 0; i < n; ++i)
        slot[i].impulse = select(smooth.gains, broadcast(0.0, 0.0, 0.0), slot[i].impulse);
    }
    // An outcome that multiplies the energy, or is no number, is none to blend with.
    const Mask wild = negated(wanted.energy <= 4.0 * before);
    velocity = select(wild, dull.velocity, velocity);
    spin = select(wild, dull.spin, spin);
    for (int i = 0; i < n; ++i) slot[i].elastic = select(gains & wild, slot[i].impulse, slot[i].elastic);
    const Pack3 dv = velocity - dull.velocity, dw = spin - dull.spin;
    const Pack3 w0 = r.inverse(dull.spin), w1 = r.inverse(dw);
    const Pack a = kinetic_energy(body, dv, w1);
    const Pack b = body.mass * dot(dv, dull.velocity) + body.inertia[0] * w1.x * w0.x +
                   body.inertia[1] * w1.y * w0.y + body.inertia[2] * w1.z * w0.z;
    const Pack c = least(kinetic_energy(body, dull.velocity, w0) - before, zero);
    const Pack swing = root(positive(b * b - 4.0 * a * c));
    const Pack crossing = select(b > zero, -2.0 * c / (b + swing), (swing - b) / (2.0 * a));
    const Pack share = select(a > zero, clamp(crossing * (1.0 - 1e-15), zero, one), zero);
    velocity = select(gains, dull.velocity + share * dv, velocity);
    spin = select(gains, dull.spin + share * dw, spin);
    for (int i = 0; i < n; ++i) {
      const Pack3 blend = slot[i].impulse + share * (slot[i].elastic - slot[i].impulse);
      slot[i].impulse = select(gains, blend, slot[i].elastic);
    }
  }
  ImpactOutcome outcome{broadcast(0.0, 0.0, 0.0), broadcast(0.0, 0.0, 0.0)};
  for (int i = 0; i < n; ++i) {
    const Pack3 push = select(slot[i].valid, slot[i].impulse, broadcast(0.0, 0.0, 0.0));
    outcome.impulse = outcome.impulse + push;
    outcome.position = outcome.position + push.z * (m.position + slot[i].arm);
  }
  const Mask pushed = outcome.impulse.z > zero;
  outcome.position = select(pushed, (one / outcome.impulse.z) * outcome.position,
                            n > 0 ? m.position + slot[0].arm : m.position);
  m.velocity = select(where, velocity, m.velocity);
  m.spin = select(where, spin, m.spin);
  return outcome;
}

// Contact slots of the bearing points, their arms at the orientation `r`.
inline int make_slots(const BodyView& body, const Points& points, const Bearing& bearing, const Rotation& r,
                      ContactSlot* slot) {
  const int n = bearing.most();
  for (int i = 0; i < n; ++i) {
    slot[i].valid = bearing.has(i);
    slot[i].arm = r.apply(points.at(bearing.point[i]));
    slot[i].arm.z = slot[i].arm.z - body.rounding;
    slot[i].target = broadcast(0.0);
    slot[i].impulse = broadcast(0.0, 0.0, 0.0);
  }
  return n;
}

}  // namespace ifa::IFA_LANES_NAMESPACE
