"""Batches and random states from Python: against single simulations, closed forms, and misuse."""

import gc
import os
import signal
import sys
import threading
import tracemalloc
from dataclasses import fields, replace

import ifa
import numpy as np
import pytest

ARRAYS = [field.name for field in fields(ifa.Batch)]
# Ends by itself after 100,000 impacts; of a batch of these some are still to come when one is done.
ENDLESS = ifa.Body.ball(0.02, mass_kg=0.03, restitution=1.0, friction=0.0)


@pytest.fixture(scope="module")
def die():
    return ifa.bodies.get("d6")


@pytest.fixture(scope="module")
def shard():
    """Principal axes far from those of its vertices."""
    inertia = [[3e-6, 4e-7, -2e-7], [4e-7, 2.5e-6, 3e-7], [-2e-7, 3e-7, 2e-6]]
    corners = [(0.02, 0, -0.01), (-0.01, 0.013, 0), (-0.004, -0.02, 0.003), (0.001, 0.002, 0.03)]
    return ifa.Body.from_vertices(corners, 0.001, mass_kg=0.02, inertia_kg_m2=inertia)


def rows(n, **parts):
    """n still states 1 m up, but for what is given."""
    still = {
        "position_m": np.tile([0.0, 0.0, 1.0], (n, 1)),
        "quaternion_wxyz": np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)),
        "velocity_m_s": np.zeros((n, 3)),
        "angular_velocity_rad_s": np.zeros((n, 3)),
    }
    return ifa.State(**(still | parts))


def same(a, b, rows_of_b=slice(None)):
    """All arrays of `a` are, byte for byte, those rows of `b`."""
    return all(getattr(a, x).tobytes() == getattr(b, x)[rows_of_b].tobytes() for x in ARRAYS)


def turned(quaternions, vector):
    """(n, 3): a vector of the body's axes in world axes."""
    w, axis = quaternions[:, :1], quaternions[:, 1:]
    twice = 2.0 * np.cross(axis, vector)
    return vector + w * twice + np.cross(axis, twice)


