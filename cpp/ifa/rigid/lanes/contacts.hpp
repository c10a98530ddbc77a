// The contact problem of a pack of bodies at one instant: impulses at points on the ground.
#pragma once

#include "ifa/rigid/lanes/effects.hpp"
#include "ifa/rigid/lanes/rare.hpp"

namespace ifa::IFA_LANES_NAMESPACE {

struct Symmetric {
  Pack xx, xy, xz, yy, yz, zz;

  Pack3 apply(const Pack3& v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
  }
};

inline Symmetric inverse(const Symmetric& m) {
  const Pack a = m.yy * m.zz - m.yz * m.yz, b = m.xz * m.yz - m.xy * m.zz, c = m.xy * m.yz - m.xz * m.yy;
  const Pack s = broadcast(1.0) / (m.xx * a + m.xy * b + m.xz * c);
  return {s * a,
          s * b,
          s * c,
          s * (m.xx * m.zz - m.xz * m.xz),
          s * (m.xy * m.xz - m.xx * m.yz),
          s * (m.xx * m.yy - m.xy * m.xy)};
}

struct ContactSlot {
  Mask valid;
  Pack3 arm;                      // from the centre of mass to the contact point, world axes
  Pack target;                    // least normal speed after: -e times the approach, or 0
  Pack3 impulse;                  // on the body
  Pack3 elastic;                  // its impulse before an impact is blended
  Pack3 change, last_change;      // of the impulse in the last two sweeps
  Symmetric response, stiffness;  // velocity per impulse at the point, and its inverse
};

struct ContactBodies {
  Pack inverse_mass;
  Symmetric inverse_inertia;  // world axes
  double friction, rolling_friction_m, spin_friction_m;
  bool cone;  // of Coulomb's law; false only where `friction` is 0
};

// The impulse of a sliding point. With d = (c, s) the unit slip direction after, J = J_n (-mu d, 1), the
// normal speed after is the target, and the slip after, u_t, points along d. Of u_t x d = 0 remains one
// equation for d,
//   (d x f) (K_nn - mu k.d) + a (d x k - mu d x A d) = 0,  a = target - free_n,
// with the point's matrix K = [A k; k^T K_nn] and f the tangential velocity without its impulse.
struct Slide {
  const Symmetric& k;
  const Pack3& free;
  Pack target;
  double friction;

