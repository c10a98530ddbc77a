"""From the kitchen: cups, a can, a carton, a basket, a bulb of garlic, a container, a spoon."""

from __future__ import annotations

import numpy as np

from ifa.bodies.composition import (
    Model,
    circle,
    corners,
    extremes,
    lathe,
    mm,
    ring,
    skin,
    solid,
    wire,
)
from ifa.bodies.entry import Entry

_STEEL, _ALUMINIUM, _CERAMIC = 7850.0, 2700.0, 2400.0
_POLYPROPYLENE, _POLYSTYRENE = 905.0, 1050.0
_BOARD = 780.0  # of liquid packaging
_GARLIC = 800.0  # with the air between its skins


def coffee_cup() -> Model:
    """A mug, its handle towards +x."""
    wall, half = 4e-3, 2e-3
    side = lathe([mm(36, 2), mm(38.5, 8), mm(39, 93)], wall, _CERAMIC)
    floor = lathe([mm(0, 5), mm(37, 5)], 6e-3, _CERAMIC)
    turn = np.radians(np.linspace(90.0, -90.0, 9))
    path = np.column_stack([0.045 + 0.025 * np.cos(turn), 0.0 * turn, 0.05 + 0.028 * np.sin(turn)])
    path = np.concatenate([[mm(39, 0, 78)], path, [mm(39, 0, 22)]])
    handle = wire(path, 5e-3, _CERAMIC)
    bend = path[1:-1]  # the handle is thicker than the rounding, by 3 mm
    vertices = np.concatenate(
        [
            bend + mm(1.8, 2.4, 0.0),
            bend + mm(1.8, -2.4, 0.0),
            bend + mm(3.0, 0.0, 0.0),
            bend[:1] + mm(0.0, 0.0, 3.0),
        ]
    )
    rings = [ring(93e-3, 39e-3), ring(8e-3, 38.5e-3), ring(half, 36e-3)]
    return Model((side, floor, handle), vertices, half, rings)


def metal_cup() -> Model:
    """A tumbler of sheet steel with a rolled rim, wider at the top."""
    sheet, roll = 0.6e-3, 1.2e-3
    top, bottom, height = 38e-3, 28e-3, 100e-3
    side = lathe([(bottom, roll), (top, height)], sheet, _STEEL)
    floor = lathe([(0.0, 3e-3), (bottom - 2e-3, 3e-3), (bottom, roll)], sheet, _STEEL)
    rim = wire(circle(top, height), 1e-3, _STEEL, closed=True)
    rings = [ring(height, top), ring(roll, bottom - roll + sheet)]
    return Model((side, floor, rim), np.empty((0, 3)), roll, rings)


def beer_can() -> Model:
    """A can of 330 ml, crushed along its axis until its ends lean towards each other."""
    count, levels = 48, 15
    angle = 2.0 * np.pi / count * np.arange(count)

    def line(s: float, radius: float | np.ndarray, sink: float = 0.0) -> np.ndarray:
        """Around the can at the share s of its length, whose axis bends as it goes."""
        lean = 0.30 * s
        across = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
        x = 9e-3 * np.sin(np.pi * s) + across[:, 0] * np.cos(lean)
        z = 62e-3 * s - sink - across[:, 0] * np.sin(lean)
        return np.column_stack([x, across[:, 1], z])

    sections = []
    for k in range(levels):
        s = (k + 1) / (levels + 1)
        depth = np.sin(np.pi * s)
        waves = 0.10 * np.cos(4.0 * angle + 9.0 * s) + 0.09 * np.cos(7.0 * angle - 14.0 * s)
        pleats = 0.10 * np.cos(6.0 * np.pi * s)
        sections.append(line(s, 29.5e-3 * (1.0 + depth * (waves + pleats - 0.04))))
    # an end: the rim stands over a flat lid
    low = [line(0.0, 0.0, -5e-3), line(0.0, 21e-3, -5e-3), line(0.0, 24.5e-3)]
    high = [line(1.0, 27e-3), line(1.0, 25e-3, 4e-3), line(1.0, 0.0, 4e-3)]
    # the wall of 0.1 mm was 115 mm long, and lies in more pleats than are drawn
    wall = skin([low[-1], *sections, high[0]], 0.26e-3, _ALUMINIUM)
    base = skin(low, 0.3e-3, _ALUMINIUM)
    lid = skin(high, 0.25e-3, _ALUMINIUM)
    vertices = extremes(np.concatenate([*sections, low[-1], high[0]]), 60)
    return Model((wall, base, lid), vertices, 0.5e-3)


def carton() -> Model:
    """An empty milk carton of half a litre, its gable closed to a fin along x."""
    half, board = 34.5e-3, 0.42e-3

    def line(z: float, x: float, y: float) -> np.ndarray:
        """Around the carton: corners at +-34.5 mm and y, the middles of its sides at x and y."""
        outline = [(half, y), (0, y), (-half, y), (-x, 0), (-half, -y), (0, -y), (half, -y), (x, 0)]
        return np.array([(*p, z) for p in outline])

    base = [line(0.0, 0.0, 0.0) * (0, 0, 1), line(0.0, half, half)]
    walls = [line(0.0, half, half), line(115e-3, half, half)]
    gable = [walls[1], line(150e-3, 10e-3, 0.6e-3), line(167e-3, 10e-3, 0.6e-3)]
    vertices = np.concatenate(
        [corners(half, half, 0.0, 115e-3), [(half, 0.0, 167e-3), (-half, 0.0, 167e-3)]]
    )
    return Model(
        (skin(base, 2.0 * board, _BOARD), skin(walls, board, _BOARD), skin(gable, board, _BOARD)),
        vertices,
        0.5e-3,
    )


