"""Errors of trajectories that are known by hand."""
import unittest

import numpy as np

import ceilmap
import support


class Evaluation(support.Case):
    def setUp(self):
        super().setUp()
        stamps = np.arange(5.0)
        self.truth = np.stack([stamps, stamps, 0 * stamps, 0 * stamps], axis=1)

    def test_a_constant_offset(self):
        estimate = self.truth + [0, 0, 0.3, 0]
        errors = ceilmap.evaluate(self.truth, estimate, align="none")
        self.assertEqual((errors["matched"], errors["expected"], errors["coverage"]), (5, 5, 1.0))
        self.assertAlmostEqual(errors["position_m"]["rmse"], 0.3)
        self.assertAlmostEqual(errors["position_m"]["max"], 0.3)
        self.assertAlmostEqual(errors["path_m"], 4)
        np.testing.assert_allclose(errors["frames"]["across_m"], 0.3)
        np.testing.assert_array_equal(errors["frames"]["truth"], range(5))
        self.assertAlmostEqual(ceilmap.evaluate(self.truth, estimate)["position_m"]["max"], 0)

    def test_poses_in_space_and_in_the_plane_are_the_same(self):
        yaw = 0.4
        planar = self.truth + [0, 0, 0, yaw]
        space = np.zeros((5, 8))
        space[:, :3] = planar[:, :3]
        space[:, 6:] = np.sin(yaw / 2), np.cos(yaw / 2)
        a = ceilmap.evaluate(self.truth, planar, align="none")
        b = ceilmap.evaluate(self.truth, space, align="none")
        self.assertAlmostEqual(a["yaw_deg"]["mean"], np.degrees(yaw))
        self.assertAlmostEqual(a["ape"]["rotation_deg"]["max"], b["ape"]["rotation_deg"]["max"])

    def test_coverage_of_what_was_expected(self):
        errors = ceilmap.evaluate(self.truth, self.truth[:2], align="none", expected=8)
        self.assertEqual((errors["matched"], errors["coverage"]), (2, 0.25))

    def test_faults(self):
        truth = self.truth
        broken = truth.copy()
        broken[3, 1] = np.nan
        space = np.zeros((1, 8))
        for message, arguments, keywords in [
            ("estimate: shape is (5, 3), must be (N, 8): stamp, x, y, z, qx, qy, qz, qw, or (N, 4): "
             "stamp, x, y, yaw; N >= 1", (truth, truth[:, :3]), {}),
            ("truth: shape is (0, 4), must be (N, 8): stamp, x, y, z, qx, qy, qz, qw, or (N, 4): "
             "stamp, x, y, yaw; N >= 1", (truth[:0], truth), {}),
            ("truth: row 3 has a number that is not finite", (broken, truth), {}),
            ("truth: row 1: the stamp is not later than the one before", (truth[::-1], truth), {}),
            ("estimate: row 0: the quaternion's length is 0, must be 1", (truth, space), {}),
            ("align 'se3': must be 'none', 'first', 'se2' or 'sim2'", (truth, truth),
             {"align": "se3"}),
            ("max_dt -1: must be >= 0 s", (truth, truth), {"max_dt": -1}),
            ("no pose of the estimate is within 0.02 s of a true one; are the stamps of one clock?",
             (truth, truth + [0.5, 0, 0, 0]), {}),
            ("expected 3: 5 poses of the estimate have a true one", (truth, truth),
             {"expected": 3}),
        ]:
            with self.subTest(message=message):
                self.assert_fails(
                    ceilmap.InputError, message, ceilmap.evaluate, *arguments, **keywords
                )


if __name__ == "__main__":
    unittest.main()