class TestSampleStates:
    def test_the_lowest_point_touches_the_ground(self, shard):
        states = ifa.sample_states(shard, 500)
        heights = [turned(states.quaternion_wxyz, p)[:, 2] for p in shard.vertices_m]
        lowest = states.position_m[:, 2] + np.min(heights, axis=0) - shard.radius_m
        np.testing.assert_allclose(lowest, 0.0, atol=1e-16)  # a few roundings of 0.03 m
        np.testing.assert_array_equal(states.position_m[:, :2], 0.0)

    def test_row_k_is_sample_first_plus_k(self, shard):
        whole = ifa.sample_states(shard, 50, seed=9)
        for n, first in ((1, 0), (7, 3), (30, 20)):
            part = ifa.sample_states(shard, n, seed=9, first=first, threads=1)
            for x in ("position_m", "quaternion_wxyz", "velocity_m_s", "angular_velocity_rad_s"):
                expected = getattr(whole, x)[first : first + n]
                assert getattr(part, x).tobytes() == expected.tobytes()
        other = ifa.sample_states(shard, 50, seed=10)
        assert not (other.quaternion_wxyz == whole.quaternion_wxyz).any()
        assert len(ifa.sample_states(shard, 1, first=2**64 - 1)) == 1

    @pytest.mark.parametrize("cone", [np.pi / 6, np.radians(80)])
    def test_speeds_spins_and_directions_are_as_asked(self, die, cone):
        n = 20_000
        states = ifa.sample_states(
            die, n, seed=4, cone_rad=cone, speed_m_s=(1.0, 3.0), spin_rad_s=(2.0, 6.0)
        )
        # A mean of n has the standard deviation s / sqrt(n); 4 of them is one failure in 16,000.
        # Uniform over a width w: s = w / sqrt(12).
        speed = np.linalg.norm(states.velocity_m_s, axis=1)
        spin = np.linalg.norm(states.angular_velocity_rad_s, axis=1)
        for value, low, high in ((speed, 1.0, 3.0), (spin, 2.0, 6.0)):
            assert low - 1e-12 <= value.min() and value.max() <= high + 1e-12  # rounding of a norm
            within = 4 * (high - low) / np.sqrt(12 * n)
            assert value.mean() == pytest.approx((low + high) / 2, abs=within)
        # Cosine-weighted within the cone: sin^2 of the angle is uniform up to sin^2 of the cone.
        direction = states.velocity_m_s / speed[:, None]
        assert (direction[:, 2] < 0.0).all()
        share = (direction[:, 0] ** 2 + direction[:, 1] ** 2) / np.sin(cone) ** 2
        assert share.max() <= 1.0 + 1e-12
        assert share.mean() == pytest.approx(0.5, abs=4 / np.sqrt(12 * n))
        assert (share**2).mean() == pytest.approx(1 / 3, abs=4 * np.sqrt(4 / 45 / n))
        # Uniform directions have components of mean 0 and variance 1/3, the fourth moment 1/5.
        for d in (
            turned(states.quaternion_wxyz, np.array([0.6, 0.0, 0.8])),
            states.angular_velocity_rad_s / spin[:, None],
        ):
            np.testing.assert_allclose(d.mean(axis=0), 0.0, atol=4 / np.sqrt(3 * n))
            square = 4 * np.sqrt((1 / 5 - 1 / 9) / n)
            np.testing.assert_allclose((d**2).mean(axis=0), 1 / 3, atol=square)

    def test_bounds_may_coincide_and_none_may_be_asked_for(self, die):
        states = ifa.sample_states(die, 3, cone_rad=0.0, speed_m_s=(2, 2), spin_rad_s=(0, 0))
        np.testing.assert_array_equal(states.velocity_m_s, np.tile([0.0, 0.0, -2.0], (3, 1)))
        np.testing.assert_array_equal(states.angular_velocity_rad_s, 0.0)
        assert len(ifa.sample_states(die, 0)) == 0

    @pytest.mark.parametrize(
        ("name", "call"),
        [
            ("body", {"body": "d6"}),
            ("n", {"n": -1}),
            ("n", {"n": 2.0}),
            ("n", {"n": True}),
            ("seed", {"seed": -1}),
            ("seed", {"seed": 2**64}),
            ("first", {"first": 2**64 - 1}),  # the second of the two is beyond
            ("first", {"first": None}),
            ("cone_rad", {"cone_rad": 1.6}),
            ("cone_rad", {"cone_rad": -0.1}),
            ("cone_rad", {"cone_rad": np.nan}),
            ("speed_m_s", {"speed_m_s": 3.0}),
            ("speed_m_s", {"speed_m_s": (3.0, 2.0)}),
            ("speed_m_s", {"speed_m_s": (-1.0, 2.0)}),
            ("speed_m_s", {"speed_m_s": (1.0, np.inf)}),
            ("spin_rad_s", {"spin_rad_s": (np.nan, 2.0)}),
            ("spin_rad_s", {"spin_rad_s": "fast"}),
            ("threads", {"threads": 0}),
        ],
    )
    def test_errors_name_the_argument(self, die, name, call):
        with pytest.raises(ifa.IfaValueError, match=f"^{name}:"):
            ifa.sample_states(**({"body": die, "n": 2} | call))

    @pytest.mark.parametrize("name", ["d6", "eraser", "card", "d20", "ball", "coin"])
    def test_same_bytes_for_every_instruction_set(self, name):
        body = ifa.bodies.get(name)
        states = ifa.sample_states(body, 61, seed=4)  # no multiple of any width
        sets = ifa.instruction_sets()
        assert sets[0] == "scalar"
        first, *others = (
            ifa.simulate_batch(body, states, until_s=3.0, instruction_set=name, threads=1)
            for name in sets
        )
        for other in others:
            for field, array in vars(first).items():
                if not field.startswith("hit_") or field == "hit_count":
                    assert array.tobytes() == vars(other)[field].tobytes(), field
            for i in range(len(states)):
                assert first.hits(i).impulse_n_s.tobytes() == other.hits(i).impulse_n_s.tobytes()

    def test_unknown_instruction_set(self, die):
        states = ifa.sample_states(die, 2)
        with pytest.raises(ifa.IfaValueError, match="instruction_set: 'sse9' does not run here"):
            ifa.simulate_batch(die, states, instruction_set="sse9")


