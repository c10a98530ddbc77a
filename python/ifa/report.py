"""Solutions and bodies as text for people."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from ifa.solution import Event, Solution

# CONVENTIONS.md, "Accuracy of a solve"
_MET_WITHIN_S = 1e-3
_LARGEST_RETIME = 0.30
_LEAST_SCORE = 0.3
_LARGEST_PENETRATION_M = 1e-4


def shortcomings(solution: Solution) -> list[str]:
    """Why a solution did not succeed, one phrase for each reason; empty if it did."""
    if solution.succeeded:
        return []
    reasons = []
    off = _marks(solution.events, lambda e: abs(e.error_retimed_s) <= _MET_WITHIN_S)
    if off:
        reasons.append(f"missed by more than {1e3 * _MET_WITHIN_S:g} ms: {off}")
    stretched = _marks(solution.events, lambda e: abs(e.retime - 1.0) <= _LARGEST_RETIME)
    if stretched:
        reasons.append(f"retimed by more than {100 * _LARGEST_RETIME:g} %: {stretched}")
    if solution.missed_hits:
        reasons.append(f"marks without a hit: {solution.missed_hits}")
    if solution.extra_hits:
        reasons.append(f"hits without a mark: {solution.extra_hits}")
    if solution.score < _LEAST_SCORE:
        reasons.append(f"score below {_LEAST_SCORE:g}")
    if solution.max_penetration_m > _LARGEST_PENETRATION_M:
        reasons.append(f"penetration of {1e3 * solution.max_penetration_m:.2g} mm")
    return reasons or ["the ending or the energy is not as asked"]


def _marks(events: Sequence[Event], good: Any) -> str:
    return ", ".join(f"mark {k}" for k, event in enumerate(events, start=1) if not good(event))


def verdict(solution: Solution) -> str:
    """One sentence."""
    if solution.succeeded:
        return f"succeeded, {'plausible' if solution.plausible else 'not plausible'}"
    return f"no acceptable motion ({'; '.join(shortcomings(solution))})"


def solution_text(solution: Solution) -> str:
    """The verdict, the numbers that matter, and one line for each mark."""
    body = solution.body
    lines = [
        f"{body.name}: {verdict(solution)}",
        f"score {solution.score:.3f} ({solution.score_without_sound:.3f} without sound), "
        f"worst error {1e3 * solution.max_abs_error_s:.3f} ms after retiming",
        f"restitution {solution.restitution:.3g}, friction {solution.friction:.3g}, "
        f"seed {solution.seed}, rung {solution.rung}, {solution.solve_s:.2f} s for "
        f"{solution.simulated_s:.0f} s of simulated motion",
        "",
    ]
    rows = [("mark", "at s", "error ms", "retimed ms", "retime %", "excess")]
    for k, event in enumerate(solution.events, start=1):
        rows.append(
            (
                str(k),
                f"{event.target_s:.4f}",
                f"{1e3 * event.error_s:+.2f}",
                f"{1e3 * event.error_retimed_s:+.3f}",
                f"{100.0 * (event.retime - 1.0):+.2f}",
                f"{event.excess:.3f}",
            )
        )
    return "\n".join([*lines, *table(rows, align=">" * 6)])


def bodies_text(bodies: Iterable[dict[str, Any]]) -> str:
    """One line for each body of the library; restitution / friction on each surface."""
    rows: list[tuple[str, ...]] = []
    for body in bodies:
        if not rows:
            rows.append(("name", "size", "g", "material", *body["surfaces"]))
        materials = [
            f"{s['restitution']:.2f} / {s['friction']:.2f}" for s in body["surfaces"].values()
        ]
        mass = f"{1e3 * body['mass_kg']:.2f}"
        rows.append((body["name"], body["size"], mass, body["material"], *materials))
    return "\n".join(
        [*table(rows, align="<<>" + "<" * 9), "", "restitution / friction on each surface"]
    )


def table(rows: Sequence[Sequence[str]], align: str) -> list[str]:
    """Lines of columns; `align` has `<` or `>` for each."""
    widths = [max(len(row[c]) for row in rows) for c in range(len(rows[0]))]
    return [
        "  ".join(
            f"{cell:{side}{width}}" for cell, side, width in zip(row, align, widths, strict=False)
        ).rstrip()
        for row in rows
    ]
