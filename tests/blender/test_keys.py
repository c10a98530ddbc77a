"""The arrays of keys, from closed-form motions; no scene is involved."""

import unittest

import numpy as np
from ifa_addon import keys
from support import FRAME_RATES, POSITION_BOUND_M, ROTATION_BOUND_DEG, BouncingBall, worst_against


def evaluate_track(track, frames):
    """(n, c) by solving each cubic Bezier segment in frame and value: what Blender should do."""
    frames = np.asarray(frames, dtype=float)
    i = np.clip(np.searchsorted(track.frames, frames, "right") - 1, 0, len(track.frames) - 2)
    x = track.frames.astype(float)
    x0, x1, x2, x3 = x[i], track.right[i, 0, 0], track.left[i + 1, 0, 0], x[i + 1]
    low, high = np.zeros(len(frames)), np.ones(len(frames))
    for _ in range(60):
        u = (low + high) / 2
        at = (1 - u) ** 3 * x0 + 3 * u * (1 - u) ** 2 * x1 + 3 * u**2 * (1 - u) * x2 + u**3 * x3
        low, high = np.where(at < frames, u, low), np.where(at < frames, high, u)
    u = u[:, None]
    y0, y1 = track.values[i], track.right[i, :, 1]
    y2, y3 = track.left[i + 1, :, 1], track.values[i + 1]
    return (1 - u) ** 3 * y0 + 3 * u * (1 - u) ** 2 * y1 + 3 * u**2 * (1 - u) * y2 + u**3 * y3


def evaluate_bezier(made, frames):
    """(n, 7) of both tracks."""
    return np.hstack([evaluate_track(made.location, frames), evaluate_track(made.rotation, frames)])


def tracks(made):
    return made.location, made.rotation


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


def hermite_turn_error(turn):
    """Angle in rad by which a cubic Hermite segment of a steady turn by `turn` errs at worst."""
    u = np.linspace(0.0, 1.0, 1001)
    begin, end = -turn / 4, turn / 4  # half angles
    blend = [(1 + 2 * u) * (1 - u) ** 2, u * (1 - u) ** 2, u**2 * (3 - 2 * u), -(u**2) * (1 - u)]
    slope = turn / 2
    x = blend[0] * np.cos(begin) - blend[1] * slope * np.sin(begin)
    x += blend[2] * np.cos(end) - blend[3] * slope * np.sin(end)
    y = blend[0] * np.sin(begin) + blend[1] * slope * np.cos(begin)
    y += blend[2] * np.sin(end) + blend[3] * slope * np.cos(end)
    return 2 * np.abs(np.arctan2(y, x) - (begin + u * (end - begin))).max()


