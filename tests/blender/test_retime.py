"""Contacts on whole frames: the two rules, against brute force and closed-form motions."""

import unittest

import numpy as np
from ifa_addon import keys, retime
from support import FRAME_RATES, POSITION_BOUND_M, ROTATION_BOUND_DEG, BouncingBall
from test_keys import PLAIN, evaluate_bezier, tracks

ROUNDING_S = 1e-6  # two of the rounding of 1e-6 frames that the rules allow, at 23.976 or more
RULES = ("FRAME", "PICTURE_FIRST")


def rates():
    return [numerator / denominator for numerator, denominator in FRAME_RATES]


class RulesTest(unittest.TestCase):
    def test_frame_is_the_nearest(self):
        for fps in rates():
            frames = np.linspace(-3.0, 40.0, 4001)
            got = retime.nearest_frame(frames, fps)
            whole = np.arange(-5, 45)
            nearest = np.abs(frames[:, None] - whole).min(axis=1)
            np.testing.assert_allclose(np.abs(got - frames), nearest, atol=1e-12)
            self.assertLessEqual(np.abs(got - frames).max(), 0.5)

    def test_picture_first_is_the_earliest_frame_that_is_not_too_early(self):
        """Among all frames, by brute force: shown - heard >= -15 ms, and as small as can be."""
        for fps in rates():
            frames = np.linspace(-3.0, 40.0, 4001) + 1e-4
            got = retime.picture_first_frame(frames, fps)
            whole = np.arange(-5, 45)
            allowed = (whole - frames[:, None]) / fps >= -0.015
            np.testing.assert_array_equal(got, whole[np.argmax(allowed, axis=1)])
            late_s = (got - frames) / fps
            self.assertGreaterEqual(late_s.min(), -0.015)
            self.assertLess(late_s.max(), 1.0 / fps - 0.015 + ROUNDING_S)

    def test_a_hit_on_a_whole_frame_stays_there(self):
        whole = np.arange(1000.0)
        for fps in rates():
            times_s = whole / fps  # and back, with the rounding of that
            for rule in retime.RULES.values():
                np.testing.assert_array_equal(rule(times_s * fps, fps), whole)

    def test_picture_first_with_frames_shorter_than_the_lead(self):
        """At 120 a second the last frame before the sound, not the one before that."""
        np.testing.assert_array_equal(
            retime.picture_first_frame(np.array([7.0, 7.01, 7.99]), 120.0), [7.0, 7.0, 7.0]
        )


