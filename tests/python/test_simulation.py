"""States, flight and simulation from Python: shapes, errors, closed forms."""

import threading

import ifa
import numpy as np
import pytest

G = 9.81
RADIUS = 0.02


@pytest.fixture
def ball():
    return ifa.Body.ball(RADIUS, mass_kg=0.03, restitution=0.5)


@pytest.fixture
def brick():
    return ifa.Body.box((0.01, 0.02, 0.03), mass_kg=0.05)


def rotate(quaternion, points):
    w, axis = quaternion[0], np.asarray(quaternion[1:])
    twice = 2.0 * np.cross(axis, points)
    return points + w * twice + np.cross(axis, twice)


def heights(body, state, row):
    """Heights of the hull's points above the ground."""
    world = rotate(state.quaternion_wxyz[row], body.vertices_m)
    return world[:, 2] + state.position_m[row, 2] - body.radius_m


class TestState:
    def test_shapes_of_one_and_of_n(self):
        one = ifa.State((0, 0, 1))
        assert one.position_m.shape == (3,) and one.quaternion_wxyz.shape == (4,)
        np.testing.assert_array_equal(one.quaternion_wxyz, (1, 0, 0, 0))
        n = 5
        many = ifa.State(
            np.zeros((n, 3)), np.tile([2.0, 0, 0, 0], (n, 1)), np.zeros((n, 3)), np.zeros((n, 3))
        )
        assert len(many) == n
        np.testing.assert_array_equal(many.quaternion_wxyz[:, 0], np.ones(n))
        assert many[2].position_m.shape == (3,)
        assert len(many[1:3]) == 2

    def test_one_has_no_rows(self):
        with pytest.raises(TypeError):
            len(ifa.State((0, 0, 1)))
        with pytest.raises(TypeError):
            ifa.State((0, 0, 1))[0]

    def test_is_a_copy_that_does_not_change(self):
        position = np.array([0.0, 0.0, 1.0])
        state = ifa.State(position)
        position[2] = 9.0
        assert state.position_m[2] == 1.0
        with pytest.raises(ValueError):
            state.position_m[2] = 2.0

    @pytest.mark.parametrize(
        ("field", "fields"),
        [
            ("position_m", {"position_m": (0, 0)}),
            ("position_m", {"position_m": (0, 0, np.nan)}),
            ("position_m", {"position_m": "up"}),
            ("quaternion_wxyz", {"quaternion_wxyz": (0, 0, 0, 0)}),
            ("quaternion_wxyz", {"quaternion_wxyz": (1, 0, 0)}),
            ("velocity_m_s", {"velocity_m_s": (np.inf, 0, 0)}),
            ("velocity_m_s", {"velocity_m_s": np.zeros((2, 3))}),
            ("angular_velocity_rad_s", {"angular_velocity_rad_s": (0, 0, 0, 0)}),
        ],
    )
    def test_errors_name_the_field(self, field, fields):
        with pytest.raises(ifa.IfaValueError, match=f"^{field}:"):
            ifa.State(**({"position_m": (0, 0, 1)} | fields))


