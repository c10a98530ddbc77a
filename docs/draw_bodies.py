"""Draw the library's bodies for docs/bodies.md: `.venv/bin/python docs/draw_bodies.py`.

One PNG a body in docs/bodies, from its parts (or its hull, where it is one piece); with --sheet
FILE all of them in one picture instead. A depth buffer hides what is behind; lines are drawn where
the depth or the direction of the surface jumps.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import ifa
import numpy as np
from ifa.bodies.composition import directions
from PIL import Image  # matplotlib needs it too

_SIZE = np.array([200, 150])  # of a picture, in pixels
_FINE = 3  # samples a pixel, each way
_MARGIN = 0.06
_LIGHT = np.array([-0.40, 0.62, 0.68])  # in the axes of the picture: right, up, to the viewer
_FOLD = np.cos(np.radians(28.0))  # surfaces that meet at more than this angle have a line between
_INK = np.array([34, 49, 63])
_COLOURS = {
    "resin": (204, 72, 62), "rubber": (232, 140, 66), "metal": (160, 168, 178),
    "vinyl": (240, 236, 226), "plastic": (82, 124, 184), "sheet": (186, 194, 202),
    "wire": (150, 156, 164), "foil": (176, 196, 154), "ceramic": (232, 224, 206),
    "abs": (214, 64, 54), "moulded": (122, 170, 192), "board": (236, 230, 216),
    "paper": (246, 244, 238), "bulb": (240, 230, 222),
}  # fmt: skip
# Azimuth and elevation of the viewer, in degrees.
_VIEW = (-60.0, 28.0)
_VIEWS = {
    "d4": (-65, 20),
    "adjustable_wrench": (-90, 62), "beer_can": (-75, 16), "bolt": (-60, 24), "card": (-70, 40),
    "coat_hanger": (-80, 6), "coffee_cup": (-55, 24), "coin": (-60, 42), "dustpan": (28, 38),
    "fruit_basket": (-60, 30), "garlic": (-60, 12), "keyboard": (-78, 44), "nut": (-60, 42),
    "plastic_spoon": (-50, 40), "tape_dispenser": (-80, 58), "wrench": (-85, 58),
}  # fmt: skip

_ON_A_FACE = ("d4",)  # their axes stand otherwise


def faces(name: str) -> np.ndarray:
    """Triangles (m, 3, 3) of the body's parts; else of its hull, and for a ball of many points."""
    parts = ifa.bodies.parts(name)
    if parts:
        return np.concatenate([part.points_m[part.triangles] for part in parts])
    body = ifa.bodies.get(name)
    if len(body.outline_m) == 1:
        body = ifa.Body.from_vertices(directions(1500) * body.radius_m, mass_kg=body.mass_kg)
    return body.outline_m[body.triangles]


def draw(name: str, material: str) -> Image.Image:
    """The body, shaded, on a transparent ground."""
    azimuth, elevation = np.radians(_VIEWS.get(name, _VIEW))
    toward = np.array([np.cos(azimuth), np.sin(azimuth), 0.0]) * np.cos(elevation)
    toward[2] = np.sin(elevation)
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    triangles = faces(name)
    if name in _ON_A_FACE:
        triangles = triangles @ _upright(triangles[0])
    seen = triangles @ np.column_stack([right, np.cross(toward, right), toward])

    size = _FINE * _SIZE
    low, high = seen.min(axis=(0, 1)), seen.max(axis=(0, 1))
    scale = ((1.0 - 2.0 * _MARGIN) * size / (high - low)[:2]).min()
    seen = (seen - 0.5 * (low + high)) * scale
    seen[:, :, :2] += 0.5 * size
    depth, normal = _rasterise(seen, size)

    there = np.isfinite(depth)
    light = np.abs(normal @ (_LIGHT / np.linalg.norm(_LIGHT)))
    shade = 0.50 + 0.50 * light
    colour = np.where(there[..., None], shade[..., None] * _COLOURS[material], 0.0)
    colour[_lines(depth, normal)] = _INK
    shown = np.where(there, 255.0, 0.0)
    shown[_lines(depth, normal)] = 255.0
    # averages over the samples of a pixel, colours weighted by what they cover
    weight = shown[..., None] / 255.0
    cover = _coarse(weight)
    pixel = _coarse(colour * weight) / np.maximum(cover, 1e-9)
    rgba = np.concatenate([pixel, 255.0 * cover], axis=2)
    picture = Image.fromarray(np.round(rgba[::-1]).astype(np.uint8), "RGBA")
    return picture.quantize(64, method=Image.Quantize.FASTOCTREE)


