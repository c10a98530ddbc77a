"""All knobs by name, each with the studies that measure it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ifa._core import IfaValueError
from ifa.tradeoff import engine_step, graph_knobs, keys, search_knobs, shape
from ifa.tradeoff.curve import Study

KNOBS: dict[str, tuple[Callable[..., Study], ...]] = {
    "engine_step": (engine_step.engine_step, engine_step.engine_step_own),
    "hull_detail": (shape.hull_detail_contacts, shape.hull_detail_mass),
    "rounding": (shape.rounding_contacts, shape.rounding_mass),
    "beam": (search_knobs.beam,),
    "proposals": (search_knobs.proposals,),
    "time_budget": (search_knobs.time_budget,),
    "database_size": (graph_knobs.database_size,),
    "neighbours": (graph_knobs.neighbours,),
    "search_exactness": (graph_knobs.search_exactness,),
    "connection_tolerance": (graph_knobs.connection_tolerance,),
    "key_density": (keys.key_density_position, keys.key_density_angle),
    "float_width": (keys.float_width,),
}


def chosen(knobs: Any) -> list[str]:
    """The names asked for, in the order of KNOBS; all of them for None."""
    if knobs is None:
        return list(KNOBS)
    if isinstance(knobs, str) or not isinstance(knobs, Sequence) or not knobs:
        raise IfaValueError(f"knobs: needs a sequence of names or None, got {knobs!r}")
    for name in knobs:
        if name not in KNOBS:
            raise IfaValueError(f"knobs: {name!r} is none of {', '.join(KNOBS)}")
    return [name for name in KNOBS if name in knobs]
