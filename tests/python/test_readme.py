"""What the README shows is there and runs."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import ifa
import numpy as np
import pytest
from ifa import cli
from ifa.cli_options import command_parser

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


def test_the_example_is_the_quickstart():
    source = (ROOT / "examples" / "quickstart.py").read_text(encoding="utf-8")
    code = source.split('"""\n', 1)[1].strip()
    assert blocks("python")[0].strip() == code


def test_the_example_runs_and_its_motion_passes(tmp_path):
    command = [sys.executable, ROOT / "examples" / "quickstart.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "succeeded: True" in done.stdout
    assert "PASSED" in done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["motion.json"]


def test_the_other_examples_run_after_it(capsys):
    names = {"ifa": ifa, "np": np, "body": ifa.bodies.get("d6", surface="wood")}
    others = blocks("python")[1:]
    assert others
    for code in others:
        exec(compile(code, "README.md", "exec"), names)
    assert "100% came to rest" in capsys.readouterr().out


def test_the_commands_are_those_of_the_command_line():
    lines = [line for block in blocks("sh") for line in block.splitlines()]
    commands = [shlex.split(line, comments=True) for line in lines if line.startswith("ifa ")]
    assert {words[1] for words in commands} >= {"solve", "verify", "bodies"}
    for words in commands:
        command_parser(cli._VERBS).parse_args(words[1:])


def test_the_make_targets_exist():
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)
    used = re.findall(r"\bmake ([a-z-]+)", "\n".join(blocks("sh")))
    assert {"demo", "test"} <= set(used) <= set(targets)


LINKS = sorted(set(re.findall(r"\]\(([^)#]+)", README)))


@pytest.mark.parametrize("link", LINKS)
def test_what_it_links_to_is_there(link):
    if not link.startswith("https://"):
        assert (ROOT / link).exists()
