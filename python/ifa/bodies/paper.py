"""The objects of the paper: their names there, its Table 1, and how it sampled and heard them.

T. R. Langlois and D. L. James, Inverse-Foley Animation, ACM Transactions on Graphics 33(4), 2014.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

PAPER_NAMES = {
    "adjustable_wrench": "AdjustableWrench",
    "beer_can": "BeerCanCrushed",
    "bolt": "Bolt",
    "carton": "Carton",
    "coat_hanger": "CoatHanger",
    "coffee_cup": "CoffeeCup",
    "card": "CreditCard",
    "d4": "d4",
    "d6": "d6",
    "d8": "d8",
    "d10": "d10",
    "d12": "d12",
    "d20": "d20",
    "dustpan": "Dustpan",
    "eraser": "Eraser",
    "fruit_basket": "FruitBasket",
    "garlic": "Garlic",
    "keyboard": "Keyboard",
    "lego_2x2": "Lego2x2",
    "lego_2x4": "Lego2x4",
    "metal_cup": "MetalCup",
    "nut": "Nut",
    "paper_ball": "PaperBall",
    "plastic_container": "PlasticContainer",
    "plastic_spoon": "PlasticSpoon",
    "tape_dispenser": "TapeDispenser",
    "wrench": "Wrench",
}

_SURFACES = {  # in the paper's order; the desk for all others
    "beer_can": ("wood",),
    "dustpan": ("wood", "carpet"),
    "fruit_basket": ("wood", "carpet"),
    "garlic": ("wood",),
    "keyboard": ("carpet",),
    "metal_cup": ("desk", "carpet"),
    "tape_dispenser": ("wood", "desk"),
}

TABLE_1 = tuple(
    (name, surface) for name in PAPER_NAMES for surface in _SURFACES.get(name, ("desk",))
)


@dataclass(frozen=True)
class Sampling:
    """How to sample a body's states before a contact, and how to hear its contacts.

    `cone_rad`, of `ifa.sample_states`: velocities within this angle about straight down.
    `merge_gap_s`: contacts less than this apart are one event (section 4).
    """

    cone_rad: float = float(np.pi / 6.0)
    merge_gap_s: float = 0.010


# Rolling motions are common (footnote 1). Sounds are continuous, not many small events (section 4).
_ROLLS, _CHATTERS = float(np.radians(80.0)), 0.030
SAMPLING = {
    "bolt": Sampling(cone_rad=_ROLLS),
    "nut": Sampling(cone_rad=_ROLLS, merge_gap_s=_CHATTERS),
    "beer_can": Sampling(merge_gap_s=_CHATTERS),
    "garlic": Sampling(merge_gap_s=_CHATTERS),
}
