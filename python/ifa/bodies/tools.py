"""Tools and fasteners: wrenches, a bolt, a nut, a dustpan."""

from __future__ import annotations

import numpy as np

from ifa.bodies.composition import (
    Model,
    Part,
    circle,
    mm,
    plate,
    ring,
    skin,
    solid,
    tube,
)
from ifa.bodies.entry import Entry

_STEEL = 7850.0
_POLYPROPYLENE = 905.0

# M8: width across flats, height of nut and head, thread over and under, pitch
_FLATS_M, _NUT_M, _HEAD_M = 13e-3, 6.5e-3, 5.3e-3
_THREAD_M, _CORE_M, _PITCH_M = 8e-3, 6.6e-3, 1.25e-3
_CHAMFER_M = 6.1e-3  # radius to which the corners of a hexagon are turned off
_CHAMFER_SLOPE = np.tan(np.radians(30.0))


def _hexagon(count: int) -> np.ndarray:
    """Distances (count,) to a hexagon of width 13 mm across flats, a corner on the x axis."""
    angle = np.mod(2.0 * np.pi / count * np.arange(count), np.pi / 3.0) - np.pi / 6.0
    return 0.5 * _FLATS_M / np.cos(angle)


def _extruded(outline_m: np.ndarray, half_m: float) -> np.ndarray:
    """Points (2 n, 3) of an outline (n, 2) at z = `half_m` and minus that."""
    return np.concatenate(
        [np.column_stack([outline_m, np.full(len(outline_m), z)]) for z in (half_m, -half_m)]
    )


def nut() -> Model:
    """M8, chamfered on both sides; along z."""
    count = 48
    outer, half = _hexagon(count), 0.5 * _NUT_M
    edge = half - (outer - _CHAMFER_M) * _CHAMFER_SLOPE
    bore = 0.5 * 0.5 * (_THREAD_M + _CORE_M)  # to the middle of the thread
    lines = [
        circle(bore, -half, count), circle(_CHAMFER_M, -half, count), circle(outer, -edge, count),
        circle(outer, edge, count), circle(_CHAMFER_M, half, count), circle(bore, half, count),
    ]  # fmt: skip
    body = solid(list(np.stack(lines, axis=1)), _STEEL, closed=True)
    radius = 0.2e-3
    corner = edge[0] - radius
    vertices = np.concatenate([circle(outer[0] - radius, z, 6) for z in (corner, -corner)])
    rings = [ring(z, _CHAMFER_M - radius) for z in (half - radius, radius - half)]
    return Model((body,), vertices, radius, rings)


def bolt() -> Model:
    """M8 x 40, threaded all along; along z, its tip at z = 0."""
    length, count = 40e-3, 48
    top = length + _HEAD_M
    outer = _hexagon(count)
    edge = top - (outer - _CHAMFER_M) * _CHAMFER_SLOPE
    head = solid(
        [circle(outer, length, count), circle(outer, edge, count), circle(_CHAMFER_M, top, count)],
        _STEEL,
    )
    crests = np.arange(0.5 * _PITCH_M, length, _PITCH_M)
    sections = [circle(0.5 * _CORE_M, 0.0, 24)]
    for z in crests:
        sections += [circle(0.5 * _THREAD_M, z, 24), circle(0.5 * _CORE_M, z + 0.5 * _PITCH_M, 24)]
    thread = solid([*sections[:-1], circle(0.5 * _CORE_M, length, 24)], _STEEL)
    radius = 0.2e-3
    vertices = np.concatenate(
        [circle(outer[0] - radius, z, 6) for z in (length + radius, edge[0] - radius)]
    )
    rings = [
        ring(top - radius, _CHAMFER_M - radius),
        ring(crests[0], 0.5 * _THREAD_M - radius),
        ring(radius, 0.5 * _CORE_M - radius),
    ]
    return Model((head, thread), vertices, radius, rings)


def wrench() -> Model:
    """A combination wrench for M8: a ring at x = 0, an open jaw at the other end."""
    ring_m, ring_half = 10e-3, 4.25e-3
    eye = tube((0, 0, -ring_half), (0, 0, ring_half), ring_m, _STEEL, inner_m=7e-3)
    x = np.array([9.0, 20.0, 70.0, 125.0, 134.0])
    width = np.array([5.0, 5.0, 5.5, 6.0, 7.0])
    left = 1e-3 * np.column_stack([x, width])
    shaft = plate(left, left * (1, -1), -2.75e-3, 2.75e-3, _STEEL)
    outer = [(14, 8.5), (10.5, 12), (5, 14), (-2, 14), (-9, 10.7), (-14, 0)]
    inner = [(14, 6.5), (10.5, 6.5), (5, 6.5), (-1, 6.5), (-4, 4.5), (-5.5, 0)]
    outer_m, inner_m = (
        1e-3 * np.array([*half, *((u, -v) for u, v in half[-2::-1])]) for half in (outer, inner)
    )
    at, turn, jaw_half = mm(146, 0, 0), np.radians(15.0), 3.25e-3
    jaw = plate(outer_m, inner_m, -jaw_half, jaw_half, _STEEL).moved(at, turn_rad=turn)
    radius = 0.5e-3
    outline = outer_m * (1.0 - radius / 14e-3)
    turned = outline @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]] + at[:2]
    rings = [ring(z, ring_m - radius) for z in (ring_half - radius, radius - ring_half)]
    return Model((eye, shaft, jaw), _extruded(turned, jaw_half - radius), radius, rings)


