"""The engine on ODE from Python: both ways of flight, closed forms, errors, threads."""

import threading

import ifa
import numpy as np
import pytest

G = 9.81
THROWN = ifa.State((0, 0, 0.1), velocity_m_s=(1, 0, 0), angular_velocity_rad_s=(3, 9, -5))
FLIGHTS = ("exact", "stepped")


@pytest.fixture
def brick():
    return ifa.Body.box((0.01, 0.02, 0.03), mass_kg=0.05)


def same_bytes(a, b):
    return all(
        x.tobytes() == y.tobytes()
        for x, y in [
            (a.times_s, b.times_s),
            (a.states.position_m, b.states.position_m),
            (a.states.quaternion_wxyz, b.states.quaternion_wxyz),
            (a.states.velocity_m_s, b.states.velocity_m_s),
            (a.hits.impulse_n_s, b.hits.impulse_n_s),
        ]
    )


def test_bouncing_ball():
    height, e, radius = 0.5, 0.6, 0.02
    ball = ifa.Body.ball(radius, mass_kg=0.03, restitution=e)
    fall = np.sqrt(2 * height / G)
    state = ifa.State((0, 0, radius + height))
    exact = ifa.simulate(ball, state, engine="ode")
    powers = e ** np.arange(5)
    times = fall * (1 + 2 * (np.cumsum(powers) - 1))
    # ODE's contacts are soft by 1e-6 of each velocity
    np.testing.assert_allclose(exact.hits.time_s[:5], times, atol=1e-5)
    np.testing.assert_allclose(
        exact.hits.impulse_n_s[:5, 2], 0.03 * (1 + e) * G * fall * powers, rtol=1e-4
    )
    assert exact.status == "rest" and exact.rest_s is not None
    np.testing.assert_array_equal(exact.states.velocity_m_s[-1], 0.0)
    # a step late at most, and half a step early by Euler's fall: the first impact
    stepped = ifa.simulate(ball, state, engine="ode", step_s=1e-3, flight="stepped")
    assert -0.6e-3 < stepped.hits.time_s[0] - fall < 1.1e-3
    assert abs(stepped.hits.time_s[0] - fall) > 1e-6


@pytest.mark.parametrize("flight", FLIGHTS)
def test_shapes_and_both_sides_of_each_impact(brick, flight):
    run = ifa.simulate(brick, THROWN, engine="ode", flight=flight)
    n = len(run.times_s)
    assert run.status == "rest"
    assert run.states.quaternion_wxyz.shape == (n, 4)
    assert (np.diff(run.times_s) >= 0).all() and run.times_s[0] == 0.0
    assert len(run.hits) > 3 and (run.hits.approach_speed_m_s > 0.01).all()
    for time, impulse in zip(run.hits.time_s, run.hits.impulse_n_s, strict=True):
        rows = np.flatnonzero(run.times_s == time)
        assert len(rows) >= 2
        change = run.states.velocity_m_s[rows[-1]] - run.states.velocity_m_s[rows[0]]
        np.testing.assert_allclose(0.05 * change, impulse, atol=1e-15)


def test_body_axes_are_the_users():
    # Principal axes that are not the body's: the states must come back in the body's.
    corners = np.array([[x, y, z] for x in (0, 3) for y in (0, 2) for z in (0, 1)]) * 0.01
    sheared = corners + np.outer(corners[:, 2], (1.0, 0.5, 0.0))
    body = ifa.Body.from_vertices(sheared, mass_kg=0.02)
    state = ifa.State((0, 0, 0.5), (0.5, 0.1, -0.7, 0.2), (0, 0, 0), (4.0, -2.0, 3.0))
    run = ifa.simulate(body, state, engine="ode", until_s=0.2)
    flown = ifa.fly(body, state, [0.2])
    np.testing.assert_allclose(run.states.quaternion_wxyz[-1], flown.quaternion_wxyz[0], atol=1e-14)
    np.testing.assert_array_equal(run.states.position_m[0], state.position_m)


