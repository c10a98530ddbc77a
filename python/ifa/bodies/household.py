"""From desk, wardrobe and toy box: bricks, a keyboard, a ball of paper, a hanger, sticky tape."""

from __future__ import annotations

import numpy as np

from ifa.bodies.composition import (
    Model,
    Part,
    box,
    circle,
    corners,
    directions,
    extremes,
    mm,
    plate,
    ring,
    skin,
    solid,
    tube,
    wire,
)
from ifa.bodies.entry import Entry

_ABS, _STEEL, _TAPE = 1040.0, 7850.0, 950.0


def _brick(columns: int) -> Model:
    """Two rows of studs, hollow below; along x."""
    pitch, wall, top, height = 8e-3, 1.5e-3, 1e-3, 9.6e-3
    stud, stud_height = 2.4e-3, 1.7e-3
    half_x, half_y = 0.5 * (columns * pitch - 0.2e-3), 0.5 * (2 * pitch - 0.2e-3)
    side = height - top
    parts = [box((2 * half_x, 2 * half_y, top), (0, 0, height - 0.5 * top), _ABS)]
    for sign in (1, -1):
        y, x = sign * (half_y - 0.5 * wall), sign * (half_x - 0.5 * wall)
        parts.append(box((2 * half_x, wall, side), (0, y, 0.5 * side), _ABS))
        parts.append(box((wall, 2 * (half_y - wall), side), (x, 0, 0.5 * side), _ABS))
    along = pitch * (np.arange(columns) - 0.5 * (columns - 1))
    tip = height + stud_height
    for x in along:
        for y in (0.5 * pitch, -0.5 * pitch):
            parts.append(tube((x, y, height), (x, y, tip), stud, _ABS))
    for x in 0.5 * (along[1:] + along[:-1]):
        parts.append(tube((x, 0, 0), (x, 0, side), 3.255e-3, _ABS, inner_m=stud))
    radius = 0.1e-3
    vertices = corners(half_x - radius, half_y - radius, radius, height - radius)
    rings = [
        [x, y, tip - radius, 0.0, 0.0, 1.0, stud - radius]
        for x in (along[0], along[-1])
        for y in (0.5 * pitch, -0.5 * pitch)
    ]
    return Model(tuple(parts), vertices, radius, rings)


def lego_2x2() -> Model:
    """Two by two studs."""
    return _brick(2)


def lego_2x4() -> Model:
    """Two by four studs."""
    return _brick(4)


def keyboard() -> Model:
    """Full size, the space bar towards -y; a wedge with keys on its slope."""
    half_x, half_y, front, back = 220e-3, 70e-3, 12e-3, 24e-3
    # circuit, membrane and air within: in all 0.6 kg
    inside, cap = 450.0, 450.0
    wedge = solid(
        [
            [(x, -half_y, 0), (x, half_y, 0), (x, half_y, back), (x, -half_y, front)]
            for x in (-half_x, half_x)
        ],
        inside,
    )
    slope = np.arctan2(back - front, 2.0 * half_y)
    pitch, gap, tall = 19e-3, 2e-3, 7e-3
    rows = -52e-3 + pitch * np.arange(6)  # from the space bar; the top one stands apart
    rows[5] += 6e-3
    main, cursor, pad = -208e-3, 87e-3, 150e-3  # where blocks of keys begin

    def key(x: float, row: int, units: float = 1.0) -> Part:
        width = units * pitch - gap
        middle = (x + 0.5 * units * pitch, rows[row], 0.5 * tall)
        upright = box((width, pitch - gap, tall), middle, cap)
        return upright.moved((0, 0, 0.5 * (front + back)), axis=0, turn_rad=slope)

    widths = [
        [1.25, 1.25, 1.25, 6.25, 1.25, 1.25, 1.25, 1.25],
        [2.25, *[1.0] * 10, 2.75],
        [1.75, *[1.0] * 11, 2.25],
        [1.5, *[1.0] * 12, 1.5],
        [*[1.0] * 13, 2.0],
        [1.0] * 15,
    ]
    keys = []
    for row, units in enumerate(widths):
        starts = main + pitch * np.concatenate([[0.0], np.cumsum(units)[:-1]])
        keys += [key(x, row, w) for x, w in zip(starts, units, strict=True)]
    keys += [key(cursor + pitch * k, row) for row in (0, 3, 4) for k in range(3)]
    keys.append(key(cursor + pitch, 1))
    keys += [key(pad + pitch * k, row) for row in range(5) for k in range(3)]
    radius = 1e-3
    tops = corners(208e-3 - radius, 0.0, 0.0)[:2]
    edge = np.array(
        [(x, y, tall - radius) for x, _, _ in tops for y in (rows[0] - 8e-3, rows[5] + 8e-3)]
    )
    edge = edge @ np.array(
        [[1, 0, 0], [0, np.cos(slope), np.sin(slope)], [0, -np.sin(slope), np.cos(slope)]]
    ) + (0, 0, 0.5 * (front + back))
    case = [
        (x, y, z)
        for x in (half_x - radius, radius - half_x)
        for y, high in ((radius - half_y, front), (half_y - radius, back))
        for z in (radius, high - radius)
    ]
    return Model((wedge, *keys), np.concatenate([case, edge]), radius)