  // Newton's iteration for the angle of d, from (c, s), where `where`. `sharp` asks for a root to rounding;
  // else one step does, since the sweeps go on. Returns where it found an impulse that neither pulls nor
  // slips against d.
  Mask newton(Pack c, Pack s, Mask where, bool sharp, Pack3& impulse) const {
    const Pack zero = broadcast(0.0), one = broadcast(1.0);
    const Pack a = target - free.z;
    Mask active = where, turned = none();
    for (int i = 0; i < 20 && any(active); ++i) {
      const Pack across = c * free.y - s * free.x, along = c * free.x + s * free.y;
      const Pack k_across = c * k.yz - s * k.xz, k_along = c * k.xz + s * k.yz;
      const Pack both = c * s, square = c * c - s * s, spread = k.yy - k.xx;
      const Pack twist = both * spread + square * k.xy;  // d x A d
      const Pack twist_slope = square * spread - 4.0 * both * k.xy;
      const Pack open = k.zz - friction * k_along;
      const Pack residual = across * open + a * (k_across - friction * twist);
      const Pack slope =
          -along * open - across * friction * k_across - a * (k_along + friction * twist_slope);
      active = active & (magnitude(slope) > zero);
      const Pack half_turn = clamp(-0.5 * residual / slope, broadcast(-0.25), broadcast(0.25));
      const Pack h2 = half_turn * half_turn, scale = one / (one + h2);
      const Pack c_next = scale * ((one - h2) * c - 2.0 * half_turn * s);
      const Pack s_next = scale * ((one - h2) * s + 2.0 * half_turn * c);
      c = select(active, c_next, c);
      s = select(active, s_next, s);
      // Newton squares the last turn: below rounding after this step.
      const Mask done = active & (mask_of(!sharp) | (magnitude(half_turn) < broadcast(1e-9)));
      turned = turned | done;
      active = active & negated(done);
    }
    if (!any(turned)) return turned;
    const Pack open = k.zz - friction * (c * k.xz + s * k.yz);
    const Pack normal = a / open;
    const Pack3 found{-friction * normal * c, -friction * normal * s, normal};
    const Pack slip = dot({c, s, zero}, free + k.apply(found));
    const Mask good = turned & (open > 1e-9 * k.zz) & (slip >= -1e-12 * norm(free));
    impulse = select(good, found, impulse);
    return good;
  }
};

// Coulomb's law at one point: velocity without its impulse `free`.
inline Pack3 solve_point(const ContactSlot& p, const Pack3& free, const ContactBodies& body, Mask where,
                         bool alone) {
  const double friction = body.friction;
  const Pack zero = broadcast(0.0);
  const Mask loaded = where & (free.z < p.target);
  Pack3 impulse = broadcast(0.0, 0.0, 0.0);
  if (!any(loaded)) return impulse;
  if (!body.cone) {
    impulse.z = select(loaded, (p.target - free.z) / p.response.zz, zero);
    return impulse;
  }
  const Pack3 stick = p.stiffness.apply({-free.x, -free.y, p.target - free.z});
  const Mask sticks = loaded & (stick.z >= zero) &
                      (stick.x * stick.x + stick.y * stick.y <= friction * friction * stick.z * stick.z);
  impulse = select(sticks, stick, impulse);
  Mask left = loaded & negated(sticks);
  if (!any(left)) return impulse;
  const Slide slide{p.response, free, p.target, friction};
  const Pack before = root(p.impulse.x * p.impulse.x + p.impulse.y * p.impulse.y);
  const Pack slip = root(free.x * free.x + free.y * free.y);
  const Mask warm = left & (before > zero);
  if (any(warm)) {
    const Mask good = slide.newton(-p.impulse.x / before, -p.impulse.y / before, warm, alone, impulse);
    left = left & negated(good);
  }
  // Cold, first against the tangential impulse that would stick, then along the free slip.
  const Pack hold = root(stick.x * stick.x + stick.y * stick.y);
  const Mask held = left & (hold > zero);
  if (any(held)) {
    const Mask good = slide.newton(-stick.x / hold, -stick.y / hold, held, true, impulse);
    left = left & negated(good);
  }
  const Mask slips = left & (slip > zero);
  if (any(slips)) {
    const Mask good = slide.newton(free.x / slip, free.y / slip, slips, true, impulse);
    left = left & negated(good);
  }
  for (unsigned b = bits(left); b; b &= b - 1) {
    const int l = __builtin_ctz(b);
    const double k[6] = {get(p.response.xx, l), get(p.response.xy, l), get(p.response.xz, l),
                         get(p.response.yy, l), get(p.response.yz, l), get(p.response.zz, l)};
    const double f[3] = {get(free.x, l), get(free.y, l), get(free.z, l)};
    double out[3];
    lanes::solve_hard_point(k, f, get(p.target, l), friction, out);
    set(impulse.x, l, out[0]), set(impulse.y, l, out[1]), set(impulse.z, l, out[2]);
  }
  return impulse;
}

// The normal velocities of points by three coordinates: with the rows J_i = (1, L^T (r_i x up)), L L^T the
// horizontal inverse inertia times the mass, the matrix of the normal problem is J J^T over the mass.
struct NormalRows {
  Pack l00, l10, l11;

