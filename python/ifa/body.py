"""Rigid bodies: the rounded convex hull that touches the ground, its mass, inertia and material."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ifa import _core
from ifa._core import IfaFileError, IfaValueError
from ifa.arguments import (
    array,
    inertia,
    mass_of,
    number,
    only_known,
    positive,
    triangle_indices,
    whole,
)
from ifa.body_files import read_fields, write_fields
from ifa.hull_changes import farthest_points, inset_hull
from ifa.mesh_files import read_mesh
from ifa.solid import mesh_mass_properties
from ifa.symmetry import Symmetry

_UNITS_M = {
    "m": 1.0, "metre": 1.0, "meter": 1.0, "cm": 0.01, "mm": 0.001, "um": 1e-6, "km": 1000.0,
    "in": 0.0254, "inch": 0.0254, "ft": 0.3048, "foot": 0.3048, "feet": 0.3048,
}  # fmt: skip
_DEFAULT_DENSITY_KG_M3 = 1000.0

# Of a new body, and all that `replace` and body files may set.
_MATERIAL = {
    "restitution": 0.5,
    "friction": 0.3,
    "rolling_friction_m": 5e-5,
    "spin_friction_m": 5e-5,
}
_NUMBERS = ("radius_m", "mass_kg", *_MATERIAL)
_FILE_KEYS = (
    "name", "vertices_m", "radius_m", "rings_m", "mass_kg", "inertia_kg_m2", *_MATERIAL,
    "mesh_centre_of_mass_m",
)  # fmt: skip


class MeshWarning(UserWarning):
    """A mesh was not what a solid's surface should be; the message says what was done instead."""


