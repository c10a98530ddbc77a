"""Databases as Python and the command line see them: killed, gone on with, refused."""

from __future__ import annotations

import json
import os
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import ifa
import numpy as np
import pytest
from ifa import cli
from ifa.meter import BuildMeter

SIMULATIONS = 1500  # two shards


@pytest.fixture(scope="module")
def die():
    return ifa.bodies.get("d6", surface="wood")


@pytest.fixture(scope="module")
def database(die, tmp_path_factory):
    return ifa.Database.build(die, tmp_path_factory.mktemp("d6") / "db", SIMULATIONS, seed=5)


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def run(*arguments, **keywords):
    command = [sys.executable, "-m", "ifa.cli", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, **keywords)


def test_says_what_it_is(database, die):
    assert len(database) == database.nodes == len(database.columns["flags"]) > SIMULATIONS
    assert (database.simulations, database.seed, database.events) == (SIMULATIONS, 5, "audible")
    assert (database.merge_gap_s, database.until_s) == (0.010, 60.0)
    assert database.sampling == {
        "cone_rad": np.pi / 6.0,
        "speed_m_s": (0.5, 4.0),
        "spin_rad_s": (0.0, 20.0),
    }
    assert database.body.to_dict() == die.to_dict()
    assert f"{database.nodes} nodes" in repr(database)


def test_columns_are_read_only_views_of_the_files(database):
    sizes = {path.stat().st_size for path in database.path.iterdir()}
    for name, column in database.columns.items():
        assert len(column) == len(database)
        assert not column.flags.owndata and not column.flags.writeable
        assert column.nbytes in sizes, name
        with pytest.raises(ValueError):
            column[:1] = 0
        with pytest.raises(ValueError):
            column.flags.writeable = True
    with pytest.raises(TypeError):
        database.columns["flags"] = None
    # the contract: at most 200 bytes a node on the disk; the manifest is the same for any number
    per_node = sum(column.nbytes for column in database.columns.values()) / len(database)
    assert per_node <= 200
    manifest = (database.path / "nodes.manifest").stat().st_size
    assert (
        sum(p.stat().st_size for p in database.path.iterdir())
        == per_node * len(database) + manifest
    )


def test_columns_outlive_the_database(die, tmp_path):
    column = ifa.Database.build(die, tmp_path, 5).columns["onset"]
    kept = column.copy()
    for path in tmp_path.iterdir():
        path.unlink()
    np.testing.assert_array_equal(column, kept)


def test_first_nodes_are_those_of_a_batch(database, die):
    """Its first impact is every die's first node, if it is audible; ifa.simulate_batch has it."""
    states = ifa.sample_states(die, 50, seed=5)
    batch = ifa.simulate_batch(die, states)
    simulation, flags = database.columns["simulation"], database.columns["flags"]
    for k in range(50):
        hits = batch.hits(k)
        rows = np.flatnonzero(simulation == k)
        signature = ifa.Signature.from_run(ifa.simulate(die, states[k]))
        assert len(rows) == len(signature)
        assert (flags[rows[:-1]] & 2).all() and flags[rows[-1]] & 1
        assert hits.approach_speed_m_s[0] > 0.05  # all were thrown at 0.5 m/s or more
        if database.columns["delay_s"][rows[0]] == 0.0:
            impulse = np.linalg.norm(hits.impulse_n_s[0])
            # single precision
            assert database.columns["amplitude"][rows[0]] == pytest.approx(impulse, rel=1e-6)


def test_opened_and_checked(database, die):
    again = ifa.Database.open(str(database.path), die)
    again.check(threads=1)
    for name, column in database.columns.items():
        np.testing.assert_array_equal(again.columns[name], column)


def test_a_complete_one_is_opened(database, die):
    before = {path: path.stat().st_mtime_ns for path in database.path.iterdir()}
    ifa.Database.build(die, database.path, SIMULATIONS, seed=5)
    assert {path: path.stat().st_mtime_ns for path in database.path.iterdir()} == before