  explicit NormalRows(const ContactBodies& body) {
    const Symmetric& w = body.inverse_inertia;
    const Pack mass = 1.0 / body.inverse_mass;
    l00 = root(mass * w.xx);
    l10 = mass * w.xy / l00;
    l11 = root(positive(mass * w.yy - l10 * l10));
  }
  Pack3 operator()(const ContactSlot& p) const {
    return {broadcast(1.0), l00 * p.arm.y - l10 * p.arm.x, -l11 * p.arm.x};
  }
};

// Without friction: the exact solution, one simulation at a time.
inline void solve_smooth(const ContactBodies& body, ContactSlot* slot, int n, Mask where, Pack3& velocity,
                         Pack3& spin) {
  const NormalRows row(body);
  for (unsigned b = bits(where); b; b &= b - 1) {
    const int l = __builtin_ctz(b);
    double rows[lanes::kMostSmooth][3], wanted[lanes::kMostSmooth], push[lanes::kMostSmooth];
    int index[lanes::kMostSmooth], count = 0;
    for (int i = 0; i < n && count < lanes::kMostSmooth; ++i) {
      const ContactSlot& p = slot[i];
      if (!get_bit(p.valid, l)) continue;
      const Pack3 j = row(p);
      rows[count][0] = get(j.x, l), rows[count][1] = get(j.y, l), rows[count][2] = get(j.z, l);
      wanted[count] = get(p.target, l) - get(velocity.z + (spin.x * p.arm.y - spin.y * p.arm.x), l);
      index[count++] = i;
    }
    lanes::solve_smooth_contacts(rows, wanted, count, push);
    for (int i = 0; i < count; ++i) {
      set(slot[index[i]].impulse.x, l, 0.0), set(slot[index[i]].impulse.y, l, 0.0);
      set(slot[index[i]].impulse.z, l, push[i] / get(body.inverse_mass, l));
    }
  }
  for (int i = 0; i < n; ++i) {
    const ContactSlot& p = slot[i];
    const Mask pushes = where & p.valid & (p.impulse.z > broadcast(0.0));
    velocity = select(pushes, velocity + body.inverse_mass * p.impulse, velocity);
    spin = select(pushes, spin + body.inverse_inertia.apply(cross(p.arm, p.impulse)), spin);
  }
}

// What has no friction and a solution without sweeps: several points, or a single one that begins from no
// impulse. Needs neither matrices of the points nor the cone. Returns where that is so; `points` counts them.
inline Mask solve_frictionless(const ContactBodies& body, ContactSlot* slot, int n, Mask where, Pack points,
                               Pack3& velocity, Pack3& spin) {
  const Pack zero = broadcast(0.0);
  const Mask several = where & (points >= broadcast(2.0)) & mask_of(n <= lanes::kMostSmooth);
  if (any(several)) solve_smooth(body, slot, n, several, velocity, spin);
  Mask solved = several | (where & (points == zero));
  for (int i = 0; i < n; ++i) {
    ContactSlot& p = slot[i];
    const Mask cold = (p.impulse.x == zero) & (p.impulse.y == zero) & (p.impulse.z == zero);
    const Mask alone = where & p.valid & (points == broadcast(1.0)) & cold;
    if (!any(alone)) continue;
    const Pack3 turn = body.inverse_inertia.apply({p.arm.y, -p.arm.x, zero});
    const Pack response = body.inverse_mass + (turn.x * p.arm.y - turn.y * p.arm.x);
    const Pack speed = (velocity + cross(spin, p.arm)).z;
    const Mask pushed = alone & (speed < p.target);
    const Pack3 push{zero, zero, (p.target - speed) / response};
    p.impulse = select(pushed, push, p.impulse);
    velocity = select(pushed, velocity + body.inverse_mass * push, velocity);
    spin = select(pushed, spin + body.inverse_inertia.apply(cross(p.arm, push)), spin);
    solved = solved | alone;
  }
  return solved;
}

// Normal impulses that reach the targets without friction: the least-norm solution, so that a symmetric body
// is loaded symmetrically, and a good start for the sweeps where points are redundant.
inline void share_load(const ContactBodies& body, ContactSlot* slot, int n, Mask where, const Pack3& velocity,
                       const Pack3& spin) {
  const Pack zero = broadcast(0.0);
  const Pack mass = 1.0 / body.inverse_mass;
  const NormalRows row(body);
  Symmetric gram{zero, zero, zero, zero, zero, zero};
  Pack3 wanted = broadcast(0.0, 0.0, 0.0);
  for (int i = 0; i < n; ++i) {
    const ContactSlot& p = slot[i];
    const Mask here = where & p.valid;
    const Pack3 j = row(p);
    const Pack speed = velocity.z + (spin.x * p.arm.y - spin.y * p.arm.x);
    const Pack push = select(here, positive(p.target - speed), zero);
    const Pack one = select(here, broadcast(1.0), zero);
    gram.xx += one * j.x * j.x, gram.xy += one * j.x * j.y, gram.xz += one * j.x * j.z;
    gram.yy += one * j.y * j.y, gram.yz += one * j.y * j.z, gram.zz += one * j.z * j.z;
    wanted = wanted + push * j;
  }
  // In units of the diagonal, a determinant near 0 means points on a line.
  const Pack volume = gram.xx * gram.yy * gram.zz;
  const Pack determinant = gram.xx * (gram.yy * gram.zz - gram.yz * gram.yz) -
                           gram.xy * (gram.xy * gram.zz - gram.yz * gram.xz) +
                           gram.xz * (gram.xy * gram.yz - gram.yy * gram.xz);
  const Mask solvable = where & (determinant > 1e-10 * volume);
  if (!any(solvable)) return;
  const Symmetric solver = inverse(gram);
  const Pack3 response = mass * solver.apply(solver.apply(wanted));
  for (int i = 0; i < n; ++i)
    slot[i].impulse.z =
        select(solvable & slot[i].valid, positive(dot(row(slot[i]), response)), slot[i].impulse.z);
}

// After a sweep of a linearly converging sequence: adds what the sweeps to come would add, d r / (1 - r) for
// the last changes d, where r is their ratio to the ones before; `ready` says that those are kept from the
// last call.
inline void extrapolate(const ContactBodies& body, ContactSlot* slot, int n, Mask where, bool ready,
                        Pack3& velocity, Pack3& spin) {
  const Pack zero = broadcast(0.0), one = broadcast(1.0);
  if (!any(where)) return;
  if (ready) {
    Pack along = zero, square = zero;
    for (int i = 0; i < n; ++i) {
      along = select(slot[i].valid, along + dot(slot[i].change, slot[i].last_change), along);
      square = select(slot[i].valid, square + dot(slot[i].last_change, slot[i].last_change), square);
    }
    const Pack ratio = along / square;
    const Mask geometric = where & (ratio > broadcast(0.2)) & (ratio < broadcast(1.03));
    const Mask drifts = geometric & (ratio > broadcast(0.97));
    Pack room = broadcast(1e4);  // until the first impulse of a drift is gone
    for (int i = 0; i < n; ++i) {
      const ContactSlot& p = slot[i];
      const Mask falls = p.valid & (p.change.z < zero) & (p.impulse.z > zero);
      room = select(falls, least(room, p.impulse.z / -p.change.z), room);
    }
    const Pack factor = select(drifts, room, ratio / (one - ratio));
    for (int i = 0; i < n; ++i) {
      ContactSlot& p = slot[i];
      const Pack3 next = p.impulse + factor * p.change;
      const Mask here = geometric & p.valid & (p.impulse.z > zero) & (drifts | (next.z > zero));
      const Pack3 lifted = select(next.z > 1e-12 * p.impulse.z, next, broadcast(0.0, 0.0, 0.0));
      const Pack3 delta = lifted - p.impulse;
      p.impulse = select(here, lifted, p.impulse);
      velocity = select(here, velocity + body.inverse_mass * delta, velocity);
      spin = select(here, spin + body.inverse_inertia.apply(cross(p.arm, delta)), spin);
    }
  }
  for (int i = 0; i < n; ++i) slot[i].last_change = slot[i].change;
}

// Finds impulses with v_n >= target, J_n >= 0, complementary, |J_t| <= mu J_n, and J_t = -mu J_n along the
// remaining slip where it slips (Coulomb's law, a true cone), by block Gauss-Seidel with an exact solve at
// each point; a single point takes one sweep. Rolling and spin friction are torques about the horizontal and
// the vertical, at most their length times the normal impulse, on one point or two: more stand without
// rolling. Sweeps begin from the points' impulses and from `torque` (an angular impulse); impulses all zero,
// three points or more begin from an even share. They converge linearly: every few sweeps the rest of the
// geometric series is added at once (Aitken). `tolerance` is the largest change of any velocity (m/s, and
// rad/s times the arm) in the last sweep.
inline void solve_contacts(const ContactBodies& body, ContactSlot* slot, int n, Mask where, Pack tolerance,
                           int most_sweeps, Pack3& velocity, Pack3& spin, Pack3& torque) {
  // Of the fastest point's speed: a remainder that nobody sees, and one of four points and more on one plane.
  constexpr double kStalled = 3e-6, kStalledPlane = 3e-5;
  const Pack zero = broadcast(0.0), one = broadcast(1.0);
  const bool friction = body.cone || body.rolling_friction_m > 0.0 || body.spin_friction_m > 0.0;
  if (friction) count(Effect::friction, where);
  const Symmetric& w = body.inverse_inertia;
  Pack reach = zero, speed = zero, points = zero;
  Mask warm = none();
  for (int i = 0; i < n; ++i) {
    ContactSlot& p = slot[i];
    const Mask here = p.valid & where;
    p.impulse = select(p.valid, p.impulse, broadcast(0.0, 0.0, 0.0));
    p.change = p.last_change = broadcast(0.0, 0.0, 0.0);
    speed = select(here, greatest(speed, norm(velocity + cross(spin, p.arm))), speed);
    reach = select(here, greatest(reach, norm(p.arm)), reach);
    points = points + select(here, one, zero);
    warm = warm | (p.impulse.z > zero);
  }
  if (!friction) {
    where = where & negated(solve_frictionless(body, slot, n, where, points, velocity, spin));
    if (!any(where)) return;
  }
  for (int i = 0; i < n; ++i) {
    ContactSlot& p = slot[i];
    // columns of 1/m - [r] W [r], by (W (r x e)) x r
    const Pack3 x = cross(w.apply({zero, p.arm.z, -p.arm.y}), p.arm),
                y = cross(w.apply({-p.arm.z, zero, p.arm.x}), p.arm),
                z = cross(w.apply({p.arm.y, -p.arm.x, zero}), p.arm);
    p.response = {body.inverse_mass + x.x, x.y, x.z, body.inverse_mass + y.y, y.z, body.inverse_mass + z.z};
    p.stiffness = inverse(p.response);
  }
  const Mask redundant = where & (points >= broadcast(3.0));
  const Mask cold = where & redundant & negated(warm);
  if (any(cold)) share_load(body, slot, n, cold, velocity, spin);
  for (int i = 0; i < n; ++i) {
    const ContactSlot& p = slot[i];
    const Mask pushes =
        where & p.valid & ((p.impulse.x != zero) | (p.impulse.y != zero) | (p.impulse.z != zero));
    velocity = select(pushes, velocity + body.inverse_mass * p.impulse, velocity);
    spin = select(pushes, spin + w.apply(cross(p.arm, p.impulse)), spin);
  }

  const Mask single = points == one;
  const Mask twists =
      where & negated(redundant) & mask_of(body.rolling_friction_m > 0.0 || body.spin_friction_m > 0.0);
  torque = select(where & negated(twists), broadcast(0.0, 0.0, 0.0), torque);
  if (any(twists)) spin = select(twists, spin + w.apply(torque), spin);
  const Mask alone = single & negated(twists);  // one point, solved at once
  const Pack roll_scale = one / (w.xx * w.yy - w.xy * w.xy);
  // Redundant points that slide may have targets that no impulses reach exactly: the impulses then drift
  // between the points while the motion stands still but for a remainder. Sweeps that stopped gaining end
  // there.
  Pack previous_change = broadcast(1e300), stalled = zero;
  Mask active = where & (points > zero);
  const Pack stall = select(points >= broadcast(4.0), broadcast(kStalledPlane), broadcast(kStalled)) * speed;
  constexpr int kAccelerateEvery = 4, kLastAcceleration = 40;  // sweeps; then plain ones, lest it cycles
  for (int sweep = 0; sweep < most_sweeps && any(active); ++sweep) {
    Pack change = zero;
    for (int i = 0; i < n; ++i) {
      ContactSlot& p = slot[i];
      const Mask here = active & p.valid;
      if (!any(here)) continue;
      const Pack3 now = velocity + cross(spin, p.arm);
      const Pack3 free = now - p.response.apply(p.impulse);
      Pack3 impulse = broadcast(0.0, 0.0, 0.0);
      if (any(here & alone)) impulse = solve_point(p, free, body, here & alone, true);
      const Mask swept = here & negated(alone);
      if (any(swept)) impulse = select(alone, impulse, solve_point(p, free, body, swept, false));
      const Pack3 delta = impulse - p.impulse;
      p.change = select(here, delta, p.change);
      const Mask moved = here & ((delta.x != zero) | (delta.y != zero) | (delta.z != zero));
      p.impulse = select(moved, impulse, p.impulse);
      velocity = select(moved, velocity + body.inverse_mass * delta, velocity);
      spin = select(moved, spin + w.apply(cross(p.arm, delta)), spin);
      const Pack3 jump = p.response.apply(delta);
      change = select(
          moved,
          greatest(change, greatest(magnitude(jump.x), greatest(magnitude(jump.y), magnitude(jump.z)))),
          change);
    }
    const Mask twisting = active & twists;
    if (any(twisting)) {
      Pack normal = zero;
      for (int i = 0; i < n; ++i) normal = normal + slot[i].impulse.z;
      Pack3 wanted = torque;
      wanted.x = wanted.x - roll_scale * (w.yy * spin.x - w.xy * spin.y);
      wanted.y = wanted.y - roll_scale * (w.xx * spin.y - w.xy * spin.x);
      const Pack roll = root(wanted.x * wanted.x + wanted.y * wanted.y),
                 roll_limit = body.rolling_friction_m * normal;
      const Pack share = select(roll > roll_limit, roll_limit / roll, one);
      wanted.x = wanted.x * share;
      wanted.y = wanted.y * share;
      const Pack spin_limit = body.spin_friction_m * normal;
      wanted.z = clamp(wanted.z - spin.z / w.zz, -spin_limit, spin_limit);
      const Pack3 spin_change = w.apply(wanted - torque);
      spin = select(twisting, spin + spin_change, spin);
      torque = select(twisting, wanted, torque);
      change = select(twisting, greatest(change, reach * norm(spin_change)), change);
    }
    Mask done = (change <= tolerance) | alone;
    stalled = select(change > 0.7 * previous_change, stalled + one, zero);
    done = done | (redundant & (stalled >= broadcast(2.0)) & (change <= stall));
    previous_change = change;
    active = active & negated(done);
    if (n > 1 && sweep < kLastAcceleration && sweep % kAccelerateEvery >= kAccelerateEvery - 2)
      extrapolate(body, slot, n, active & negated(single), sweep % kAccelerateEvery == kAccelerateEvery - 1,
                  velocity, spin);
  }
}

}  // namespace ifa::IFA_LANES_NAMESPACE