class TestEachSampleIsASimulation:
    @pytest.mark.parametrize("until_s", [None, 0.15])
    def test_same_bytes_as_one_by_one(self, die, shard, until_s):
        bodies = [die, shard, ifa.bodies.get("eraser")] * 4
        states = [ifa.sample_states(body, 1, first=i) for i, body in enumerate(bodies)]
        stacked = ifa.State(
            *(
                np.concatenate([getattr(s, x) for s in states])
                for x in ("position_m", "quaternion_wxyz", "velocity_m_s", "angular_velocity_rad_s")
            )
        )
        batch = ifa.simulate_batch(bodies, stacked, until_s=until_s, hits=200, step_s=2e-3)
        ends = batch.states
        for i, body in enumerate(bodies):
            run = ifa.simulate(body, stacked[i], until_s=until_s, step_s=2e-3)
            assert ifa.SampleStatus(batch.status[i]).name.lower() == run.status
            assert batch.end_time_s[i] == (run.times_s[-1] if run.rest_s is None else run.rest_s)
            end = run.states[-1]
            np.testing.assert_array_equal(ends.position_m[i], end.position_m)
            np.testing.assert_array_equal(ends.velocity_m_s[i], end.velocity_m_s)
            np.testing.assert_array_equal(
                ends.angular_velocity_rad_s[i], end.angular_velocity_rad_s
            )
            sign = np.sign(ends.quaternion_wxyz[i] @ end.quaternion_wxyz)  # q and -q are one
            np.testing.assert_array_equal(sign * ends.quaternion_wxyz[i], end.quaternion_wxyz)
            assert batch.hit_count[i] == len(run.hits) == len(batch.hits(i)) > 0
            for x in ("time_s", "impulse_n_s", "approach_speed_m_s", "position_m"):
                assert getattr(batch.hits(i), x).tobytes() == getattr(run.hits, x).tobytes()

    def test_gravity_and_time_limit_reach_each_sample(self, die):
        velocity = np.arange(12.0).reshape(4, 3)
        batch = ifa.simulate_batch(
            die, rows(4, velocity_m_s=velocity), until_s=0.25, gravity_m_s2=(1.0, 0.0, -2.0)
        )
        assert (batch.status == ifa.SampleStatus.TIME_LIMIT).all()
        np.testing.assert_array_equal(batch.end_time_s, 0.25)
        np.testing.assert_allclose(
            batch.velocity_m_s, velocity + 0.25 * np.array([1.0, 0.0, -2.0]), rtol=1e-15
        )
        assert (batch.hit_count == 0).all() and len(batch.hits(2)) == 0

    def test_status_of_a_ball_that_never_rests(self):
        # 100,000 impacts of a lossless ball: the engine's stated limit
        batch = ifa.simulate_batch(ENDLESS, rows(1), hits=3)
        assert batch.status[0] == ifa.SampleStatus.IMPACT_LIMIT
        assert batch.hit_count[0] == 100_000
        fall = np.sqrt(2 * 0.98 / 9.81)  # from 1 m down to its radius, and as long up again
        np.testing.assert_allclose(batch.hits(0).time_s, fall * np.array([1, 3, 5]), rtol=1e-12)

    def test_empty_batch(self, die):
        progress = ifa.Progress()
        for body in (die, []):
            batch = ifa.simulate_batch(body, rows(0), progress=progress)
            assert len(batch) == len(batch.states) == 0
            assert batch.hit_impulse_n_s.shape == (0, 64, 3)
        assert progress.fraction == 1.0


@pytest.fixture(scope="module")
def whole(shard):
    """60 states and their batch on one thread."""
    states = ifa.sample_states(shard, 60, seed=1)
    return states, ifa.simulate_batch(shard, states, threads=1)