class KeysTest(unittest.TestCase):
    def test_contacts_have_their_own_fractional_keys(self):
        motion = BouncingBall()
        for numerator, denominator in FRAME_RATES:
            timing = keys.Timing(numerator / denominator, 101.3)
            for track in tracks(keys.make_keys(motion, timing, PLAIN)):
                at_contacts = timing.time_s(track.frames[track.is_contact])
                self.assertEqual(len(at_contacts), len(motion.contact_times_s))
                # float32 frame numbers near 130 are 1.5e-5 frames apart
                np.testing.assert_allclose(at_contacts, motion.contact_times_s, atol=1e-5)
                self.assertTrue((np.diff(track.frames) > 0).all())

    def test_a_flight_is_one_segment(self):
        """Of the mass centre's place, whatever the spin; of a constant rotation too if slow."""
        motion = BouncingBall(spin_rad_s=3.0)
        ends = np.unique([motion.start_s, *motion.contact_times_s, motion.end_s])
        made = keys.make_keys(motion, keys.Timing(24.0, 1.0), PLAIN)
        self.assertEqual(len(made.location.frames), len(ends))
        # 0.5 s at 3 rad/s at most: the Hermite error of a turn by 1.5 rad is 0.002 degrees
        self.assertEqual(len(made.rotation.frames), len(ends))

    def test_an_origin_off_the_mass_centre_takes_more_keys(self):
        motion = BouncingBall(spin_rad_s=40.0)
        timing = keys.Timing(24.0, 1.0)
        centred = keys.make_keys(motion, timing, PLAIN).location
        offset = keys.make_keys(motion, timing, keys.Placement(np.array([0.003, 0, 0]))).location
        self.assertGreater(len(offset.frames), 2 * len(centred.frames))

    def test_rotation_keys_are_as_few_as_the_bound_allows(self):
        """In a flight of constant spin 0.6 of them would leave the bound."""
        motion = BouncingBall(spin_rad_s=60.0)
        for allowed_deg in (0.005, 0.02, 0.3):
            allowed = np.radians(allowed_deg)
            tolerance = keys.Tolerance(rotation_rad=allowed)
            track = keys.make_keys(motion, keys.Timing(24.0, 1.0), PLAIN, tolerance).rotation
            begin, end = motion.start_s, motion.contact_times_s[0]
            count = (
                (track.frames > keys.Timing(24.0, 1.0).frame(begin) - 1e-3)
                & (track.frames < keys.Timing(24.0, 1.0).frame(end) - 1e-3)
            ).sum()
            self.assertLessEqual(hermite_turn_error(60.0 * (end - begin) / count), allowed)
            # 0.6: of the numbers of parts that are tried, neighbours are closer than that
            self.assertGreater(hermite_turn_error(60.0 * (end - begin) / (0.6 * count)), allowed)

    def test_a_parabola_is_exact(self):
        motion = BouncingBall(spin_rad_s=0.0)
        timing = keys.Timing(24.0, 1.0)
        made = keys.make_keys(motion, timing, PLAIN)
        times = np.linspace(motion.start_s, motion.end_s, 997)
        poses = evaluate_bezier(made, timing.frame(times))
        # Only float32 frame numbers (2e-6 frames, so 1e-7 s at up to 3.5 m/s) may show.
        self.assertLess(worst_against(motion, PLAIN, times, poses)[0], 2e-6)

    def test_between_keys_the_motion_is_within_the_stated_bound(self):
        """Compared 64 times a key, on average, with the closed form."""
        for numerator, denominator in FRAME_RATES:
            timing = keys.Timing(numerator / denominator, 1.0)
            for spin in (5.0, 40.0, 150.0):
                motion = BouncingBall(spin_rad_s=spin)
                for place in (PLAIN, HARD):
                    for tolerance in (keys.Tolerance(), keys.Tolerance(1e-3, np.radians(0.5))):
                        made = keys.make_keys(motion, timing, place, tolerance)
                        count = 64 * max(len(track.frames) for track in tracks(made))
                        times = np.linspace(motion.start_s, motion.end_s, count)
                        poses = evaluate_bezier(made, timing.frame(times))
                        distance, angle = worst_against(motion, place, times, poses)
                        units_per_m = 2.0 / 1e-3 if place is HARD else 1.0
                        # float32 frames are off by 4e-6 at up to 4 m/s and 150 rad/s
                        slack_s = 4e-6 / timing.fps
                        self.assertLess(
                            distance / units_per_m, tolerance.position_m + 6.0 * slack_s
                        )
                        self.assertLess(angle, np.degrees(tolerance.rotation_rad + spin * slack_s))

    def test_the_default_bound_leaves_room_in_the_demanded_one(self):
        self.assertLess(keys.Tolerance().position_m, POSITION_BOUND_M)
        self.assertLess(np.degrees(keys.Tolerance().rotation_rad), ROTATION_BOUND_DEG)

    def test_quaternions_keep_their_sign(self):
        motion = BouncingBall(spin_rad_s=60.0)
        for key_times in ("SUBFRAME", "FRAME", "PICTURE_FIRST"):
            made = keys.make_keys(motion, keys.Timing(24.0, 1.0), HARD, None, key_times)
            q = made.rotation.values
            self.assertGreaterEqual((q[1:] * q[:-1]).sum(axis=1).min(), 0.0)
            self.assertLess((q[:, 0]).min(), 0.0)  # so continuity was not had by forcing w >= 0

    def test_late_frames_stay_distinct_and_close(self):
        """Near frame 24,000 float32 frame numbers are 81 us apart at 24 frames a second."""
        motion = BouncingBall(spin_rad_s=60.0)
        timing = keys.Timing(24.0, 24000.0)
        made = keys.make_keys(motion, timing, PLAIN)
        for track in tracks(made):
            self.assertTrue((np.diff(track.frames) > 0).all())
            late = np.abs(timing.time_s(track.frames[track.is_contact]) - motion.contact_times_s)
            self.assertLess(late.max(), 1e-3)
        times = np.linspace(motion.start_s, motion.end_s, 401)
        poses = evaluate_bezier(made, timing.frame(times))
        self.assertLess(worst_against(motion, PLAIN, times, poses)[0], POSITION_BOUND_M)

    def test_handles_break_at_a_contact_only(self):
        motion = BouncingBall(spin_rad_s=40.0)
        # 3 mm from the mass centre, so that there are keys between contacts too
        place = keys.Placement(np.array([0.003, 0.0, 0.0]))
        made = keys.make_keys(motion, keys.Timing(24.0, 1.0), place).location

        def slope(handle):
            run = handle[:, 2, 0] - made.frames
            return (handle[:, 2, 1] - made.values[:, 2]) / run

        kink = np.abs(slope(made.right) - slope(made.left))[1:-1] * 24.0  # m/s
        inside = made.is_contact[1:-1]
        self.assertGreater((~inside).sum(), 3)
        # The softest bounce leaves with 0.7^5 of 3.4 m/s and met it at 0.7^4; the origin swings by
        # 40 rad/s * 3 mm at most, before and after.
        self.assertGreater(kink[inside].min(), 3.43 * (0.7**4 + 0.7**5) * 0.99 - 0.24)
        self.assertLess(kink[~inside].max(), 1e-3)  # float32 handles

    def test_a_motion_with_nan_is_refused(self):
        motion = BouncingBall()
        motion.position[3] = np.nan
        with self.assertRaisesRegex(ValueError, "not finite"):
            keys.make_keys(motion, keys.Timing(24.0, 1.0), PLAIN)
