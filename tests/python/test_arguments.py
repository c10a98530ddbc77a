"""Arguments of the wrong kind: an IfaValueError that names the argument, never a TypeError."""

from __future__ import annotations

import ifa
import pytest


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("threads", 0),
        ("constraints", None),
        ("constraints", 3),
        ("takes", None),
        ("takes", True),
        ("takes", [1]),
        ("progress", 3),
        ("progress", "half"),
    ],
)
def test_solve_names_the_argument(name, value):
    die = ifa.bodies.get("d6")
    with pytest.raises(ifa.IfaValueError, match=f"^{name}:"):
        ifa.solve(die, ifa.Signature([0.1]), rung=0, **{name: value})


def test_threads_says_what_it_takes():
    with pytest.raises(ifa.IfaValueError, match="1 to 4096, or None"):
        ifa.solve(ifa.bodies.get("d6"), ifa.Signature([0.1]), rung=0, threads=0)


@pytest.mark.parametrize("name", [[], {}, None, 6])
def test_a_body_that_is_no_name(name):
    with pytest.raises(ifa.IfaValueError, match=r"^body:"):
        ifa.bodies.get(name)


def test_a_surface_that_is_no_name():
    with pytest.raises(ifa.IfaValueError, match=r"^surface:"):
        ifa.bodies.get("d6", surface=[])


@pytest.mark.parametrize("path", [3, None, ["marks.txt"]])
def test_a_path_that_is_none(path):
    with pytest.raises(ifa.IfaValueError, match=r"^path:"):
        ifa.Signature.read(path)