class TestFly:
    def test_parabola_and_constant_spin(self, ball):
        state = ifa.State((1, 2, 3), velocity_m_s=(0.5, 0, 2), angular_velocity_rad_s=(0, 0, 4))
        times = np.array([-0.3, 0.0, 0.2, 0.7])  # quarter turns at most: the sign goes on
        flown = ifa.fly(ball, state, times)
        assert isinstance(flown, ifa.State) and len(flown) == 4
        np.testing.assert_allclose(
            flown.position_m[:, 2], 3 + 2 * times - 0.5 * G * times**2, atol=1e-14
        )
        np.testing.assert_allclose(flown.velocity_m_s[:, 2], 2 - G * times, atol=1e-14)
        np.testing.assert_allclose(flown.quaternion_wxyz[:, 0], np.cos(2 * times), atol=1e-14)
        np.testing.assert_allclose(flown.quaternion_wxyz[:, 3], np.sin(2 * times), atol=1e-14)

    def test_momentum_in_world_axes_is_kept(self, brick):
        state = ifa.State((0, 0, 1), (0.5, 0.1, -0.7, 0.2), (0, 0, 0), (12.0, -9.0, 15.0))
        flown = ifa.fly(brick, state, np.linspace(0, 1, 50))
        momenta = []
        for q, w in zip(flown.quaternion_wxyz, flown.angular_velocity_rad_s, strict=True):
            axes = rotate(q, np.eye(3)).T  # columns: body axes in the world
            momenta.append(axes @ brick.inertia_kg_m2 @ axes.T @ w)
        np.testing.assert_allclose(
            momenta, np.tile(momenta[0], (50, 1)), rtol=0, atol=1e-13 * np.linalg.norm(momenta[0])
        )

    def test_gravity_is_a_size_or_a_vector(self, ball):
        state = ifa.State((0, 0, 1))
        down = ifa.fly(ball, state, [1.0], gravity_m_s2=2.0)
        same = ifa.fly(ball, state, [1.0], gravity_m_s2=(0, 0, -2.0))
        np.testing.assert_array_equal(down.position_m, same.position_m)
        none = ifa.fly(ball, state, [1.0], gravity_m_s2=0)
        np.testing.assert_array_equal(none.position_m, [[0, 0, 1]])

    @pytest.mark.parametrize(
        ("name", "call"),
        [
            ("times_s", {"times_s": 1.0}),
            ("times_s", {"times_s": [np.nan]}),
            ("gravity_m_s2", {"gravity_m_s2": -9.81}),
            ("gravity_m_s2", {"gravity_m_s2": (0, 0)}),
            ("gravity_m_s2", {"gravity_m_s2": (0, 0, np.inf)}),
            ("state", {"state": "falling"}),
            (
                "state",
                {
                    "state": ifa.State(
                        np.zeros((1, 3)), np.ones((1, 4)), np.zeros((1, 3)), np.zeros((1, 3))
                    )
                },
            ),
        ],
    )
    def test_errors_name_the_argument(self, ball, name, call):
        arguments = {"state": ifa.State((0, 0, 1)), "times_s": [0.1]} | call
        with pytest.raises(ifa.IfaValueError, match=f"^{name}:"):
            ifa.fly(ball, **arguments)