def paper_ball() -> Model:
    """A crumpled sheet of A4 (5 g), as a solid with creases."""

    def reach(unit: np.ndarray) -> np.ndarray:
        """Distance of the surface in directions (n, 3); creases where a sine changes its sign."""
        folds = sum(
            np.abs(np.sin(f * unit @ d + 1.3 * k))
            for k, (d, f) in enumerate(zip(directions(9), (3, 4, 5, 4, 3, 5, 4, 3, 5), strict=True))
        )
        return 24e-3 + 1.6e-3 * (folds - 5.0)

    polar = np.linspace(0.0, np.pi, 19)
    sections = []
    for theta in polar:
        unit = circle(np.sin(theta), np.cos(theta), 36)
        sections.append(unit * reach(unit)[:, None])
    ball = solid(sections, 1.0)
    ball = solid(sections, 5e-3 / ball.mass_kg)
    radius = 0.5e-3
    points = np.concatenate(sections)
    inner = points * (1.0 - radius / np.linalg.norm(points, axis=1, keepdims=True))
    return Model((ball,), extremes(inner, 60), radius)


def coat_hanger() -> Model:
    """Of bent steel wire, in the plane of x and z."""
    radius = 1.2e-3
    hook_m = 26e-3
    outline = [
        (-196, -2), (-203, 2), (-205, 8), (-201, 13), (-110, 58), (-10, 100), (0, 105),
        (10, 100), (110, 58), (201, 13), (205, 8), (203, 2), (196, -2),
    ]  # fmt: skip
    turn = np.radians(np.arange(-90.0, 196.0, 15.0))
    hook = np.column_stack([hook_m * np.cos(turn), 158e-3 + hook_m * np.sin(turn)])
    hook = np.concatenate([[(0.0, 132e-3)], hook[2:]])

    def upright(points: np.ndarray) -> np.ndarray:
        return np.column_stack([points[:, 0], np.zeros(len(points)), points[:, 1]])

    frame = upright(1e-3 * np.array(outline, float))
    twist = [(0.0, 0.0, z) for z in (105e-3, 132e-3)]
    parts = (
        wire(frame, radius, _STEEL, closed=True),
        wire(twist, radius * np.sqrt(2.0), _STEEL),  # two wires around each other
        wire(upright(hook), radius, _STEEL),
    )
    return Model(parts, np.concatenate([frame, upright(hook)]), radius)


def tape_dispenser() -> Model:
    """A small one for the hand, lying on its side: a roll along z, its cutter towards +x."""
    wall, half, core, roll, case = 1.8e-3, 11e-3, 13e-3, 25e-3, 29e-3
    tape = tube((0, 0, 1.2e-3 - half), (0, 0, half - 2e-3), roll, _TAPE, inner_m=core)
    hub = tube((0, 0, -half), (0, 0, half), core - 0.5e-3, _ABS, inner_m=core - 2.5e-3)
    web = tube((0, 0, -half), (0, 0, 1e-3 - half), case, _ABS, inner_m=core)
    turn = np.radians(np.linspace(50.0, 270.0, 23))
    back = case * np.column_stack([np.cos(turn), np.sin(turn)])
    outline = np.concatenate(
        [back, 1e-3 * np.array([(38, -29), (66, -26), (70, -17), (66, -12), (38, -8)])]
    )
    strip = skin(
        [np.column_stack([outline, np.full(len(outline), z)]) for z in (-half, half)],
        wall, _ABS, around=False,
    )  # fmt: skip
    cheek = plate(
        1e-3 * np.array([(24, -17), (38, -8), (66, -12), (70, -17)]),
        1e-3 * np.array([(10, -28), (38, -29), (66, -26), (69, -20)]),
        -half, 1e-3 - half, _ABS,
    )  # fmt: skip
    blade = box(mm(1.0, 6.0, 20.0), mm(70.5, -16, 0), _STEEL)
    radius = 0.5 * wall
    snout = outline[-5:]
    vertices = np.concatenate(
        [np.column_stack([[*snout, (70e-3, -13e-3)], np.full(6, z)]) for z in (-half, half)]
    )
    return Model(
        (tape, hub, web, strip, cheek, blade),
        vertices,
        radius,
        [ring(z, case) for z in (half, -half)],
    )


HOUSEHOLD = {
    "coat_hanger": Entry.of("41 cm wide, wire 2.4 mm", "wire", coat_hanger),
    "keyboard": Entry.of("440 x 140 x 30 mm", "moulded", keyboard),
    "lego_2x2": Entry.of("15.8 x 15.8 x 11.3 mm", "abs", lego_2x2),
    "lego_2x4": Entry.of("31.8 x 15.8 x 11.3 mm", "abs", lego_2x4),
    "paper_ball": Entry.of("about 5 cm, a sheet of A4", "paper", paper_ball),
    "tape_dispenser": Entry.of("100 x 60 x 24 mm", "moulded", tape_dispenser, wheel=2.0),
}