def fruit_basket() -> Model:
    """A bowl of welded wire; its ribs lie around the hoops, so that it stands and rolls on them."""
    rim, base, height, ribs, thick, thin = 128e-3, 70e-3, 90e-3, 14, 2.5e-3, 1.5e-3
    share = 0.5 * np.pi * np.linspace(0.0, 1.0, 6)
    r, z = base + (rim - base) * np.sin(share), height * (1.0 - np.cos(share))
    hoops = [
        wire(circle(rim - thick, height), thick, _STEEL, closed=True),
        wire(circle(base - thick, thick), thick, _STEEL, closed=True),
        wire(circle(r[3] - thin, z[3]), thin, _STEEL, closed=True),
    ]
    rib = np.column_stack([r, np.zeros_like(r), z])
    rib = np.concatenate([[(0.0, 0.0, 0.0)], rib, [(rim - thick, 0.0, height + thick)]])
    turns = 2.0 * np.pi / ribs * np.arange(ribs)
    wires = [wire(rib, thin, _STEEL).moved((0, 0, 0), turn_rad=turn) for turn in turns]
    vertices = np.concatenate([circle(r[k], z[k], ribs) for k in (0, 2, 4, 5)])
    return Model((*hoops, *wires), vertices, thin)


def garlic() -> Model:
    """A whole bulb of nine cloves with a piece of its stem."""
    cloves, count = 9, 72
    lobes = np.abs(np.cos(0.5 * cloves * 2.0 * np.pi / count * np.arange(count)))
    profile = [(0, 8), (1, 14), (4, 21), (10, 25.5), (18, 26.5), (26, 23), (32, 17), (37, 10.5),
               (42, 6.5), (48, 5), (60, 4.5)]  # fmt: skip
    sections = []
    for z, r in profile:
        depth = 0.13 * min(1.0, r / 20.0) if 0 < z < 48 else 0.0
        sections.append(circle(1e-3 * r * (1.0 - depth * (1.0 - lobes)), 1e-3 * z, count))
    radius = 1e-3
    vertices = [
        circle(1e-3 * r - radius, 1e-3 * z, cloves) for z, r in (profile[k] for k in (2, 3, 4, 5))
    ]
    vertices.append(circle(13e-3 - radius, radius, cloves))
    vertices.append(circle(4.5e-3 - radius, 60e-3 - radius, cloves))
    return Model((solid(sections, _GARLIC),), np.concatenate(vertices), radius)


def plastic_container() -> Model:
    """A food container without its lid."""
    wall = 0.9e-3

    def line(x: float, y: float, corner: float, z: float) -> np.ndarray:
        """Around a rectangle of half sizes x and y with round corners."""
        points = []
        for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
            for step in (0.0, 0.5, 1.0):
                turn = 0.5 * np.pi * (quarter + step)
                points.append(
                    (sx * (x - corner) + corner * np.cos(turn),
                     sy * (y - corner) + corner * np.sin(turn), z)
                )  # fmt: skip
        return 1e-3 * np.array(points)

    base, top = line(75, 48, 12, 0), line(82, 55, 14, 60)
    lip, hem = line(86, 59, 17, 60), line(86.5, 59.5, 17, 56)
    sheet = skin([base * (0, 0, 1), base, top, lip, hem], wall, _POLYPROPYLENE)
    return Model((sheet,), np.concatenate([base, lip, hem]), 0.5 * wall)


def plastic_spoon() -> Model:
    """Disposable, along x with its bowl in front, at rest on bowl and handle."""
    thickness = 1.1e-3
    # x, half width, height of the edge, depth between the edges
    stations = 1e-3 * np.array(
        [(0, 3.5, 2.5, 0), (4, 5, 3, 0.8), (20, 6, 5, 1.5), (60, 4.5, 9.5, 1.8),
         (95, 3.6, 9.5, 1.8), (106, 4.6, 8.5, 2.4), (115, 10, 8, 5), (124, 14.5, 8, 7.2),
         (135, 16.5, 8, 8), (146, 15.5, 8, 7.4), (155, 12, 8, 5.6), (161, 7.5, 8, 3),
         (164, 2.5, 8, 0)]
    )  # fmt: skip
    t = np.linspace(-1.0, 1.0, 9)
    sections = [
        np.column_stack([np.full(9, x), w * t, z - d * (1.0 - t**2)]) for x, w, z, d in stations
    ]
    edges = [section[[0, -1]] for section in sections]
    keels = [section[[2, 3, 5, 6]] for section in sections[6:11]]  # flat below, as real ones are
    spoon = skin(sections, thickness, _POLYSTYRENE, around=False)
    return Model((spoon,), np.concatenate([*edges, *keels]), 0.5 * thickness)


KITCHEN = {
    "beer_can": Entry.of("330 ml, crushed to 7 cm", "foil", beer_can, wheel=2.0),
    "carton": Entry.of("70 x 70 x 168 mm, empty", "board", carton),
    "coffee_cup": Entry.of("82 mm wide, 95 mm high", "ceramic", coffee_cup, wheel=3.0),
    "fruit_basket": Entry.of("26 cm wide, 93 mm high", "wire", fruit_basket),
    "garlic": Entry.of("52 mm wide, 60 mm high", "bulb", garlic, wheel=4.0),
    "metal_cup": Entry.of("78 mm wide, 101 mm high", "sheet", metal_cup, wheel=3.0),
    "plastic_container": Entry.of("174 x 120 x 61 mm", "moulded", plastic_container),
    "plastic_spoon": Entry.of("165 x 34 x 10 mm", "moulded", plastic_spoon),
}
