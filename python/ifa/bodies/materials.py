"""Restitution and friction on each surface. Estimates, good to perhaps 0.15.

They vary more between two desks than between two kinds of dice. Fit them to the sound where it
matters.
"""

from __future__ import annotations

# (restitution, friction)
MATERIALS = {
    "resin": {"desk": (0.50, 0.25), "wood": (0.45, 0.30), "carpet": (0.15, 0.55)},
    "rubber": {"desk": (0.80, 0.70), "wood": (0.75, 0.70), "carpet": (0.50, 0.90)},
    "metal": {"desk": (0.45, 0.20), "wood": (0.40, 0.30), "carpet": (0.10, 0.45)},
    "vinyl": {"desk": (0.35, 0.60), "wood": (0.35, 0.60), "carpet": (0.15, 0.80)},
    "plastic": {"desk": (0.25, 0.25), "wood": (0.25, 0.30), "carpet": (0.05, 0.50)},
    # Thin sheet and wire lose more to their own vibration than solid metal does.
    "sheet": {"desk": (0.35, 0.20), "wood": (0.30, 0.30), "carpet": (0.10, 0.45)},
    "wire": {"desk": (0.30, 0.25), "wood": (0.30, 0.30), "carpet": (0.10, 0.50)},
    "foil": {"desk": (0.25, 0.30), "wood": (0.25, 0.35), "carpet": (0.10, 0.50)},
    "ceramic": {"desk": (0.40, 0.30), "wood": (0.35, 0.35), "carpet": (0.10, 0.50)},
    "abs": {"desk": (0.50, 0.25), "wood": (0.45, 0.30), "carpet": (0.15, 0.50)},
    "moulded": {"desk": (0.40, 0.30), "wood": (0.35, 0.30), "carpet": (0.15, 0.50)},
    "board": {"desk": (0.25, 0.40), "wood": (0.25, 0.40), "carpet": (0.10, 0.60)},
    "paper": {"desk": (0.20, 0.45), "wood": (0.20, 0.45), "carpet": (0.10, 0.60)},
    "bulb": {"desk": (0.35, 0.45), "wood": (0.30, 0.45), "carpet": (0.15, 0.60)},
}
# Lever arm of the rolling and spinning resistance, of things as large as a coin.
ROLLING_M = {"desk": 5e-5, "wood": 8e-5, "carpet": 1e-3}