class TestSimulate:
    def test_bouncing_ball(self, ball):
        height, e = 0.5, 0.5
        run = ifa.simulate(ball, ifa.State((0, 0, RADIUS + height)))
        fall = np.sqrt(2 * height / G)
        k = np.arange(5)
        # sum of e^i from 1 to k is (e - e^(k+1)) / (1 - e)
        np.testing.assert_allclose(
            run.hits.time_s[:5], fall * (1 + 2 * (e - e ** (k + 1)) / (1 - e)), atol=1e-9
        )
        speeds = np.sqrt(2 * G * height) * e**k
        np.testing.assert_allclose(run.hits.approach_speed_m_s[:5], speeds, rtol=1e-9)
        np.testing.assert_allclose(run.hits.impulse_n_s[:5, 2], 0.03 * (1 + e) * speeds, rtol=1e-9)
        np.testing.assert_allclose(run.hits.position_m[:5], 0.0, atol=1e-12)
        assert run.status == "rest"
        limit = fall * (1 + e) / (1 - e)
        assert limit - 0.01 < run.rest_s <= limit + 1e-3  # the micro speed cuts the last bounces
        np.testing.assert_array_equal(run.states.velocity_m_s[-1], 0.0)

    def test_shapes_and_both_sides_of_each_impact(self, brick):
        state = ifa.State((0, 0, 0.1), velocity_m_s=(1, 0, 0), angular_velocity_rad_s=(3, 9, -5))
        run = ifa.simulate(brick, state)
        n, hits = len(run.times_s), len(run.hits)
        assert len(run.states) == n
        assert run.states.quaternion_wxyz.shape == (n, 4)
        assert run.hits.impulse_n_s.shape == run.hits.position_m.shape == (hits, 3)
        assert run.times_s[0] == 0.0 and (np.diff(run.times_s) >= 0).all()
        np.testing.assert_array_equal(run.states.position_m[0], (0, 0, 0.1))
        for time, impulse in zip(run.hits.time_s, run.hits.impulse_n_s, strict=True):
            rows = np.flatnonzero(run.times_s == time)
            assert len(rows) >= 2
            change = run.states.velocity_m_s[rows[-1]] - run.states.velocity_m_s[rows[0]]
            np.testing.assert_allclose(0.05 * change, impulse, atol=1e-9)
        for row in range(n):
            assert heights(brick, run.states, row).min() > -1e-9

    def test_goes_on_from_its_own_states(self, brick):
        state = ifa.State((0, 0, 0.1), velocity_m_s=(1, 0, 0), angular_velocity_rad_s=(3, 9, -5))
        run = ifa.simulate(brick, state)
        for row in range(0, len(run.times_s), 7):
            again = ifa.simulate(brick, run.states[row], until_s=0.001)
            assert again.times_s[0] == 0.0

    def test_until(self, ball):
        state = ifa.State((0, 0, 1.0))
        run = ifa.simulate(ball, state, until_s=0.25)
        assert run.status == "time_limit" and run.rest_s is None
        assert run.times_s[-1] == 0.25 and len(run.hits) == 0
        assert run.hits.impulse_n_s.shape == (0, 3)
        np.testing.assert_allclose(
            run.states.position_m[-1, 2], 1.0 - 0.5 * G * 0.25**2, atol=1e-15
        )

    def test_gravity_may_tilt(self):
        block = ifa.Body.box((0.1, 0.1, 0.02), mass_kg=0.1, friction=0.2)
        angle = np.arctan(0.4)  # twice what friction holds
        gravity = G * np.array([np.sin(angle), 0, -np.cos(angle)])
        run = ifa.simulate(block, ifa.State((0, 0, 0.01)), until_s=0.5, gravity_m_s2=gravity)
        expected = 0.5 * G * (np.sin(angle) - 0.2 * np.cos(angle)) * 0.5**2
        # the first step has slid by a g h^2 / 2 less or more
        assert run.states.position_m[-1, 0] == pytest.approx(expected, rel=0.003)
        assert abs(run.states.position_m[-1, 1]) < 1e-9

    def test_same_bytes_again(self, brick):
        state = ifa.State((0, 0, 0.1), velocity_m_s=(1, 0, 0), angular_velocity_rad_s=(3, 9, -5))
        a, b = ifa.simulate(brick, state), ifa.simulate(brick, state)
        assert a.times_s.tobytes() == b.times_s.tobytes()
        assert a.states.quaternion_wxyz.tobytes() == b.states.quaternion_wxyz.tobytes()

    @pytest.mark.parametrize(
        ("name", "call"),
        [
            ("engine", {"engine": "bullet"}),
            ("engine", {"engine": None}),
            ("step_s", {"step_s": 0.0}),
            ("step_s", {"step_s": "1 ms"}),
            ("until_s", {"until_s": -1.0}),
            ("until_s", {"until_s": np.nan}),
            ("until_s", {"until_s": np.inf}),
            ("gravity_m_s2", {"gravity_m_s2": (0, 0, 9.81)}),
            ("gravity_m_s2", {"gravity_m_s2": 0.0}),
            ("gravity_m_s2", {"gravity_m_s2": "down"}),
            ("position_m", {"state": ifa.State((0, 0, 0.0))}),
            ("state", {"state": None}),
        ],
    )
    def test_errors_name_the_argument(self, ball, name, call):
        with pytest.raises(ifa.IfaValueError, match=f"^{name}:"):
            ifa.simulate(ball, **({"state": ifa.State((0, 0, 1))} | call))

    def test_cancel(self):
        bouncy = ifa.Body.ball(RADIUS, mass_kg=0.03, restitution=1.0, friction=0.0)
        progress = ifa.Progress()
        progress.cancel()
        with pytest.raises(ifa.Cancelled):
            ifa.simulate(bouncy, ifa.State((0, 0, 1)), progress=progress)

    def test_other_threads_run_meanwhile(self):
        # e = 1 never rests: only the other thread can end it.
        bouncy = ifa.Body.ball(RADIUS, mass_kg=0.03, restitution=1.0, friction=0.0)
        progress = ifa.Progress()
        threading.Timer(0.01, progress.cancel).start()
        try:
            run = ifa.simulate(bouncy, ifa.State((0, 0, 0.1)), progress=progress)
        except ifa.Cancelled:
            return
        assert run.status == "impact_limit"  # a fast machine got there first


@pytest.mark.parametrize(
    ("field", "value"),
    [("velocity_m_s", (0, 0, 1e7)), ("angular_velocity_rad_s", (0, 1e160, 0))],
)
@pytest.mark.parametrize("engine", ["event", "ode"])
def test_too_fast_to_begin_with(field, value, engine):
    body = ifa.bodies.get("d6")
    fields = {"position_m": (0, 0, 1.0), "quaternion_wxyz": (1, 0, 0, 0)}
    fields |= {"velocity_m_s": (0, 0, 0), "angular_velocity_rad_s": (0, 0, 0), field: value}
    with pytest.raises(ifa.IfaValueError, match=f"^{field}: must not be faster than 1e"):
        ifa.simulate(body, ifa.State(**fields), engine=engine, until_s=0.1)
    rows = ifa.State(**{key: [x, x] for key, x in fields.items()})
    with pytest.raises(ifa.IfaValueError, match=f"^states: row 0: {field}: must not"):
        ifa.simulate_batch(body, rows)