def test_a_name_that_is_not_utf8_works(die, tmp_path):
    path = os.path.join(tmp_path, os.fsdecode(b"d\xff6"))
    built = ifa.Database.build(die, path, 5)
    assert len(ifa.Database.open(path)) == len(built)
    with pytest.raises(ifa.IfaFileError, match="no such folder"):
        ifa.Database.open(path + "x")


def test_replay_is_a_run(database):
    flags, onset = database.columns["flags"], database.columns["onset"]
    for i in range(60):
        run_ = database.replay(i)
        assert run_.times_s[0] == 0.0
        np.testing.assert_array_equal(run_.states.velocity_m_s[0], onset[i, 5:8])
        if flags[i] & 2:
            assert run_.status == "time_limit" and run_.rest_s is None
            assert run_.hits.time_s[-1] == run_.times_s[-1] == run_.times_s[-2]
            assert run_.states.velocity_m_s[-2, 2] < run_.states.velocity_m_s[-1, 2]  # the impact
            # the tolerance of a replay, times speeds of at most 5 m/s with their spin
            np.testing.assert_allclose(
                run_.states.velocity_m_s[-1], onset[i + 1, 5:8], rtol=0, atol=1e-5
            )
            flight_s = database.columns["flight_s"][i]
            if flight_s > 0:
                interval = database.columns["delay_s"][i] + flight_s
                assert run_.times_s[-1] == pytest.approx(interval, rel=1e-6)  # single precision
        else:
            assert run_.status == "rest" and 0 < run_.rest_s <= run_.times_s[-1]


@pytest.mark.parametrize(
    ("field", "changes"),
    [
        ("body", {"body": "d6"}),
        ("path", {"path": 3}),
        ("path", {"path": ""}),
        ("simulations", {"simulations": 0}),
        ("simulations", {"simulations": 2**32}),
        ("simulations", {"simulations": 10.5}),
        ("seed", {"seed": -1}),
        ("threads", {"threads": 0}),
        ("events", {"events": "loud"}),
        ("sampling", {"sampling": 30}),
        ("angle", {"sampling": {"angle": 30}}),
        ("cone_rad", {"sampling": {"cone_rad": 2.0}}),
        ("speed_m_s", {"sampling": {"speed_m_s": (2.0, 1.0)}}),
        ("merge_gap_s", {"merge_gap_s": 0.0}),
        ("merge_gap_s", {"merge_gap_s": np.nan}),
        ("until_s", {"until_s": np.inf}),
        ("progress", {"progress": 1}),
    ],
)
def test_bad_arguments_are_named_before_anything_is_written(die, tmp_path, field, changes):
    arguments = {"body": die, "path": tmp_path / "db", "simulations": 10, **changes}
    with pytest.raises(ifa.IfaValueError, match=f"^{field}: "):
        ifa.Database.build(**arguments)
    assert not list(tmp_path.iterdir())


def test_another_body_or_option_is_refused(database, die):
    with pytest.raises(ifa.IfaValueError, match=r"^body: .*friction: .* has 0.3, not 0.4"):
        ifa.Database.open(database.path, die.replace(friction=0.4))
    with pytest.raises(ifa.IfaValueError, match=r"^seed: .* has 5, not 6"):
        ifa.Database.build(die, database.path, SIMULATIONS, seed=6)
    with pytest.raises(ifa.IfaValueError, match=r"^cone_rad: "):
        ifa.Database.build(die, database.path, SIMULATIONS, 5, sampling={"cone_rad": 1.4})
    with pytest.raises(ifa.IfaValueError, match=r"^merge_gap_s: "):
        ifa.Database.build(die, database.path, SIMULATIONS, 5, merge_gap_s=0.03)
    renamed = ifa.Body.from_dict({**die.to_dict(), "name": "my die"})
    assert ifa.Database.open(database.path, renamed).body.name == "d6"  # a name changes no motion


