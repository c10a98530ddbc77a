"""Signatures that are in no database: of other seeds, and of a body that bounces otherwise."""

from __future__ import annotations

from dataclasses import dataclass

import ifa

SEED = 781_500_000  # one more for each body and surface; databases have seed 0
RESTITUTION_OFF = 0.10  # up and down by turns; the solver is given the nominal body
THROWS = 200  # of each of the two bodies, from which those are picked that suit


@dataclass(frozen=True)
class HeldOut:
    """Marks, and the restitution of the body that made them."""

    marks: ifa.Signature
    restitution: float


def heldout(name: str, surface: str, wanted_marks: float, count: int) -> list[HeldOut]:
    """`count` signatures of throws to rest, with as nearly `wanted_marks` marks as there are.

    The throws are those of the paper's sampling. The body's shape is kept, as its mass is not that
    of its hull: only its restitution is off, 10 % up for the first signature, down for the second,
    and so on. No throw is taken twice.
    """
    nominal, how = ifa.bodies.get(name, surface), ifa.bodies.sampling(name)
    seed = SEED + ifa.bodies.TABLE_1.index((name, surface))
    pools = []
    for k in range(2):
        sign = 1.0 if k == 0 else -1.0
        body = nominal.replace(restitution=nominal.restitution * (1.0 + sign * RESTITUTION_OFF))
        states = ifa.sample_states(body, THROWS, seed, k * THROWS, cone_rad=how.cone_rad)
        pool = []
        for i in range(THROWS):
            run = ifa.simulate(body, states[i])
            if run.status != "rest":
                continue
            try:
                marks = ifa.Signature.from_run(run, merge_gap_s=how.merge_gap_s)
            except ifa.IfaValueError:  # it makes no sound
                continue
            pool.append(HeldOut(marks, body.restitution))
        # sorting is stable: of equally many marks, the throw drawn first
        pools.append(sorted(pool, key=lambda one: abs(len(one.marks) - wanted_marks)))
    picked = [pools[i % 2][i // 2 : i // 2 + 1] for i in range(count)]
    return [one for few in picked for one in few]
