"""Arrays of images, and registration of two of them."""
import math
import sys
import threading
import time
import unittest

import cv2
import numpy as np

import ceilmap
import support


def textured(height=300, width=400):
    noise = np.random.default_rng(5).integers(0, 255, (height, width), dtype=np.uint8)
    return cv2.GaussianBlur(noise, (0, 0), 2)


class Registration(support.Case):
    def setUp(self):
        super().setUp()
        self.big = cv2.normalize(textured(), None, 0, 255, cv2.NORM_MINMAX)
        self.image = np.ascontiguousarray(self.big[20:260, 30:350])

    def test_recovers_a_shift_to_the_right_and_down(self):
        # What is at (x, y) of the reference is at (x + 7, y + 4) of the current image.
        current = self.big[16:256, 23:343]
        found = ceilmap.register(self.image, current)
        self.assertTrue(found and found.ok and found.verdict == "ok")
        self.assertAlmostEqual(found.tx, 7, delta=0.05)
        self.assertAlmostEqual(found.ty, 4, delta=0.05)
        self.assertAlmostEqual(found.theta, 0, delta=2e-4)
        self.assertAlmostEqual(found.scale, 1, delta=2e-4)
        self.assertGreater(found.peak, 0.5)
        self.assertGreater(found.overlap, 0.9)
        self.assertGreater(found.inliers, found.blocks // 2)
        np.testing.assert_allclose(found.matrix, [[1, 0, 7], [0, 1, 4]], atol=0.1)
        self.assertEqual(found.covariance.shape, (4, 4))

    def test_a_view_with_distant_rows_is_the_same_image(self):
        view = self.big[20:260, 30:350]
        self.assertFalse(view.flags["C_CONTIGUOUS"])
        current = np.ascontiguousarray(self.big[16:256, 23:343])
        of_view = ceilmap.register(view, current)
        of_copy = ceilmap.register(self.image, current)
        self.assertEqual((of_view.tx, of_view.theta), (of_copy.tx, of_copy.theta))

    def test_matrix_and_theta_turn_clockwise(self):
        angle = 0.1
        centre = (159.5, 119.5)
        turned = cv2.getRotationMatrix2D(centre, -math.degrees(angle), 1)  # OpenCV's is opposite
        current = cv2.warpAffine(self.image, turned, (320, 240), flags=cv2.INTER_CUBIC)
        found = ceilmap.register(self.image, current, fixed_scale=True)
        self.assertAlmostEqual(found.theta, angle, delta=1e-3)
        self.assertEqual(found.scale, 1)
        np.testing.assert_allclose(found.matrix, turned, atol=0.2)

    def test_nothing_is_guessed(self):
        grey = np.full((240, 320), 128, np.uint8)
        found = ceilmap.register(self.image, grey)
        self.assertFalse(found)
        self.assertEqual(found.verdict, "no texture")
        for name in ("tx", "ty", "theta", "scale", "covariance", "matrix"):
            self.assertIsNone(getattr(found, name), name)

    def test_arrays_that_are_no_images(self):
        ok = self.image
        for array, message in [
            (ok.astype(float), "reference: dtype is float64, must be uint8; convert it to 0..255 first"),
            (ok.astype(np.int8), "reference: dtype is int8, must be uint8; convert it to 0..255 first"),
            (
                cv2.cvtColor(ok, cv2.COLOR_GRAY2BGR),
                "reference: shape is (240, 320, 3), must be (height, width); convert colours to "
                "grey, e.g. by cv2.cvtColor",
            ),
            (
                ok.ravel(),
                "reference: shape is (76800), must be (height, width); convert colours to grey, "
                "e.g. by cv2.cvtColor",
            ),
            (ok[:0], "reference: shape is (0, 320), must not be empty"),
            (
                ok.T,
                "reference: the pixels of a row are not contiguous; pass "
                "numpy.ascontiguousarray(...)",
            ),
            (
                ok[::-1],
                "reference: the rows do not follow each other; pass numpy.ascontiguousarray(...)",
            ),
        ]:
            with self.subTest(message=message):
                self.assert_fails(ceilmap.InputError, message, ceilmap.register, array, ok)
        self.assert_fails(
            ceilmap.InputError, "reference and current: must have one shape",
            ceilmap.register, ok, ok[:200],
        )
        self.assert_fails(
            ceilmap.InputError, "mask: must have the shape of the images",
            ceilmap.register, ok, ok, mask=ok[:200],
        )
        with self.assertRaises(TypeError):
            ceilmap.register(ok.tolist(), ok)
        self.assert_fails(
            ceilmap.InputError, "images of 320x90 cannot be registered; each side must have 96 to 16384 pixels",
            ceilmap.register, ok[:90], ok[:90],
        )

    def test_other_threads_run_meanwhile(self):
        # Nothing but the call itself gives the lock of Python away.
        interval = sys.getswitchinterval()
        self.addCleanup(sys.setswitchinterval, interval)
        turns, done = [0], threading.Event()

        def count():
            while not done.is_set():
                turns[0] += 1
                time.sleep(0)

        thread = threading.Thread(target=count)
        thread.start()
        sys.setswitchinterval(1000)
        try:
            ran = False
            for _ in range(500):  # a busy machine may leave the thread out for long
                before = turns[0]
                ceilmap.register(self.image, self.image)
                ran = turns[0] > before
                if ran:
                    break
        finally:
            done.set()
            thread.join()
        self.assertTrue(ran)


if __name__ == "__main__":
    unittest.main()
