"""The arrays of keys, from closed-form motions; no scene is involved."""

import unittest

import numpy as np
from ifa_addon import keys
from support import FRAME_RATES, POSITION_BOUND_M, ROTATION_BOUND_DEG, BouncingBall, worst_against


def evaluate_bezier(made, frames):
    """(n, 7) by solving each cubic Bezier segment in frame and value: what Blender should do."""
    out = np.empty((len(frames), 7))
    segment = np.clip(np.searchsorted(made.frames, frames, "right") - 1, 0, len(made.frames) - 2)
    for row, (frame, i) in enumerate(zip(frames, segment, strict=True)):
        x0, x3 = float(made.frames[i]), float(made.frames[i + 1])
        for channel in range(7):
            (x1, y1), (x2, y2) = made.right[i, channel], made.left[i + 1, channel]
            low, high = 0.0, 1.0
            for _ in range(60):
                u = (low + high) / 2
                x = (1 - u) ** 3 * x0 + 3 * u * (1 - u) ** 2 * x1
                x += 3 * u**2 * (1 - u) * x2 + u**3 * x3
                low, high = (u, high) if x < frame else (low, u)
            y0, y3 = made.values[i, channel], made.values[i + 1, channel]
            y = (1 - u) ** 3 * y0 + 3 * u * (1 - u) ** 2 * y1 + 3 * u**2 * (1 - u) * y2 + u**3 * y3
            out[row, channel] = y
    return out


PLAIN = keys.Placement(np.zeros(3))
# A mass centre 12 mm from the origin, inside a turned, scaled and moved parent, in millimetres.
HARD = keys.Placement(
    centre_of_mass_m=np.array([0.012, -0.004, 0.006]),
    metres_per_unit=1e-3,
    shift_m=np.array([0.2, 0.1, 0.0]),
    unparent=np.array([[0, 2.0, 0, 5], [-2.0, 0, 0, 1], [0, 0, 2.0, -3], [0, 0, 0, 1]]),
    unturn_wxyz=np.array([np.sqrt(0.5), 0.0, 0.0, -np.sqrt(0.5)]),
    delta_location=np.array([1.0, 2.0, 3.0]),
)