@pytest.mark.parametrize("flight", FLIGHTS)
def test_same_bytes_in_many_threads(brick, flight):
    alone = ifa.simulate(brick, THROWN, engine="ode", flight=flight)
    runs = [None] * 8

    def work(i):
        ifa.simulate(brick, ifa.State((0, 0, 0.2 + 0.01 * i)), engine="ode", until_s=0.3)
        runs[i] = ifa.simulate(brick, THROWN, engine="ode", flight=flight)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(len(runs))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(same_bytes(alone, run) for run in runs)


@pytest.mark.parametrize("flight", FLIGHTS)
def test_cancel(brick, flight):
    progress = ifa.Progress()
    progress.cancel()
    with pytest.raises(ifa.Cancelled):
        ifa.simulate(brick, THROWN, engine="ode", flight=flight, progress=progress)


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("engine", {"engine": "bullet"}),
        ("engine", {"engine": None}),
        ("flight", {"flight": "euler"}),
        ("flight", {"flight": True}),
        ("flight", {"engine": "event", "flight": "stepped"}),
        ("step_s", {"step_s": 0.0}),
        ("step_s", {"step_s": np.inf}),
        ("until_s", {"until_s": -1.0}),
        ("until_s", {"until_s": np.nan}),
        ("gravity_m_s2", {"gravity_m_s2": (0, 0, 9.81)}),
        ("position_m", {"state": ifa.State((0, 0, 0.0))}),
        ("state", {"state": None}),
    ],
)
def test_errors_name_the_argument(brick, name, call):
    with pytest.raises(ifa.IfaValueError, match=f"^{name}:"):
        ifa.simulate(brick, **({"state": THROWN, "engine": "ode"} | call))


@pytest.mark.parametrize("engine", ["event", "ode"])
@pytest.mark.parametrize("until_s", [None, 0.1])
@pytest.mark.parametrize("gravity", [0, 0.0, (0, 0, 0), np.zeros(3)])
def test_zero_gravity_is_refused(brick, engine, until_s, gravity):
    with pytest.raises(ifa.IfaValueError, match=r"^gravity_m_s2:"):
        ifa.simulate(brick, THROWN, engine=engine, until_s=until_s, gravity_m_s2=gravity)
    assert len(ifa.fly(brick, THROWN, [0.1], gravity_m_s2=gravity)) == 1  # but may fly without


@pytest.mark.parametrize(
    ("field", "bad"),
    [
        ("mass_kg", {"mass_kg": 0.0}),
        ("mass_kg", {"mass_kg": -1.0}),
        ("vertices_m", {"vertices_m": [[0, 0, 0], [1, 0, 0], [0, 1, np.nan], [0, 0, 1]]}),
        ("vertices_m", {"vertices_m": [[0, 0, 0], [1, 0, 0], [0, 1, np.inf], [0, 0, 1]]}),
        ("vertices_m", {"vertices_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]}),
        ("vertices_m", {"vertices_m": [[0, 0, 0]] * 4}),
        ("inertia_kg_m2", {"inertia_kg_m2": (1.0, 1.0, 2.1)}),
        ("inertia_kg_m2", {"inertia_kg_m2": (0.0, 1.0, 1.0)}),
        ("inertia_kg_m2", {"inertia_kg_m2": (1.0, -1.0, 1.0)}),
        ("restitution", {"restitution": 1.01}),
        ("restitution", {"restitution": -0.01}),
        ("restitution", {"restitution": np.nan}),
        ("friction", {"friction": -0.01}),
        ("friction", {"friction": np.nan}),
    ],
)
def test_no_body_that_an_engine_could_not_take(field, bad):
    tetrahedron = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    with pytest.raises(ifa.IfaValueError, match=f"^{field}:"):
        ifa.Body.from_vertices(**({"vertices_m": tetrahedron, "mass_kg": 1.0} | bad))
