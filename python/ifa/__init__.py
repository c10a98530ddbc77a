"""Inverse-Foley Animation: rigid-body motion whose contacts land on the marks of a sound.

Mark when a sound's contacts happen, and `solve` finds a motion of a `Body` whose audible hits land
on those marks and that obeys physics:

    import ifa

    body = ifa.bodies.get("d6")
    marks = ifa.Signature.read("roll.txt", sound="roll.wav")
    solution = ifa.solve(body, marks, material="fit")
    positions_m, quaternions_wxyz = solution.motion.sample([0.0, 0.5, 1.0])

Units are SI, z is up, the ground is z = 0, quaternions are wxyz; CONVENTIONS.md has the rest. Every
error that the package raises is an `IfaError`.
"""

from ifa import bodies
from ifa._core import (
    Cancelled,
    IfaError,
    IfaFileError,
    IfaValueError,
    NoMotionError,
    Progress,
    ReplayError,
    __version__,
)
from ifa.accuracy import ACCURACIES, Accuracy
from ifa.batch import Batch, SampleStatus, instruction_sets, sample_states, simulate_batch
from ifa.body import Body, MeshWarning
from ifa.constraints import ConstraintReport, Orientation, Position
from ifa.database import Database
from ifa.effects import EFFECTS, EffectState, Plan, plan
from ifa.estimation import Estimate, Finding, Gap, estimate
from ifa.explanation import Conflict, Explanation, Repair, explain
from ifa.marks import Signature
from ifa.prediction import predict, predict_all
from ifa.simulation import Hits, Run, State, fly, simulate
from ifa.solution import Event, Motion, Prediction, Solution, Stage
from ifa.solving import CLEARLY_DIFFERENT, solve
from ifa.symmetry import Symmetry
from ifa.tradeoff import TradeoffReport, tradeoff
from ifa.verification import Certificate, verify

__all__ = [
    "ACCURACIES",
    "CLEARLY_DIFFERENT",
    "EFFECTS",
    "Accuracy",
    "Batch",
    "Body",
    "Cancelled",
    "Certificate",
    "Conflict",
    "ConstraintReport",
    "Database",
    "EffectState",
    "Estimate",
    "Event",
    "Explanation",
    "Finding",
    "Gap",
    "Hits",
    "IfaError",
    "IfaFileError",
    "IfaValueError",
    "MeshWarning",
    "Motion",
    "NoMotionError",
    "Orientation",
    "Plan",
    "Position",
    "Prediction",
    "Progress",
    "Repair",
    "ReplayError",
    "Run",
    "SampleStatus",
    "Signature",
    "Solution",
    "Stage",
    "State",
    "Symmetry",
    "TradeoffReport",
    "__version__",
    "bodies",
    "estimate",
    "explain",
    "fly",
    "instruction_sets",
    "plan",
    "predict",
    "predict_all",
    "sample_states",
    "simulate",
    "simulate_batch",
    "solve",
    "tradeoff",
    "verify",
]