class RetimedKeysTest(unittest.TestCase):
    def contacts(self, made):
        return [track.frames[track.is_contact] for track in tracks(made)]

    def test_all_keys_stand_on_whole_frames_and_contacts_where_the_rule_says(self):
        motion = BouncingBall(spin_rad_s=40.0)
        for fps in rates():
            for origin in (1.0, 7.3, 11.77):
                timing = keys.Timing(fps, origin)
                for rule, earliest_s, latest_s in (
                    ("FRAME", -0.5 / fps, 0.5 / fps),
                    ("PICTURE_FIRST", -0.015, 1.0 / fps - 0.015),
                ):
                    made = keys.make_keys(motion, timing, PLAIN, None, rule)
                    self.assertEqual(made.notes, ())
                    for track, at in zip(tracks(made), self.contacts(made), strict=True):
                        np.testing.assert_array_equal(track.frames, np.round(track.frames))
                        self.assertTrue((np.diff(track.frames) > 0).all())
                        self.assertEqual(len(at), len(motion.contact_times_s))
                        off_s = timing.time_s(at) - motion.contact_times_s
                        self.assertGreaterEqual(off_s.min(), earliest_s - ROUNDING_S)
                        self.assertLessEqual(off_s.max(), latest_s + ROUNDING_S)

    def test_on_frames_the_motion_is_retimed_evenly_between_contacts(self):
        """Each frame shows the closed form at a time interpolated between the contacts' times."""
        for fps in rates():
            timing = keys.Timing(fps, 1.3)
            for spin in (5.0, 40.0, 150.0):  # the last turns by 6 rad a frame at 24
                motion = BouncingBall(spin_rad_s=spin)
                for rule in RULES:
                    made = keys.make_keys(motion, timing, PLAIN, None, rule)
                    shown = self.contacts(made)[0]
                    whole = np.arange(shown[0], shown[-1] + 1)
                    true_s = np.interp(whole, shown, motion.contact_times_s)
                    got = evaluate_bezier(made, whole)
                    position, q = motion.sample(true_s)
                    distance = np.linalg.norm(got[:, :3] - position, axis=1).max()
                    self.assertLess(distance, keys.Tolerance().position_m)
                    angle = keys.rotation_between(got[:, 3:], q).max()
                    self.assertLess(angle, keys.Tolerance().rotation_rad)

    def test_between_frames_too_where_a_key_a_frame_is_enough(self):
        motion = BouncingBall(spin_rad_s=20.0)
        timing = keys.Timing(24.0, 1.3)
        made = keys.make_keys(motion, timing, PLAIN, None, "FRAME")
        shown = self.contacts(made)[0]
        frames = np.linspace(shown[0], shown[-1], 2001)
        position, q = motion.sample(np.interp(frames, shown, motion.contact_times_s))
        got = evaluate_bezier(made, frames)
        self.assertLess(np.linalg.norm(got[:, :3] - position, axis=1).max(), POSITION_BOUND_M)
        angle = keys.rotation_between(got[:, 3:], q).max()
        self.assertLess(np.degrees(angle), ROTATION_BOUND_DEG)

    def test_velocities_are_those_of_the_retimed_poses(self):
        """By central differences of the poses' positions, away from contacts."""
        motion = BouncingBall(spin_rad_s=20.0)
        retimed = retime.on_frames(motion, keys.Timing(24.0, 1.3), "FRAME")
        times = np.linspace(retimed.start_s, retimed.end_s, 301)[1:-1]
        step = 1e-5
        away = np.abs(times[:, None] - retimed.contact_times_s).min(axis=1) > 2 * step
        times = times[away]
        difference = retimed.sample(times + step)[0] - retimed.sample(times - step)[0]
        velocity, _ = retimed.sample_velocity(times)
        # second order in the step, of a motion without a third derivative: rounding is left
        np.testing.assert_allclose(difference / (2 * step), velocity, atol=1e-8)

    def test_contacts_on_one_frame_share_it_in_order(self):
        """0.7 ** 12 leaves the late bounces less than a frame apart at 24 a second."""
        motion = BouncingBall(spin_rad_s=20.0, bounces=12)
        timing = keys.Timing(24.0, 1.0)
        for name, rule in retime.RULES.items():
            made = keys.make_keys(motion, timing, PLAIN, None, name)
            frames = rule(timing.frame(motion.contact_times_s), timing.fps)
            own, first = np.unique(frames, return_index=True)
            sharing = len(frames) - len(own)
            self.assertGreater(sharing, 1)
            self.assertEqual(
                made.notes,
                (f"{sharing} contacts share the frame of the one before and have no key there.",),
            )
            for at in self.contacts(made):
                np.testing.assert_array_equal(at, own)
            retimed = retime.on_frames(motion, timing, name)
            shown = np.interp(
                motion.contact_times_s,
                retimed.true_s(retimed.contact_times_s),
                retimed.contact_times_s,
            )
            self.assertTrue((np.diff(shown) >= 0).all())
            np.testing.assert_allclose(
                motion.contact_times_s[first], retimed.true_s(retimed.contact_times_s), atol=1e-12
            )

    def test_a_motion_within_one_frame_still_has_two_keys(self):
        motion = BouncingBall(bounces=0, start_s=0.401, fall_s=0.01)
        made = keys.make_keys(motion, keys.Timing(24.0, 1.0), PLAIN, None, "FRAME")
        for track in tracks(made):
            self.assertEqual(len(track.frames), 2)
            self.assertTrue((np.diff(track.frames) >= 1).all())