class TestSameBytes:
    @pytest.mark.parametrize("threads", [2, 3, 7, None])
    def test_for_any_number_of_threads(self, shard, whole, threads):
        states, expected = whole
        assert same(ifa.simulate_batch(shard, states, threads=threads), expected)

    @pytest.mark.parametrize("size", [1, 7, 59])
    def test_for_any_batch_size(self, shard, whole, size):
        states, expected = whole
        for at in range(0, 60, size):
            part = slice(at, at + size)
            assert same(ifa.simulate_batch(shard, states[part]), expected, part)

    def test_in_any_order(self, shard, whole):
        states, expected = whole
        order = np.random.default_rng(0).permutation(60)
        assert same(ifa.simulate_batch(shard, states[order]), expected, order)

    def test_for_one_body_or_one_for_each(self, shard, whole):
        states, expected = whole
        assert same(ifa.simulate_batch([shard] * 60, states), expected)

    def test_for_samples_beside_others(self, die, shard, whole):
        states, expected = whole
        bodies = [shard, die] * 30
        high = states.position_m + np.array([0.0, 0.0, 0.05])  # for the dice, above the ground
        high[::2] = states.position_m[::2]
        mixed = ifa.State(
            high, states.quaternion_wxyz, states.velocity_m_s, states.angular_velocity_rad_s
        )
        batch = ifa.simulate_batch(bodies, mixed)
        for i in range(0, 60, 2):
            for x in ("time_s", "impulse_n_s", "approach_speed_m_s", "position_m"):
                a, b = getattr(batch.hits(i), x), getattr(expected.hits(i), x)
                assert a.tobytes() == b.tobytes()


class TestOut:
    def test_is_written_and_returned(self, die):
        states = ifa.sample_states(die, 20)
        expected = ifa.simulate_batch(die, states, hits=9)
        out = ifa.Batch.allocate(20, 9)
        arrays = [getattr(out, x) for x in ARRAYS]
        assert ifa.simulate_batch(die, states, out=out) is out
        assert all(getattr(out, x) is a for x, a in zip(ARRAYS, arrays, strict=True))
        assert same(out, expected)

    def test_may_be_the_callers_own_memory(self, die, tmp_path):
        states = ifa.sample_states(die, 10)
        times = np.memmap(tmp_path / "times", np.float64, "w+", shape=(10, 5))
        big = np.zeros((30, 3))
        out = replace(ifa.Batch.allocate(10, 5), hit_time_s=times, position_m=big[10:20])
        ifa.simulate_batch(die, states, out=out)
        expected = ifa.simulate_batch(die, states, hits=5)
        np.testing.assert_array_equal(big[10:20], expected.position_m)
        assert not big[:10].any() and not big[20:].any()
        times.flush()
        saved = np.fromfile(tmp_path / "times").reshape(10, 5)
        np.testing.assert_array_equal(saved, expected.hit_time_s)

    def test_what_a_sample_does_not_have_stays(self, die):
        states = ifa.sample_states(die, 20)
        counts = ifa.simulate_batch(die, states).hit_count
        room = int(np.median(counts))  # too little for some, more than enough for others
        out = ifa.Batch.allocate(20, room)
        for x in ARRAYS:
            getattr(out, x)[...] = 77
        ifa.simulate_batch(die, states, out=out)
        np.testing.assert_array_equal(out.hit_count, counts)
        assert (counts > room).any() and (counts < room).any()
        for i, count in enumerate(counts):
            assert len(out.hits(i)) == min(count, room)
            assert (out.hit_time_s[i, count:] == 77).all()
            assert (out.hit_impulse_n_s[i, count:] == 77).all()
            assert (out.hits(i).time_s < 77).all()  # no padding among them; s of a throw

    def test_room_for_no_hits(self, die):
        batch = ifa.simulate_batch(die, ifa.sample_states(die, 3), hits=0)
        assert batch.hit_time_s.shape == (3, 0) and (batch.hit_count > 0).all()
        assert len(batch.hits(0)) == 0

    @pytest.mark.parametrize(
        ("name", "array"),
        [
            ("status", np.zeros(4, np.int8)),
            ("status", np.zeros(5, np.uint8)),
            ("end_time_s", [0.0] * 4),
            ("end_time_s", np.zeros(4, np.float32)),
            ("end_time_s", np.zeros(4, ">f8")),
            ("end_time_s", np.zeros(8)[::2]),
            ("position_m", np.zeros((3, 4)).T),
            ("position_m", np.zeros((4, 4))),
            ("quaternion_wxyz", np.zeros((4, 3))),
            ("velocity_m_s", np.broadcast_to(np.zeros(3), (4, 3))),
            ("velocity_m_s", np.zeros((4, 3))[::-1]),
            ("angular_velocity_rad_s", None),
            ("hit_count", np.zeros(4, np.int64)),
            ("hit_time_s", np.zeros((4, 7))),
            ("hit_time_s", np.zeros((4, 8), order="F")),
            ("hit_time_s", np.zeros(32)),
            ("hit_impulse_n_s", np.zeros((4, 8))),
            ("hit_position_m", np.zeros(1 + 4 * 8 * 24, np.uint8)[1:].view("f8").reshape(4, 8, 3)),
        ],
    )
    def test_a_wrong_array_is_named_and_nothing_written(self, die, name, array):
        good = ifa.Batch.allocate(4, 8)
        with pytest.raises(ifa.IfaValueError, match=rf"^out\.{name}:"):
            ifa.simulate_batch(die, rows(4), hits=8, out=replace(good, **{name: array}))
        assert same(good, ifa.Batch.allocate(4, 8))

    @pytest.mark.parametrize("name", ARRAYS)
    def test_a_read_only_array_is_named(self, die, name):
        out = ifa.Batch.allocate(4, 8)
        getattr(out, name).flags.writeable = False
        with pytest.raises(ifa.IfaValueError, match=rf"^out\.{name}: must be writable"):
            ifa.simulate_batch(die, rows(4), out=out)

    def test_arrays_must_not_overlap(self, die):
        out = ifa.Batch.allocate(4, 8)
        for shared in (out.position_m, np.zeros(30)[6:18].reshape(4, 3)):
            both = replace(out, position_m=shared, angular_velocity_rad_s=shared.reshape(4, 3))
            with pytest.raises(ifa.IfaValueError, match=r"^out\.angular_velocity_rad_s: .*overlap"):
                ifa.simulate_batch(die, rows(4), out=both)

    def test_is_a_batch(self, die):
        with pytest.raises(ifa.IfaValueError, match=r"^out:"):
            ifa.simulate_batch(die, rows(4), out={})
        assert not ifa.Batch.allocate(0, 0).hit_time_s.size
        for name, call in (("n", (-1, 3)), ("hits", (3, -1)), ("hits", (3, 2.5))):
            with pytest.raises(ifa.IfaValueError, match=f"^{name}:"):
                ifa.Batch.allocate(*call)