class Body:
    """An immutable rigid body. Make one with a class method, or take one from `ifa.bodies`.

    The body touches the ground with the convex hull of `vertices_m` and of the circular edges
    `rings_m`, rounded by `radius_m`: one vertex and a radius is a ball, two are a capsule, two
    rings on one axis a coin, a cup or a can. Its axes are those of the vertices or the mesh
    it was made from, its origin is the centre of mass. The material: `restitution` (Newton's, 0 to
    1), `friction` (Coulomb's), and the lever arms `rolling_friction_m` and `spin_friction_m`
    (resisting torque over normal force, about axes in and normal to the ground).

    Every method that makes a body raises `IfaValueError` naming the argument that cannot be.
    """

    __slots__ = (
        "_centre_of_mass_m", "_core", "_notes", "_outline_m", "_rings_m", "_triangles",
        "_vertices_m",
    )  # fmt: skip

    _centre_of_mass_m: np.ndarray
    _core: Any
    _notes: tuple[str, ...]
    _outline_m: np.ndarray | None
    _rings_m: np.ndarray
    _triangles: np.ndarray | None
    _vertices_m: np.ndarray

    def __init__(self) -> None:
        raise TypeError("make a Body with Body.from_mesh, from_vertices, box, ball or read")

    @classmethod
    def from_vertices(
        cls,
        vertices_m: ArrayLike,
        radius_m: float = 0.0,
        rings_m: ArrayLike | None = None,
        *,
        mass_kg: float,
        inertia_kg_m2: ArrayLike | None = None,
        centre_of_mass_m: ArrayLike | None = None,
        restitution: float = _MATERIAL["restitution"],
        friction: float = _MATERIAL["friction"],
        rolling_friction_m: float = _MATERIAL["rolling_friction_m"],
        spin_friction_m: float = _MATERIAL["spin_friction_m"],
        name: str = "body",
    ) -> Body:
        """A body from points (n, 3) whose convex hull, rounded by `radius_m`, is its surface.

        Args:
            vertices_m: (n, 3); only the extreme points are kept.
            radius_m: rounding radius; above 0 where the points span no volume.
            rings_m: (k, 7), at most 8 circular edges: centre x y z, axis x y z (of any length) and
                radius, rounded by `radius_m` as the vertices are. With one, `vertices_m` may be
                empty; vertices within the hull of the rings are dropped.
            mass_kg: the mass.
            inertia_kg_m2: about the centre of mass, in the axes of the vertices: a scalar, the
                diagonal (3,) or the matrix (3, 3). If None, that of the rounded hull at uniform
                density; exact, but for rings: there to 1e-9 for solids of revolution, 1e-6 else.
            centre_of_mass_m: (3,), in the axes of the vertices. If None, their origin where the
                inertia is given, else that of the rounded hull.
            restitution: 0 to 1.
            friction: not negative.
            rolling_friction_m: not negative.
            spin_friction_m: not negative.
            name: of the body.
        """
        rings = _rings(rings_m)
        vertices = _vertices(vertices_m, rings)
        radius, mass = number(radius_m, "radius_m"), positive(mass_kg, "mass_kg")
        centre = np.zeros(3)
        if inertia_kg_m2 is not None:
            moments = inertia(inertia_kg_m2)
        else:
            volume, centre, moments = _core.rounded_hull_mass_properties(
                vertices, radius, 1.0, rings
            )
            if volume <= 0.0:
                raise IfaValueError(
                    "vertices_m: their hull has no volume, which needs a radius_m above 0"
                    if not len(rings)
                    else "rings_m: their hull has no volume, which needs a radius_m above 0 or the "
                    "inertia_kg_m2"
                )
            moments = moments * (mass / volume)
        if centre_of_mass_m is not None:
            centre = array(centre_of_mass_m, "centre_of_mass_m", (3,))
        return cls._make(
            {
                "name": name,
                "vertices_m": vertices - centre,
                "rings_m": rings - np.concatenate([centre, np.zeros(4)]),
                "radius_m": radius,
                "mass_kg": mass,
                "inertia_kg_m2": moments,
                "restitution": restitution,
                "friction": friction,
                "rolling_friction_m": rolling_friction_m,
                "spin_friction_m": spin_friction_m,
            },
            centre,
        )

    @classmethod
    def box(
        cls,
        size_m: ArrayLike,
        *,
        mass_kg: float | None = None,
        density: float | None = None,
        radius_m: float = 0.0,
        name: str = "box",
        **material: float,
    ) -> Body:
        """A solid box of outer size (3,), its edges rounded by `radius_m` within that size.

        Give `mass_kg` or `density` (kg/m3); `material` as in `from_vertices`. The inertia is that
        of the rounded box.
        """
        size = array(size_m, "size_m", (3,))
        radius = number(radius_m, "radius_m")
        if not (np.isfinite(size).all() and (size > 0.0).all()):
            raise IfaValueError(f"size_m: must be finite and above 0, got {size.tolist()}")
        if radius < 0.0 or 2.0 * radius > size.min():
            raise IfaValueError("radius_m: must lie between 0 and half the smallest size")
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        vertices = signs * (0.5 * size - radius)
        return cls._from_hull(vertices, radius, mass_kg, density, name, material)

    @classmethod
    def ball(
        cls,
        radius_m: float,
        *,
        mass_kg: float | None = None,
        density: float | None = None,
        name: str = "ball",
        **material: float,
    ) -> Body:
        """A solid ball. Give `mass_kg` or `density` (kg/m3); `material` as in `from_vertices`."""
        radius = positive(radius_m, "radius_m")
        return cls._from_hull(np.zeros((1, 3)), radius, mass_kg, density, name, material)

    @classmethod
    def from_triangles(
        cls,
        vertices_m: ArrayLike,
        triangles: ArrayLike,
        *,
        density: float | None = None,
        mass_kg: float | None = None,
        radius_m: float = 0.0,
        name: str = "body",
        **material: float,
    ) -> Body:
        """A body whose mass properties are those of the solid inside a mesh, at uniform density.

        The mesh may be wound either way, in several closed pieces, with cavities. Where it encloses
        no volume, the mass properties are those of its convex hull, and `notes` and a `MeshWarning`
        say so. The contact shape is always the convex hull, rounded by `radius_m`.

        Args:
            vertices_m: (n, 3), in m.
            triangles: (m, 3) indices into the vertices, from 0.
            density: in kg/m3; or `mass_kg`. If neither is given, 1000 kg/m3, which is noted.
            mass_kg: the mass.
            radius_m: rounding radius, added to the mesh.
            name: of the body.
            material: `restitution`, `friction` and so on, as in `from_vertices`.
        """
        vertices = array(vertices_m, "vertices_m", (None, 3))
        faces = triangle_indices(triangles, len(vertices))
        return cls._from_surface(vertices, faces, density, mass_kg, radius_m, name, material, [])

    @classmethod
    def from_mesh(
        cls,
        path: str | os.PathLike[str],
        unit: str = "m",
        *,
        density: float | None = None,
        mass_kg: float | None = None,
        radius_m: float = 0.0,
        name: str | None = None,
        **material: float,
    ) -> Body:
        """`from_triangles` for a mesh file: .obj, .stl, .ply or .off.

        Args:
            path: of the file.
            unit: of its coordinates: m, cm, mm, um, km, inch or ft.
            density: as in `from_triangles`.
            mass_kg: as in `from_triangles`.
            radius_m: rounding radius in m, added to the mesh.
            name: of the body; if None, the file's without its ending.
            material: `restitution`, `friction` and so on, as in `from_vertices`.

        Raises:
            IfaFileError: the file is missing, unreadable or malformed.
        """
        if unit not in _UNITS_M:
            raise IfaValueError(f"unit: '{unit}' is none of {', '.join(_UNITS_M)}")
        path = Path(path)
        vertices, triangles, doubts = read_mesh(path)
        vertices = vertices * _UNITS_M[unit]
        label = path.stem if name is None else name
        try:
            return cls._from_surface(
                vertices, triangles, density, mass_kg, radius_m, label, material, doubts, str(path)
            )
        except IfaValueError as error:
            raise IfaValueError(f"{path}: {error}") from None

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Body:
        """Read a body file (.json), as `write` makes it.

        Keys: `vertices_m` and `mass_kg`; optional `name`, `radius_m`, `rings_m` (rows of centre,
        axis and radius; null or empty: none), `inertia_kg_m2`, `restitution`, `friction`,
        `rolling_friction_m`, `spin_friction_m` and `mesh_centre_of_mass_m` (where the centre of
        mass lies in the axes of the mesh).

        Raises:
            IfaFileError: the file is missing, not JSON, or holds what no body can have.
        """
        try:
            return cls.from_dict(read_fields(path))
        except IfaValueError as error:
            raise IfaFileError(f"{path}: {error}") from None

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Body:
        """A body from what `to_dict` gives; the keys are those of `read`."""
        if not isinstance(content, Mapping):
            raise IfaValueError("a body must be an object with named fields")
        only_known(content, _FILE_KEYS)
        fields = dict(content)
        for key in ("vertices_m", "mass_kg"):
            if key not in fields:
                raise IfaValueError(f"{key}: is missing")
        centre = fields.pop("mesh_centre_of_mass_m", None)
        body = cls.from_vertices(**fields)
        if centre is not None:
            mesh_centre = array(centre, "mesh_centre_of_mass_m", (3,))
            if not np.isfinite(mesh_centre).all():
                raise IfaValueError("mesh_centre_of_mass_m: must be finite")
            body._centre_of_mass_m = _frozen(mesh_centre)
        return body

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and lists, about the centre of mass, for `from_dict`."""
        content: dict[str, Any] = {
            "name": self.name,
            "vertices_m": self._vertices_m.tolist(),
            "radius_m": self.radius_m,
            "rings_m": self._core.rings_m.tolist(),
            "mass_kg": self.mass_kg,
            "inertia_kg_m2": self._core.inertia_kg_m2.tolist(),
            **{key: getattr(self, key) for key in _MATERIAL},
        }
        if self._centre_of_mass_m.any():
            content["mesh_centre_of_mass_m"] = self._centre_of_mass_m.tolist()
        return content

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write a body file (.json). Raises IfaFileError where that fails."""
        write_fields(path, self.to_dict())

    def replace(self, **changes: Any) -> Body:
        """A copy with other fields, for example `body.replace(restitution=0.4)`.

        Any of `name`, `vertices_m` and `rings_m` (about the centre of mass), `radius_m`, `mass_kg`,
        `inertia_kg_m2`, `restitution`, `friction`, `rolling_friction_m` and `spin_friction_m`. A
        new mass scales the inertia with it unless that is given too.
        """
        fields: dict[str, Any] = {
            "name": self.name,
            "vertices_m": self._vertices_m,
            "rings_m": self._core.rings_m,
            "inertia_kg_m2": self._core.inertia_kg_m2,
            **{key: getattr(self, key) for key in _NUMBERS},
        }
        only_known(changes, fields)
        fields.update(changes)
        if "inertia_kg_m2" in changes:
            fields["inertia_kg_m2"] = inertia(changes["inertia_kg_m2"])
        elif "mass_kg" in changes:
            ratio = positive(changes["mass_kg"], "mass_kg") / self.mass_kg
            fields["inertia_kg_m2"] = fields["inertia_kg_m2"] * ratio
        fields["rings_m"] = _rings(fields["rings_m"])
        fields["vertices_m"] = _vertices(fields["vertices_m"], fields["rings_m"])
        return Body._make(fields, self._centre_of_mass_m, self._notes)

    def with_hull_detail(self, points: int) -> Body:
        """The body with a contact hull of at most `points` vertices; its mass properties stay.

        Of `outline_m` those are kept that lie farthest apart, one after the other; circular edges
        become polygons. A body without circular edges and with no more vertices is returned as it
        is. Raises IfaValueError where no body can be that coarse.
        """
        count = whole(points, "points", 2**31 - 1, least=1)
        if not len(self._rings_m) and count >= len(self._vertices_m):
            return self
        kept = farthest_points(self.outline_m, count)
        return self.replace(vertices_m=kept, rings_m=None)

    def with_rounding(self, radius_m: float) -> Body:
        """The body with another rounding radius; its mass properties and its flat faces stay.

        Only edges and corners become rounder or sharper. Circular edges stay in the planes of the
        body's flat faces and keep their outermost reach, which is exact for cylinders. Raises
        IfaValueError where the radius leaves no body, and for bodies without volume before
        rounding, such as a ball.
        """
        radius = number(radius_m, "radius_m")
        if not 0.0 <= radius < np.inf:
            raise IfaValueError(f"radius_m: must be finite and 0 or more, got {radius:g}")
        inset = radius - self.radius_m
        vertices, rings = inset_hull(self._vertices_m, self._rings_m, inset)
        return self.replace(vertices_m=vertices, rings_m=rings, radius_m=radius)

    @property
    def name(self) -> str:
        """The body's name."""
        return self._core.name

    @property
    def vertices_m(self) -> np.ndarray:
        """Extreme points of the hull (n, 3) about the centre of mass, before rounding."""
        return self._vertices_m

    @property
    def rings_m(self) -> np.ndarray:
        """Circular edges (k, 7): centre about the centre of mass, unit axis, radius."""
        return self._rings_m

    @property
    def outline_m(self) -> np.ndarray:
        """Points for drawing (n, 3): `vertices_m`, then 72 points around each circular edge."""
        if self._outline_m is None:
            points = [self._vertices_m, *(_circle(ring) for ring in self._rings_m)]
            self._outline_m = _frozen(np.concatenate(points))
        return self._outline_m

    @property
    def triangles(self) -> np.ndarray:
        """The hull for drawing: (m, 3) indices into `outline_m`, outward; none for a flat hull.

        Without circular edges `outline_m` is `vertices_m`.
        """
        if self._triangles is None:
            hull, triangles, _ = _core.convex_hull(self.outline_m)
            row = {tuple(v): k for k, v in enumerate(self.outline_m.tolist())}
            index = np.array([row[tuple(v)] for v in hull.tolist()], dtype=np.int64)
            self._triangles = _frozen(index[triangles])
        return self._triangles

    @property
    def radius_m(self) -> float:
        """The rounding radius."""
        return self._core.radius_m

    @property
    def mass_kg(self) -> float:
        """The mass."""
        return self._core.mass_kg

    @property
    def inertia_kg_m2(self) -> np.ndarray:
        """Inertia (3, 3) about the centre of mass, in the body's axes."""
        return self._core.inertia_kg_m2

    @property
    def centre_of_mass_m(self) -> np.ndarray:
        """(3,), in the axes of the mesh or vertices the body was made from."""
        return self._centre_of_mass_m

    @property
    def symmetry(self) -> Symmetry:
        """The symmetry group of hull and mass properties, to 1e-6; found anew at each call."""
        return Symmetry._of(self._core)

    @property
    def restitution(self) -> float:
        """Newton's coefficient of restitution, 0 to 1."""
        return self._core.restitution

    @property
    def friction(self) -> float:
        """Coulomb's coefficient of friction."""
        return self._core.friction

    @property
    def rolling_friction_m(self) -> float:
        """Largest torque against rolling over the normal force."""
        return self._core.rolling_friction_m

    @property
    def spin_friction_m(self) -> float:
        """Largest torque against spinning about the ground's normal over the normal force."""
        return self._core.spin_friction_m

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed or repaired while the body was made; empty if nothing."""
        return self._notes

    def __repr__(self) -> str:
        rings = f" {len(self._rings_m)} rings," if len(self._rings_m) else ""
        return (
            f"<ifa.Body {self.name!r}: {len(self._vertices_m)} vertices,{rings}"
            f" radius {self.radius_m:.3g} m, {self.mass_kg:.3g} kg,"
            f" restitution {self.restitution:g},"
            f" friction {self.friction:g}>"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore, (self.to_dict(), self._notes)

    @classmethod
    def _make(
        cls, fields: Mapping[str, Any], centre: np.ndarray, notes: tuple[str, ...] = ()
    ) -> Body:
        if not isinstance(fields["name"], str):
            raise IfaValueError(f"name: must be text, got {fields['name']!r}")
        arguments = {**fields, **{key: number(fields[key], key) for key in _NUMBERS}}
        if not np.isfinite(centre).all():
            raise IfaValueError("centre_of_mass_m: must be finite")
        body = cls._of(_core.Body(centre_of_mass_m=np.zeros(3), **arguments))
        body._centre_of_mass_m = _frozen(np.array(centre))
        body._notes = tuple(notes)
        return body

    @classmethod
    def _of(cls, core: Any) -> Body:
        """A body of the core's, whose centre of mass is its origin."""
        body = object.__new__(cls)
        body._core = core
        body._vertices_m = _frozen(core.vertices_m)
        body._rings_m = _frozen(core.rings_m)
        body._centre_of_mass_m = _frozen(np.zeros(3))
        body._outline_m = body._triangles = None
        body._notes = ()
        return body

    @classmethod
    def _from_hull(
        cls,
        vertices: np.ndarray,
        radius: float,
        mass_kg: float | None,
        density: float | None,
        name: str,
        material: Mapping[str, float],
    ) -> Body:
        only_known(material, _MATERIAL)
        volume, _, moments = _core.rounded_hull_mass_properties(vertices, radius, 1.0)
        mass = mass_of(volume, mass_kg, density)
        moments = moments * (mass / volume)
        return cls.from_vertices(
            vertices, radius, mass_kg=mass, inertia_kg_m2=moments, name=name, **material
        )

    @classmethod
    def _from_surface(
        cls,
        vertices: np.ndarray,
        triangles: np.ndarray,
        density: float | None,
        mass_kg: float | None,
        radius_m: float,
        name: str,
        material: Mapping[str, float],
        notes: list[str],
        source: str = "mesh",
    ) -> Body:
        only_known(material, _MATERIAL)
        radius = number(radius_m, "radius_m")
        used, faces = np.unique(triangles, return_inverse=True)
        vertices, faces = vertices[used], faces.reshape(-1, 3)
        volume, centre, moments, repairs = mesh_mass_properties(vertices, faces, radius)
        notes = notes + repairs
        if density is None and mass_kg is None:
            density = _DEFAULT_DENSITY_KG_M3
            notes = [*notes, f"no density and no mass given; taken as {density:g} kg/m3"]
        for note in notes:
            warnings.warn(f"{source}: {note}", MeshWarning, stacklevel=3)
        mass = mass_of(volume, mass_kg, density)
        fields = {
            "name": name,
            "vertices_m": vertices - centre,
            "rings_m": np.empty((0, 7)),
            "radius_m": radius,
            "mass_kg": mass,
            "inertia_kg_m2": moments * (mass / volume),
            **_MATERIAL,
            **material,
        }
        return cls._make(fields, centre, tuple(notes))


def _restore(content: Mapping[str, Any], notes: tuple[str, ...]) -> Body:
    body = Body.from_dict(content)
    body._notes = tuple(notes)
    return body


def _rings(rings_m: ArrayLike | None) -> np.ndarray:
    if rings_m is None or not np.size(rings_m):
        return np.empty((0, 7))
    return array(rings_m, "rings_m", (None, 7))


def _vertices(vertices_m: ArrayLike, rings: np.ndarray) -> np.ndarray:
    if len(rings) and not np.size(vertices_m):
        return np.empty((0, 3))
    return array(vertices_m, "vertices_m", (None, 3))


def _circle(ring: np.ndarray, corners: int = 72) -> np.ndarray:
    centre, axis, radius = ring[:3], ring[3:6], ring[6]
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    angle = np.arange(corners)[:, None] * (2.0 * np.pi / corners)
    around = np.cos(angle) * across + np.sin(angle) * np.cross(axis, across)
    return centre + radius * around


def _frozen(values: np.ndarray) -> np.ndarray:
    values.setflags(write=False)
    return values
