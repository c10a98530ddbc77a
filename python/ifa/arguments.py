"""Arguments of the public functions, checked once: a value, or an error that names the argument."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ifa._core import IfaValueError, Progress

_MOST_THREADS = 4096


def number(value: Any, field: str) -> float:
    """`value` as a float, which may be infinite or NaN: the core knows each field's range."""
    try:
        if isinstance(value, str | bytes | bool) or value is None:
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise IfaValueError(f"{field}: must be a number, got {value!r}") from None


def positive(value: Any, field: str) -> float:
    """`value` as a finite float above 0."""
    out = number(value, field)
    if not 0.0 < out < np.inf:
        raise IfaValueError(f"{field}: must be finite and above 0, got {out:g}")
    return out


def whole(value: Any, field: str, largest: int, *, least: int = 0) -> int:
    """`value` as an int from `least` to `largest`."""
    if (
        isinstance(value, bool)
        or not isinstance(value, int | np.integer)
        or not least <= value <= largest
    ):
        raise IfaValueError(
            f"{field}: must be a whole number from {least} to {largest}, got {value!r}"
        )
    return int(value)


def one_of(value: Any, field: str, *wanted: str) -> None:
    """Refuse what is none of the words."""
    if value not in wanted:
        words = " or ".join(f'"{word}"' for word in wanted)
        raise IfaValueError(f"{field}: must be {words}, got {value!r}")


def threads(value: Any) -> int:
    """A number of threads as the core takes it: 0 where None asks for one for each core."""
    if value is None:
        return 0
    is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not is_whole or not 1 <= value <= _MOST_THREADS:
        raise IfaValueError(
            f"threads: must be a whole number from 1 to {_MOST_THREADS}, or None for one for each "
            f"core, got {value!r}"
        )
    return int(value)


def check_progress(value: Any) -> None:
    """Refuse what is neither an ifa.Progress nor None."""
    if value is not None and not isinstance(value, Progress):
        raise IfaValueError(f"progress: needs an ifa.Progress or None, got {value!r}")


def array(value: Any, field: str, shape: tuple[int | None, ...]) -> np.ndarray:
    """A new float64 array of the shape, in which None stands for any length."""
    try:
        out = np.array(value)
        if out.dtype.kind not in "iuf" and out.size:
            raise TypeError
        out = out.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise IfaValueError(f"{field}: must be an array of numbers") from None
    fits = out.ndim == len(shape) and all(
        wanted in (None, got) for wanted, got in zip(shape, out.shape, strict=True)
    )
    if not fits:
        inner = ", ".join("n" if n is None else str(n) for n in shape)
        wanted_shape = f"({inner},)" if len(shape) == 1 else f"({inner})"
        raise IfaValueError(f"{field}: needs shape {wanted_shape}, got {out.shape}")
    return out


def inertia(value: ArrayLike) -> np.ndarray:
    """An inertia matrix (3, 3) from a scalar, its diagonal (3,) or itself."""
    field = "inertia_kg_m2"
    try:
        dimensions = np.ndim(value)
    except ValueError:  # rows of unequal length
        dimensions = 2
    if dimensions == 0:
        return number(value, field) * np.eye(3)
    if dimensions == 1:
        return np.diag(array(value, field, (3,)))
    return array(value, field, (3, 3))


def triangle_indices(value: ArrayLike, vertex_count: int) -> np.ndarray:
    """Indices (m, 3) of vertices from 0, at least one row."""
    indices = array(value, "triangles", (None, 3))
    if not len(indices):
        raise IfaValueError("triangles: at least one is needed")
    if (indices != np.floor(indices)).any():
        raise IfaValueError("triangles: must hold whole numbers")
    if indices.min() < 0 or indices.max() >= vertex_count:
        raise IfaValueError(f"triangles: an index lies outside the {vertex_count} vertices")
    return indices.astype(np.int64)


def only_known(given: Iterable[str], known: Iterable[str]) -> None:
    """Refuse names that are not among the known ones."""
    fields = list(known)
    for key in given:
        if key not in fields:
            raise IfaValueError(f"{key}: unknown here; there are {', '.join(fields)}")


def mass_of(volume_m3: float, mass_kg: float | None, density: float | None) -> float:
    """The mass, given itself or as a density in kg/m3."""
    if (mass_kg is None) == (density is None):
        raise IfaValueError("mass_kg: give either mass_kg or density (kg/m3)")
    if mass_kg is not None:
        return positive(mass_kg, "mass_kg")
    return positive(density, "density") * volume_m3