class KeysTest(unittest.TestCase):
    def test_contacts_have_their_own_fractional_keys(self):
        motion = BouncingBall()
        for numerator, denominator in FRAME_RATES:
            timing = keys.Timing(numerator / denominator, 101.3)
            made = keys.make_keys(motion, timing, PLAIN)
            at_contacts = timing.time_s(made.frames[made.is_contact])
            self.assertEqual(len(at_contacts), len(motion.contact_times_s))
            # float32 frame numbers near 130 are 1.5e-5 frames apart
            np.testing.assert_allclose(at_contacts, motion.contact_times_s, atol=1e-5)

    def test_frames_increase_and_cover_every_frame(self):
        motion = BouncingBall()
        timing = keys.Timing(24.0, 1.0)
        made = keys.make_keys(motion, timing, PLAIN)
        self.assertTrue((np.diff(made.frames) > 0).all())
        first, last = timing.frame(motion.start_s), timing.frame(motion.end_s)
        for frame in range(int(np.ceil(first)), int(np.floor(last)) + 1):
            nearest = np.abs(made.frames - frame).min()
            self.assertLess(nearest, keys.NEAR_CONTACT_FRAMES + 1e-6, f"frame {frame}")

    def test_a_frame_key_gives_way_to_a_contact_beside_it(self):
        motion = BouncingBall()
        # Put the first contact 0.001 frames after frame 10.
        fps = 24.0
        origin = 10.001 - motion.contact_times_s[0] * fps
        made = keys.make_keys(motion, keys.Timing(fps, origin), PLAIN)
        beside = np.abs(made.frames - 10.0) < 0.5 * keys.NEAR_CONTACT_FRAMES
        self.assertEqual(beside.sum(), 1)
        self.assertTrue(made.is_contact[beside].all())

    def test_a_parabola_is_exact(self):
        motion = BouncingBall(spin_rad_s=0.0)
        timing = keys.Timing(24.0, 1.0)
        made = keys.make_keys(motion, timing, PLAIN)
        times = np.linspace(motion.start_s, motion.end_s, 997)
        poses = evaluate_bezier(made, timing.frame(times))
        # Only float32 frame numbers (2e-6 frames, so 1e-7 s at up to 3.5 m/s) may show.
        self.assertLess(worst_against(motion, PLAIN, times, poses)[0], 2e-6)

    def test_between_keys_the_motion_is_within_bounds(self):
        for numerator, denominator in FRAME_RATES:
            timing = keys.Timing(numerator / denominator, 1.0)
            for spin in (5.0, 40.0, 150.0):
                motion = BouncingBall(spin_rad_s=spin)
                for place in (PLAIN, HARD):
                    made = keys.make_keys(motion, timing, place)
                    times = np.linspace(motion.start_s, motion.end_s, 401)
                    poses = evaluate_bezier(made, timing.frame(times))
                    distance, angle = worst_against(motion, place, times, poses)
                    units_per_m = 2.0 / 1e-3 if place is HARD else 1.0
                    self.assertLess(distance / units_per_m, POSITION_BOUND_M)
                    self.assertLess(angle, ROTATION_BOUND_DEG)

    def test_no_key_turns_too_far(self):
        motion = BouncingBall(spin_rad_s=150.0)  # 6.25 rad per frame at 24: aliases without more
        made = keys.make_keys(motion, keys.Timing(24.0, 1.0), PLAIN)
        turn = keys.rotation_between(made.values[1:, 3:], made.values[:-1, 3:])
        # at most TURN_PER_KEY_RAD, give or take the rounding of float32 frames
        self.assertLess(turn.max(), keys.TURN_PER_KEY_RAD * 1.001)

    def test_quaternions_keep_their_sign(self):
        motion = BouncingBall(spin_rad_s=60.0)
        made = keys.make_keys(motion, keys.Timing(24.0, 1.0), HARD)
        q = made.values[:, 3:]
        self.assertGreaterEqual((q[1:] * q[:-1]).sum(axis=1).min(), 0.0)
        self.assertLess((q[:, 0]).min(), 0.0)  # so continuity was not had by forcing w >= 0

    def test_late_frames_stay_distinct_and_close(self):
        """Near frame 24,000 float32 frame numbers are 81 us apart at 24 frames a second."""
        motion = BouncingBall(spin_rad_s=60.0)
        timing = keys.Timing(24.0, 24000.0)
        made = keys.make_keys(motion, timing, PLAIN)
        self.assertTrue((np.diff(made.frames) > 0).all())
        late = np.abs(timing.time_s(made.frames[made.is_contact]) - motion.contact_times_s)
        self.assertLess(late.max(), 1e-3)
        times = np.linspace(motion.start_s, motion.end_s, 401)
        poses = evaluate_bezier(made, timing.frame(times))
        self.assertLess(worst_against(motion, PLAIN, times, poses)[0], POSITION_BOUND_M)

    def test_handles_break_at_a_contact_only(self):
        motion = BouncingBall(spin_rad_s=0.0)
        made = keys.make_keys(motion, keys.Timing(24.0, 1.0), PLAIN)

        def slope(handle):
            run = handle[:, 2, 0] - made.frames
            return (handle[:, 2, 1] - made.values[:, 2]) / run

        kink = np.abs(slope(made.right) - slope(made.left))[1:-1] * 24.0  # m/s
        inside = made.is_contact[1:-1]
        # The softest bounce leaves with 0.7^5 of 3.4 m/s and met it at 0.7^4.
        self.assertGreater(kink[inside].min(), 3.43 * (0.7**4 + 0.7**5) * 0.99)
        self.assertLess(kink[~inside].max(), 1e-3)  # float32 handles

    def test_a_motion_with_nan_is_refused(self):
        motion = BouncingBall()
        motion.position[3] = np.nan
        with self.assertRaisesRegex(ValueError, "not finite"):
            keys.make_keys(motion, keys.Timing(24.0, 1.0), PLAIN)
