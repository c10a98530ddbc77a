"""A library of everyday bodies, written from their real sizes: `get("d6", surface="desk")`.

The objects of the paper, a ball and a coin, all of our own making. Sizes and masses are of common
real things. A thing that is hollow, bent or made of several parts has the mass, centre of mass and
inertia of its parts (`parts`), and touches the ground with its rounded convex hull. Restitution and
friction are estimates, good to perhaps 0.15: they vary more between two desks than between two
kinds of dice. Fit them to the sound where it matters.
"""

from __future__ import annotations

from typing import Any

from ifa._core import IfaValueError
from ifa.bodies.composition import Part
from ifa.bodies.dice import DICE
from ifa.bodies.entry import Entry
from ifa.bodies.household import HOUSEHOLD
from ifa.bodies.kitchen import KITCHEN
from ifa.bodies.materials import MATERIALS, ROLLING_M
from ifa.bodies.paper import PAPER_NAMES, SAMPLING, TABLE_1, Sampling
from ifa.bodies.plain import PLAIN
from ifa.bodies.tools import TOOLS
from ifa.body import Body

__all__ = [
    "TABLE_1", "Part", "Sampling", "describe", "get", "names", "parts", "sampling", "surfaces",
]  # fmt: skip

_LIBRARY: dict[str, Entry] = {
    **DICE, **PLAIN, **dict(sorted({**TOOLS, **KITCHEN, **HOUSEHOLD}.items())),
}  # fmt: skip


def names() -> list[str]:
    """The names that `get` knows."""
    return list(_LIBRARY)


def surfaces() -> list[str]:
    """The surfaces that `get` knows."""
    return list(ROLLING_M)


def get(name: str, surface: str = "desk") -> Body:
    """The body `name` with its material on `surface`.

    Raises:
        IfaValueError: no such body or surface; the message lists those that exist.
    """
    entry = _entry(name)
    if not isinstance(surface, str) or surface not in ROLLING_M:
        raise IfaValueError(f"surface: no '{surface}'; there are {', '.join(ROLLING_M)}")
    restitution, friction = MATERIALS[entry.material][surface]
    return entry.make(
        name=name,
        restitution=restitution,
        friction=friction,
        rolling_friction_m=ROLLING_M[surface] * entry.wheel,
        spin_friction_m=ROLLING_M[surface],
    )


def parts(name: str) -> tuple[Part, ...]:
    """What the body `name` is put together from; none where it is one solid piece.

    Their axes are those in which `get(name).centre_of_mass_m` is. Raises IfaValueError as `get`.
    """
    return _entry(name).parts()


def sampling(name: str) -> Sampling:
    """How the paper samples and hears the body `name`. Raises IfaValueError as `get`."""
    _entry(name)
    return SAMPLING.get(name, Sampling())


def describe() -> list[dict[str, Any]]:
    """One entry for each body.

    `name`, `paper_name` (None: not in the paper) and `paper_surfaces` of its Table 1; `size`,
    `material`, `mass_kg`, `radius_m`, `vertices` and `rings` (how many); `cone_rad` and
    `merge_gap_s` as in `Sampling`; and `surfaces`, which maps each to its `restitution` and
    `friction`.
    """
    rows = []
    for name, entry in _LIBRARY.items():
        body, how = get(name), sampling(name)
        rows.append(
            {
                "name": name,
                "paper_name": PAPER_NAMES.get(name),
                "paper_surfaces": [surface for row, surface in TABLE_1 if row == name],
                "size": entry.size,
                "material": entry.material,
                "mass_kg": body.mass_kg,
                "radius_m": body.radius_m,
                "vertices": len(body.vertices_m),
                "rings": len(body.rings_m),
                "cone_rad": how.cone_rad,
                "merge_gap_s": how.merge_gap_s,
                "surfaces": {
                    surface: {"restitution": restitution, "friction": friction}
                    for surface, (restitution, friction) in MATERIALS[entry.material].items()
                },
            }
        )
    return rows


def _entry(name: str) -> Entry:
    entry = _LIBRARY.get(name) if isinstance(name, str) else None
    if entry is None:
        raise IfaValueError(f"body: no {name!r} in the library; it has {', '.join(_LIBRARY)}")
    return entry