class TestArguments:
    @pytest.mark.parametrize(
        ("name", "call"),
        [
            ("body", {"body": None}),
            ("body", {"body": "d6"}),
            ("body", {"body": []}),
            ("states", {"states": None}),
            ("states", {"states": ifa.State((0, 0, 1))}),
            ("step_s", {"step_s": 0.0}),
            ("until_s", {"until_s": np.inf}),
            ("until_s", {"until_s": -1.0}),
            ("gravity_m_s2", {"gravity_m_s2": (0, 0, 1.0)}),
            ("hits", {"hits": -1}),
            ("hits", {"hits": 1.5}),
            ("threads", {"threads": 0}),
            ("threads", {"threads": "all"}),
            ("progress", {"progress": 1}),
        ],
    )
    def test_errors_name_the_argument(self, die, name, call):
        with pytest.raises(ifa.IfaValueError, match=f"^{name}:"):
            ifa.simulate_batch(**({"body": die, "states": rows(2)} | call))

    def test_bodies_are_counted_and_named_by_row(self, die):
        with pytest.raises(ifa.IfaValueError, match=r"^body: .* 3 states, got 2"):
            ifa.simulate_batch([die] * 2, rows(3))
        with pytest.raises(ifa.IfaValueError, match=r"^body: row 1 "):
            ifa.simulate_batch([die, None, die], rows(3))

    def test_a_row_below_the_ground_is_named_and_nothing_written(self, shard):
        touching = ifa.sample_states(shard, 5)
        position = touching.position_m.copy()
        position[3, 2] -= 0.002
        states = ifa.State(
            position,
            touching.quaternion_wxyz,
            touching.velocity_m_s,
            touching.angular_velocity_rad_s,
        )
        out = ifa.Batch.allocate(5, 8)
        with pytest.raises(
            ifa.IfaValueError, match=r"^states: row 3: position_m: the body begins 0\.002 m below"
        ):
            ifa.simulate_batch(shard, states, out=out)
        assert same(out, ifa.Batch.allocate(5, 8))