def adjustable_wrench() -> Model:
    """Of 8 inches: a handle with a hole along x, and a head turned by 22.5 degrees."""
    head_half, handle_half, web_half = 6e-3, 5e-3, 1.5e-3
    x = np.array([-101.0, -60.0, 10.0, 30.0])
    width = np.array([11.0, 10.0, 9.0, 12.0])
    edge, inside = (1e-3 * np.column_stack([x, w]) for w in (width, width - 4.0))
    flanges = [
        plate(edge * side, inside * side, -handle_half, handle_half, _STEEL)
        for side in ((1, 1), (1, -1))
    ]
    web = plate(inside, inside * (1, -1), -web_half, web_half, _STEEL)
    eye_m, eye_x = 12e-3, -107e-3
    eye = tube((eye_x, 0, -head_half), (eye_x, 0, head_half), eye_m, _STEEL, inner_m=6e-3)

    def slab(left: list[tuple[float, float]], right: list[tuple[float, float]]) -> Part:
        return plate(1e-3 * np.array(left), 1e-3 * np.array(right), -head_half, head_half, _STEEL)

    # In the head's own axes: x the way the jaws open, y across them.
    head = [
        slab([(-2, -23), (0, -10)], [(-11, -23), (-24, -10)]),
        slab([(0, 4), (0, 20), (0, 26)], [(-26, 4), (-20, 20), (-8, 26)]),
        slab([(0, -10), (0, 4)], [(-4, -10), (-4, 4)]),  # around the window of the worm
        slab([(-17, -10), (-17, 4)], [(-24, -10), (-26, 4)]),
        slab([(0, 7), (10, 7), (20, 7), (29, 7)], [(0, 26), (10, 25), (20, 21), (29, 14)]),
        slab([(0, -7), (10, -7), (20, -7), (28, -7)], [(0, -25), (10, -23), (20, -19), (28, -13)]),
        tube(mm(-10.5, -9, 0), mm(-10.5, 3, 0), 6e-3, _STEEL),
    ]
    at, turn = mm(48, 0, 0), np.radians(22.5)
    head = [part.moved(at, turn_rad=turn) for part in head]
    radius = 0.5e-3
    outline = 1e-3 * np.array(
        [(28.5, 13.7), (28.5, 7.5), (19.8, 20.5), (9.8, 24.5), (0, 25.5), (-7.7, 25.5),
         (-19.8, 19.5), (27.5, -12.7), (27.5, -7.5), (19.8, -18.5), (9.8, -22.5), (0, -24.5),
         (-2, -22.8), (-10.8, -22.5), (-23.7, -9.5)]
    )  # fmt: skip
    outline = outline @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]] + at[:2]
    end = circle(eye_m - radius, 0.0, 16)[4:13, :2] + (eye_x, 0.0)
    vertices = _extruded(np.concatenate([outline, end]), head_half - radius)
    return Model((*flanges, web, eye, *head), vertices, radius)


def dustpan() -> Model:
    """Its lip at the front, x = 205 mm; floor at z = 0, a hollow handle behind."""
    thickness = 2e-3
    corners = [mm(205, 112, 0), mm(0, 100, 0), mm(0, -100, 0), mm(205, -112, 0)]
    tops = [mm(205, 113, 6), mm(-8, 104, 55), mm(-8, -104, 55), mm(205, -113, 6)]
    floor = skin([corners[:2], corners[:1:-1]], thickness, _POLYPROPYLENE, around=False)
    walls = skin([corners, tops], thickness, _POLYPROPYLENE, around=False)
    angle = np.pi / 4.0 * (np.arange(8) + 0.5)
    tubes = []
    for x, z, wide, high in (
        (-4, 40, 20, 11),
        (-30, 42, 13, 9),
        (-75, 46, 14, 9),
        (-118, 50, 17, 9),
        (-128, 51, 12, 6),
        (-128, 51, 0, 0),
    ):
        tubes.append(
            1e-3 * np.column_stack([np.full(8, x), wide * np.cos(angle), z + high * np.sin(angle)])
        )
    handle = skin(tubes, thickness, _POLYPROPYLENE)
    vertices = np.concatenate([corners, tops, tubes[3], tubes[4]])
    return Model((floor, walls, handle), vertices, 0.5 * thickness)


TOOLS = {
    "adjustable_wrench": Entry.of("200 mm (8 inch)", "metal", adjustable_wrench),
    "bolt": Entry.of("M8 x 40", "metal", bolt),
    "dustpan": Entry.of("335 x 228 x 60 mm", "moulded", dustpan),
    "nut": Entry.of("M8", "metal", nut),
    "wrench": Entry.of("170 mm, for M8", "metal", wrench),
}
