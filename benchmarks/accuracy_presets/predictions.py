"""Predictions against what came true, over the recordings."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import ifa
from ifa.prediction import FACTOR

from benchmarks.physics.report import Row
from benchmarks.solve.cases import Case

from .climbs import CLOCKS, solve_one

HEADER = (
    f"{'recording':26} {'stop':5} {'calibrated s':>12} {'seen':>4} "
    f"{'predicted s':>11} {'true s':>8} {'ratio':>6} {'predicted error':>15} {'true':>6} "
    f"{'ratio':>6}"
)


UNBOUND_S = 1e6


def judge(options: argparse.Namespace, case: Case) -> list[Row]:
    """All stops of one recording: predicted at once, then solved one after the other."""
    # Budgets are of real time: a machine that is busy otherwise would end climbs anywhere.
    budget = {"time_budget_s": UNBOUND_S} if options.clock == "cpu" else {}
    predictions = ifa.predict_all(
        case.body,
        case.marks,
        clock=CLOCKS[options.clock],
        material=case.material,
        events=case.events,
        seed=options.seed,
        threads=options.threads,
        **budget,
    )
    rows: list[Row] = []
    for name, prediction in predictions.items():
        solution, true_s = solve_one(
            case, ifa.ACCURACIES[name], options, prediction=prediction, **budget
        )
        error = 1.0 if solution is None else solution.error
        rows.append(
            {
                "case": case.name,
                "accuracy": name,
                "calibration_s": prediction.calibration_s,
                "reached": prediction.reached,
                "predicted_s": prediction.time_s,
                "true_s": true_s,
                "time_ratio": prediction.time_s / true_s,
                "predicted_error": prediction.error,
                "true_error": error,
                "error_ratio": prediction.error / max(error, 1e-12),
                "succeeded": solution is not None and solution.succeeded,
                "plausible": solution is not None and solution.plausible,
            }
        )
    return rows


def line(row: Row) -> str:
    return (
        f"{row['case']:26} {row['accuracy']:5} {row['calibration_s']:12.2f} "
        f"{'yes' if row['reached'] else 'no':>4} {row['predicted_s']:11.3f} {row['true_s']:8.3f} "
        f"{row['time_ratio']:6.2f} {row['predicted_error']:15.4f} {row['true_error']:6.4f} "
        f"{row['error_ratio']:6.2f}"
    )


def shares(rows: Sequence[Row]) -> list[Row]:
    """For each stop, how many predictions are within the factor; also of those not seen before."""
    out: list[Row] = []
    for name in ifa.ACCURACIES:
        own = [row for row in rows if row["accuracy"] == name]
        unseen = [row for row in own if not row["reached"]]
        out.append(
            {
                "accuracy": name,
                "recordings": len(own),
                "time_within": sum(map(_right("time_ratio"), own)),
                "error_within": sum(map(_right("error_ratio"), own)),
                "both_within": sum(
                    _right("time_ratio")(row) and _right("error_ratio")(row) for row in own
                ),
                "unseen": len(unseen),
                "unseen_time_within": sum(map(_right("time_ratio"), unseen)),
                "unseen_error_within": sum(map(_right("error_ratio"), unseen)),
                "longest_calibration_s": max(float(str(row["calibration_s"])) for row in own),
            }
        )
    return out


def shares_text(rows: Sequence[Row]) -> str:
    return "\n".join(
        f"{row['accuracy']}: seconds within {FACTOR:g} times in {row['time_within']} of "
        f"{row['recordings']}, error in {row['error_within']}, both in {row['both_within']}; of "
        f"{row['unseen']} whose end the calibration had not seen: {row['unseen_time_within']}, "
        f"{row['unseen_error_within']}; calibration {row['longest_calibration_s']:.2f} s at most"
        for row in rows
    )


def _right(field: str):
    return lambda row: 1.0 / FACTOR <= row[field] <= FACTOR