class TestThreads:
    def test_another_thread_runs_meanwhile_and_cancels(self, die):
        """Without releasing the GIL the batch would end before the other thread could cancel."""
        progress, out = ifa.Progress(), ifa.Batch.allocate(20_000, 16)
        states = ifa.sample_states(die, 20_000)

        def cancel_once_it_runs():
            while progress.fraction == 0.0:
                pass
            progress.cancel()

        watcher = threading.Thread(target=cancel_once_it_runs, daemon=True)
        watcher.start()
        with pytest.raises(ifa.Cancelled):
            ifa.simulate_batch(die, states, threads=2, out=out, progress=progress)
        watcher.join()
        done = np.flatnonzero(out.status != ifa.SampleStatus.NOT_RUN)
        assert 0 < len(done) < 20_000
        assert len(done) >= 20_000 * progress.fraction
        again = ifa.simulate_batch(die, states[done], hits=16)
        assert same(again, out, done)  # those are whole ...
        untouched = ifa.Batch.allocate(20_000, 16)
        left = np.flatnonzero(out.status == ifa.SampleStatus.NOT_RUN)
        assert all((getattr(out, x)[left] == getattr(untouched, x)[left]).all() for x in ARRAYS)
        assert len(out.hits(int(left[0]))) == 0  # ... and the others as they were

    def test_cancelled_before_it_begins(self, die):
        progress, out = ifa.Progress(), ifa.Batch.allocate(3, 4)
        progress.cancel()
        out.status[:] = ifa.SampleStatus.REST
        with pytest.raises(ifa.Cancelled):
            ifa.simulate_batch(die, rows(3), out=out, progress=progress)
        assert (out.status == ifa.SampleStatus.NOT_RUN).all()

    def test_progress_never_runs_backwards_and_ends_at_one(self, die):
        progress, seen = ifa.Progress(), [0.0]
        stop = threading.Event()

        def watch():
            while not stop.is_set():
                seen.append(progress.fraction)

        watcher = threading.Thread(target=watch)
        watcher.start()
        ifa.simulate_batch(die, ifa.sample_states(die, 1000), threads=4, progress=progress)
        stop.set()
        watcher.join()
        assert (np.diff(seen) >= 0.0).all()
        assert progress.fraction == 1.0

    def test_ctrl_c(self):
        n = 100
        progress, out = ifa.Progress(), ifa.Batch.allocate(n, 4)

        def interrupt_once_it_runs():
            while progress.fraction == 0.0:
                pass
            os.kill(os.getpid(), signal.SIGINT)

        watcher = threading.Thread(target=interrupt_once_it_runs, daemon=True)
        watcher.start()
        with pytest.raises(KeyboardInterrupt):
            ifa.simulate_batch(ENDLESS, rows(n), threads=2, out=out, progress=progress)
        watcher.join()
        not_run = (out.status == ifa.SampleStatus.NOT_RUN).sum()
        assert 0 < not_run < n

    def test_batches_may_run_beside_each_other(self, die):
        states = ifa.sample_states(die, 100)
        expected = ifa.simulate_batch(die, states)
        batches = [ifa.Batch.allocate(100) for _ in range(4)]
        threads = [
            threading.Thread(target=ifa.simulate_batch, args=(die, states), kwargs={"out": out})
            for out in batches
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert all(same(batch, expected) for batch in batches)


def test_a_thousand_calls_leave_nothing_behind(die):
    states, out = rows(10), ifa.Batch.allocate(10, 4)

    def call(times):
        for _ in range(times):
            ifa.simulate_batch(die, states, until_s=0.01, out=out)
            with pytest.raises(ifa.IfaValueError):
                ifa.simulate_batch(die, states, step_s=-1.0, out=out)

    call(10)
    held = [sys.getrefcount(getattr(out, x)) for x in ARRAYS]
    tracemalloc.start()
    try:
        call(1000)  # fills CPython's and numpy's own caches, once
        gc.collect()
        before = tracemalloc.get_traced_memory()[0]
        call(1000)
        gc.collect()
        grown = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    # The smallest object, lost at each call, would be 16 kB; tracemalloc itself takes 1 kB.
    assert grown < 8_000
    assert [sys.getrefcount(getattr(out, x)) for x in ARRAYS] == held


def test_a_states_own_parts_make_the_same_state_again():
    states = ifa.sample_states(ifa.bodies.get("d20"), 1000)
    q = states.quaternion_wxyz
    assert states[:].quaternion_wxyz.tobytes() == q.tobytes()
    assert all(states[i].quaternion_wxyz.tobytes() == q[i].tobytes() for i in range(100))