def test_damage_is_named(die, tmp_path):
    with pytest.raises(ifa.IfaFileError, match="no such folder"):
        ifa.Database.open(tmp_path / "nowhere")
    with pytest.raises(ifa.IfaFileError, match="is not a database"):
        ifa.Database.open(tmp_path)
    built = ifa.Database.build(die, tmp_path, 20)
    (column,) = tmp_path.glob("nodes.amplitude.*")
    good = column.read_bytes()
    column.unlink()
    column.write_bytes(good[:-5] + bytes([good[-5] ^ 1]) + good[-4:])
    opened = ifa.Database.open(tmp_path)  # sizes are right, and it does not read it all
    with pytest.raises(ifa.IfaFileError, match=f"{column.name}: is damaged"):
        opened.check()
    column.unlink()
    column.write_bytes(good[:-4])
    with pytest.raises(ifa.IfaFileError, match=f"{column.name}: is damaged"):
        ifa.Database.open(tmp_path)
    manifest = tmp_path / "nodes.manifest"
    manifest.write_text(manifest.read_text().replace("restitution 0.45", "restitution 0.46"))
    with pytest.raises(ifa.IfaFileError, match=r"nodes.manifest: is damaged"):
        ifa.Database.open(tmp_path)
    built.check()  # it still has its own


def test_killed_at_any_moment_it_goes_on_to_the_same_bytes(die, tmp_path):
    simulations = 12_000
    whole, other = tmp_path / "whole", tmp_path / "other"
    build = [sys.executable, "-c", _BUILD]
    began = time.monotonic()
    subprocess.run([*build, str(whole), str(simulations)], check=True)
    lasts_s = time.monotonic() - began
    expected = contents(whole)
    draws = random.Random(4)
    killed = 0
    for _ in range(6):
        process = subprocess.Popen([*build, str(other), str(simulations)])
        time.sleep(draws.uniform(0.3, 1.0) * lasts_s)
        process.kill()
        killed += process.wait() == -signal.SIGKILL
        try:  # what can be opened is whole
            ifa.Database.open(other)
        except ifa.IfaFileError:
            continue
        assert contents(other).items() >= expected.items()
    ifa.Database.build(die, other, simulations, threads=1)
    assert killed > 0
    assert contents(other) == expected


_BUILD = """
import sys, ifa
die = ifa.bodies.get("d6", surface="wood")
ifa.Database.build(die, sys.argv[1], int(sys.argv[2]), threads=2)
"""


def test_a_full_disk_is_an_error_and_the_build_goes_on(die, tmp_path):
    """A limit on the size of files stands in for the disk: first in a shard, then in the join."""
    whole, other = tmp_path / "whole", tmp_path / "other"
    ifa.Database.build(die, whole, SIMULATIONS)
    for limit, where in ((200_000, "shards"), (1_000_000 * 2, "nodes.")):
        done = subprocess.run(
            [sys.executable, "-c", _BUILD, str(other), str(SIMULATIONS * 2)],
            capture_output=True,
            text=True,
            preexec_fn=lambda limit=limit: resource.setrlimit(
                resource.RLIMIT_FSIZE, (limit, limit)
            ),
        )
        assert done.returncode == 1
        last = done.stderr.strip().splitlines()[-1]
        assert last.startswith("ifa.IfaFileError: ") and where in last and "File too large" in last
        with pytest.raises(ifa.IfaFileError, match="is not complete"):
            ifa.Database.open(other)
        assert not list(other.rglob("*.part"))
    ifa.Database.build(die, other, SIMULATIONS * 2)
    ifa.Database.build(die, whole, SIMULATIONS * 2)
    assert contents(other) == contents(whole)