def _upright(face: np.ndarray) -> np.ndarray:
    """Columns are axes (3, 3) of which the last is the inward normal of an outward face (3, 3)."""
    edge = face[1] - face[0]
    up = np.cross(face[2] - face[0], edge)
    x, z = edge / np.linalg.norm(edge), up / np.linalg.norm(up)
    return np.column_stack([x, np.cross(z, x), z])


def _rasterise(triangles: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Depth (rows, columns), -inf where nothing is, and the unit normal towards the viewer."""
    depth = np.full((size[1], size[0]), -np.inf)
    normal = np.zeros((size[1], size[0], 3))
    for corners in triangles:
        a, b, c = corners
        n = np.cross(b - a, c - a)
        if abs(n[2]) < 1e-9:
            continue  # seen from its edge
        lowest = np.floor(corners[:, :2].min(axis=0)).astype(int)
        highest = np.ceil(corners[:, :2].max(axis=0)).astype(int)
        x = np.arange(lowest[0], highest[0] + 1)
        y = np.arange(lowest[1], highest[1] + 1)[:, None]
        inside = np.ones((len(y), x.size), dtype=bool)
        for p, q in ((a, b), (b, c), (c, a)):
            side = (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
            inside &= side * n[2] >= -1e-9
        z = a[2] - (n[0] * (x - a[0]) + n[1] * (y - a[1])) / n[2]
        window = (slice(y[0, 0], y[-1, 0] + 1), slice(x[0], x[-1] + 1))
        nearer = inside & (z > depth[window])
        depth[window][nearer] = z[nearer]
        normal[window][nearer] = n * np.sign(n[2]) / np.linalg.norm(n)
    return depth, normal


def _lines(depth: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Where a sample and the next one are of surfaces that do not go on into each other."""
    lines = np.zeros(depth.shape, dtype=bool)
    filled = np.where(np.isfinite(depth), depth, -1e6)
    for axis in (0, 1):
        ahead = np.roll(filled, -1, axis), np.roll(normal, -1, axis)
        n = normal + ahead[1]
        # what the depth changes by over one sample on the slope that both share
        slope = np.abs(n[..., 1 - axis]) / np.maximum(np.abs(n[..., 2]), 0.2)
        jump = np.abs(ahead[0] - filled) > 3.0 + 2.0 * slope
        fold = (normal * ahead[1]).sum(axis=2) < _FOLD
        both = np.isfinite(depth) & np.isfinite(np.roll(depth, -1, axis))
        edge = jump | (fold & both)
        lines |= edge | np.roll(edge, 1, axis)
    return lines


def _coarse(samples: np.ndarray) -> np.ndarray:
    rows, columns, channels = samples.shape
    shape = (rows // _FINE, _FINE, columns // _FINE, _FINE, channels)
    return samples.reshape(shape).mean(axis=(1, 3))


def main() -> None:
    """Draw them all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sheet", metavar="FILE", help="draw all bodies into this picture instead")
    options = parser.parse_args()
    rows = ifa.bodies.describe()
    pictures = {row["name"]: draw(row["name"], row["material"]) for row in rows}
    if options.sheet:
        columns = 6
        width, height = _SIZE.tolist()
        sheet = Image.new("RGB", (columns * width, -(-len(pictures) // columns) * height), "white")
        for k, picture in enumerate(pictures.values()):
            picture = picture.convert("RGBA")
            sheet.paste(picture, (k % columns * width, k // columns * height), picture)
        sheet.save(options.sheet)
        return
    folder = Path(__file__).parent / "bodies"
    folder.mkdir(exist_ok=True)
    for name, picture in pictures.items():
        picture.save(folder / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