def test_a_cancelled_build_goes_on(die, tmp_path):
    progress = ifa.Progress()
    progress.cancel()
    with pytest.raises(ifa.Cancelled):
        ifa.Database.build(die, tmp_path, 3000, progress=progress)
    with pytest.raises(ifa.IfaValueError, match=r"^events: "):
        ifa.Database.build(die, tmp_path, 3000, events="contact")
    watched = ifa.Progress()
    ifa.Database.build(die, tmp_path, 3000, progress=watched)
    assert watched.fraction == 1.0


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_written_is_named(die, tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(ifa.IfaFileError, match="cannot be made: Permission denied"):
        ifa.Database.build(die, tmp_path / "db", 10)


def test_two_builds_of_one_folder_do_not_mix(die, tmp_path):
    import fcntl

    file = os.open(tmp_path, os.O_RDONLY)
    try:
        fcntl.flock(file, fcntl.LOCK_EX)
        with pytest.raises(ifa.IfaFileError, match="by another process"):
            ifa.Database.build(die, tmp_path, 10)
    finally:
        os.close(file)


def test_command_line_builds_goes_on_and_checks(tmp_path):
    out = tmp_path / "db"
    done = run("build", "d6", "-o", out, "--simulations", 30, "--seed", 7, "--json", "--cone", 80)
    assert (done.returncode, done.stderr) == (0, "")
    content = json.loads(done.stdout)
    assert (content["simulations"], content["seed"], content["events"]) == (30, 7, "audible")
    assert content["cone_rad"] == pytest.approx(np.radians(80.0), rel=1e-15)
    assert content["nodes"] == len(ifa.Database.open(out))
    more = ["build", "d6", "-o", out, "--seed", 7, "--cone", 80, "--check"]
    done = run(*more, "--simulations", 40, "--threads", 1)
    assert done.returncode == 0
    assert "of 40 simulations" in done.stdout and "checksums agree" in done.stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["d6"], "required"),
        (["d6", "-o", "db", "--simulations", "0"], "simulations: "),
        (["d6", "-o", "db", "--simulations", "many"], "--simulations"),
        (["d6", "-o", "db", "--cone", "100"], "cone_rad: "),
        (["d6", "-o", "db", "--merge-gap", "-1"], "merge_gap_s: "),
        (["d7", "-o", "db"], "body: "),
        (["d6", "-o", "."], "other files"),
    ],
)
def test_command_line_refuses_with_exit_2(words, message, tmp_path):
    (tmp_path / "letter.txt").write_text("Dear")
    done = run("build", *words, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr.splitlines()[-1]
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_cancels_with_exit_4_and_the_build_goes_on(number, tmp_path):
    command = [sys.executable, "-m", "ifa.cli", "build", "coin", "-o", str(tmp_path / "db")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not (tmp_path / "db" / "shards" / "plan").exists():
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(number)
    out, error = process.communicate()
    assert (process.returncode, out) == (cli.CANCELLED, "")
    assert error.splitlines()[-1] == "ifa: cancelled: the same command goes on from here"


class _Stream:
    def __init__(self):
        self.text = ""

    def isatty(self):
        return True

    def write(self, text):
        self.text = text

    def flush(self):
        pass


def test_the_meter_says_rate_and_end(monkeypatch):
    """Half was there; then 100 simulations a second: the rate is not that of what was there."""
    now = [1000.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time, "time", lambda: 1e9)
    stream = _Stream()
    share = ifa._core.SIMULATED_SHARE
    meter = BuildMeter(stream, 2000)
    meter.show(0.0)
    assert "simulations/s" not in stream.text
    meter.show(0.5 * share)
    assert "simulations/s" not in stream.text
    now[0] += 4.0
    meter.show(0.7 * share)
    left_s = round((1.0 - 0.7 * share) * 2000 / share / 100)
    ends = time.strftime("%H:%M:%S", time.localtime(1e9 + (1.0 - 0.7 * share) * 2000 / share / 100))
    assert f"building [{'#' * 20}" in stream.text
    assert f"100 simulations/s, ends {ends} (in {left_s} s)" in stream.text
