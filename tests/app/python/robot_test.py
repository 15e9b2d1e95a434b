"""The mapper and the localizer, with all sensors."""
import math
import threading
import unittest

import cv2
import numpy as np

import ceilmap
import support

SIMPLE_RIG = """
h: 2.6
cameras:
  up:
    type: pinhole
    image_width: 640
    image_height: 480
    camera_matrix: {rows: 3, cols: 3, data: [457, 0, 319.5, 0, 457, 239.5, 0, 0, 1]}
    base_link_to_camera: {translation: [0, 0, 0.4]}
"""


class Mapping(support.Case):
    def setUp(self):
        super().setUp()
        self.rig = ceilmap.Rig.load(support.UP_RIG)
        self.map = self.folder / "lab.gpkg"

    def test_estimates(self):
        mapper = ceilmap.CeilingMapper(self.rig, self.map, origin=(1, 0, math.pi / 2))
        for image, stamp in support.frames("lab-map", count=30):
            estimate = mapper.add_ceiling(image, stamp)
        self.assertTrue(estimate)
        self.assertEqual((estimate.status, estimate.index), ("tracking", 29))
        self.assertAlmostEqual(estimate.stamp, 102.9)
        self.assertIsInstance(estimate.pose, tuple)
        x, y, yaw = estimate.pose
        self.assertAlmostEqual(x, 1, delta=0.01)
        self.assertGreater(y, 2)
        self.assertAlmostEqual(yaw, math.pi / 2, delta=0.01)
        np.testing.assert_allclose(
            estimate.matrix @ [0.5, 0, 0, 1],
            [x + 0.5 * math.cos(yaw), y + 0.5 * math.sin(yaw), 0, 1],
        )
        np.testing.assert_allclose(estimate.tum[:4], [estimate.stamp, x, y, 0])
        self.assertEqual(estimate.tilt, (0, 0))
        self.assertIsNone(estimate.heading)
        self.assertGreater(np.linalg.eigvalsh(estimate.covariance).min(), 0)
        self.assertEqual(mapper.placed_frames, 30)
        self.assertRegex(repr(estimate), r"^<ceilmap.Estimate 102.900 s, tracking \(.*\)>$")
        mapper.discard()

    def test_the_array_of_an_image_may_be_used_again(self):
        images = support.frames("lab-map", count=12)
        mapper = ceilmap.CeilingMapper(self.rig, self.map)
        buffer = np.empty_like(images[0][0])
        for image, stamp in images:
            buffer[:] = image
            mapper.add_ceiling_pipelined(buffer, stamp)
            buffer[:] = 0
        self.assertTrue(mapper.flush())
        self.assertIsNone(mapper.flush())
        self.assertEqual(mapper.finish().report["tracked"], 12)

    def test_two_threads_map_at_once(self):
        def map_in_thread(name):
            support.map_frames(self.folder / name, count=40)

        map_in_thread("alone.gpkg")
        threads = [threading.Thread(target=map_in_thread, args=(n,)) for n in ("a.gpkg", "b.gpkg")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        alone = ceilmap.Map(self.folder / "alone.gpkg")
        for name in ("a.gpkg", "b.gpkg"):
            beside = ceilmap.Map(self.folder / name)
            self.assertEqual(beside.trajectory.tobytes(), alone.trajectory.tobytes())
            np.testing.assert_array_equal(beside.mosaic().image, alone.mosaic().image)

    def test_two_threads_share_a_mapper(self):
        mapper = ceilmap.CeilingMapper(self.rig, self.map)
        images = support.frames("lab-map", count=30)
        begun, ended = threading.Event(), threading.Event()
        added = []

        def drive_wheels():
            begun.wait()
            while not ended.is_set():
                mapper.add_odometry((0, 0, 0), 200.0 + len(added))
                added.append(0)

        thread = threading.Thread(target=drive_wheels)
        thread.start()
        for image, stamp in images:
            mapper.add_ceiling(image, stamp)
            begun.set()
        ended.set()
        thread.join()
        self.assertEqual(mapper.sensed()["wheels"]["samples"], len(added))
        self.assertEqual(mapper.finish().report["tracked"], 30)

    def test_progress(self):
        mapper = ceilmap.CeilingMapper(self.rig, self.map)
        for image, stamp in support.frames("lab-map", count=20):
            mapper.add_ceiling(image, stamp)
        calls = []

        def show(done, total):
            calls.append((done, total))
            self.assert_fails(
                ceilmap.RunError,
                "a progress function must not call the object whose progress it shows",
                mapper.sensed,
            )

        result = mapper.finish(show)
        total = calls[0][1]
        self.assertEqual(calls, [(i + 1, total) for i in range(total)])
        self.assertEqual(result.report["frames"], 20)
        self.assertEqual(result.report["quality"]["loops"]["outliers"], 0)
        message = "the map is finished; make a new CeilingMapper"
        self.assert_fails(ceilmap.RunError, message, mapper.add_ceiling, image, stamp + 1)
        self.assert_fails(ceilmap.RunError, message, mapper.finish)

    def test_what_progress_raises_ends_the_work(self):
        self.map.write_text("as before")
        mapper = ceilmap.CeilingMapper(self.rig, self.map)
        for image, stamp in support.frames("lab-map", count=10):
            mapper.add_ceiling(image, stamp)

        def stop(done, total):
            raise KeyError("stopped")

        self.assert_fails(KeyError, "'stopped'", mapper.finish, stop)
        self.assertEqual(self.map.read_text(), "as before")
        self.assertEqual([file.name for file in self.folder.iterdir()], ["lab.gpkg"])

    def test_discard(self):
        mapper = ceilmap.CeilingMapper(self.rig, self.map)
        mapper.add_ceiling(*support.frames("lab-map", count=10)[0])
        mapper.discard()
        self.assertEqual(list(self.folder.iterdir()), [])
        self.assert_fails(
            ceilmap.RunError, "the map was discarded; make a new CeilingMapper", mapper.finish
        )

    def test_append(self):
        support.map_frames(self.map, count=40)
        mapper = ceilmap.CeilingMapper(self.rig, self.map, append=True)
        for image, stamp in support.frames("lab-map", count=90)[30:]:
            mapper.add_ceiling(image, stamp + 1000)
        mapper.finish()
        self.assertEqual(len(ceilmap.Map(self.map).trajectory), 100)

    def test_without_a_rig_in_pixels(self):
        mapper = ceilmap.CeilingMapper(None, self.map, size=(640, 480))
        for image, stamp in support.frames("lab-map", count=10):
            mapper.add_ceiling(image, stamp)
        mapper.finish()
        self.assertEqual(ceilmap.Map(self.map).metadata["unit"], "px")
        self.assert_fails(
            ceilmap.InputError, f"{self.map}: was made without a rig; give a Rig",
            ceilmap.CeilingLocalizer, self.map,
        )

    def test_settings_change_the_map(self):
        keyframes = []
        yaml = self.folder / "settings.yaml"
        yaml.write_text("mapping: {odometry: {min_overlap: 0.9}}\n")
        for settings in (None, {"mapping": {"odometry": {"min_overlap": 0.9}}}, yaml):
            keyframes.append(support.map_frames(self.map, settings=settings).report["keyframes"])
        self.assertGreater(keyframes[1], keyframes[0])
        self.assertEqual(keyframes[1], keyframes[2])
        support.map_frames(self.map, count=3, settings=ceilmap.default_settings())
        self.assertEqual(ceilmap.default_settings()["mapping"]["odometry"]["min_overlap"], 0.7)


class Faults(support.Case):
    def setUp(self):
        super().setUp()
        self.rig = ceilmap.Rig.load(support.UP_RIG)
        self.map = self.folder / "lab.gpkg"

    def test_run_error(self):
        mapper = ceilmap.CeilingMapper(self.rig, self.map)
        for i in range(3):
            mapper.add_ceiling(np.full((480, 640), 90, np.uint8), float(i))
        self.assert_fails(
            ceilmap.RunError,
            "no frame shows any texture that could be mapped: the ceiling is black, uniform or "
            "out of focus; check lens cap, light and exposure",
            mapper.finish,
        )
        self.assertTrue(issubclass(ceilmap.RunError, RuntimeError))

    def test_constructor(self):
        def make(*arguments, **keywords):
            return ceilmap.CeilingMapper(*arguments, **keywords)

        rig, path = self.rig, self.map
        for message, arguments, keywords in [
            ("rig is None: give size=(width, height) of the images", (None, path), {}),
            ("tilt 'x': must be 'none', 'matsumoto', 'forward', 'ceiling' or 'fused'", (rig, path),
             {"tilt": "x"}),
            ("tilt 'fused': tilt can only be measured with the robot's geometry; give a Rig",
             (None, path), {"tilt": "fused", "size": (640, 480)}),
            ("heading_model: needs the forward camera; give a Rig", (None, path),
             {"heading_model": "lab.colours", "size": (640, 480)}),
            ("resolution -1: must be > 0, map units per pixel of the map", (rig, path),
             {"resolution": -1}),
            ("origin: (0, nan, 0) is not finite; give (x, y, yaw) in metres and radians",
             (rig, path), {"origin": (0, math.nan, 0)}),
            ("settings:1: unknown key 'mapping.odometry.min_overlop'; did you mean "
             "'mapping.odometry.min_overlap'?", (rig, path),
             {"settings": {"mapping": {"odometry": {"min_overlop": 1}}}}),
        ]:
            with self.subTest(message=message):
                self.assert_fails(ceilmap.InputError, message, make, *arguments, **keywords)
        with self.assertRaises(TypeError):
            make(rig, path, settings={"mapping": {1, 2}})

    def test_images(self):
        mapper = ceilmap.CeilingMapper(self.rig, self.map)
        image = support.frames("lab-map", count=10)[0][0]
        mapper.add_ceiling(image, 1.0)
        for message, arguments in [
            ("image: dtype is float32, must be uint8; convert it to 0..255 first",
             (image.astype(np.float32), 2.0)),
            ("image: shape is (480, 640, 3), must be (height, width); convert colours to grey, "
             "e.g. by cv2.cvtColor", (cv2.cvtColor(image, cv2.COLOR_GRAY2BGR), 2.0)),
        ]:
            self.assert_fails(ceilmap.InputError, message, mapper.add_ceiling, *arguments)
        self.assert_fails(
            ceilmap.InputError,
            "image of 320 x 240 pixels, must be 640 x 480 and 8-bit grey; use the rig of the "
            "camera that took it",
            mapper.add_ceiling, image[:240, :320], 2.0,
        )
        self.assert_fails(
            ceilmap.InputError,
            "a frame's time, 1 s, is not later than that of the frame before",
            mapper.add_ceiling, image, 1.0,
        )

    def test_sensors(self):
        mapper = ceilmap.CeilingMapper(self.rig, self.map)
        image = support.frames("lab-map", count=10)[0][0]
        with self.assertRaisesRegex(ceilmap.InputError, "omni"):
            mapper.add_omni(image, 1.0)
        self.assert_fails(
            ceilmap.InputError, "frame 'world': must be 'map' or 'relative'",
            mapper.add_heading, 0.1, 0.1, 1.0, "world",
        )
        mapper.add_heading(0.1, 0.1, 1.0)
        self.assert_fails(
            ceilmap.InputError, "a heading sample counts from another direction than those before",
            mapper.add_heading, 0.1, 0.1, 2.0, frame="map",
        )
        mapper.add_odometry((0, 0, 0), 1.0)
        with self.assertRaisesRegex(ceilmap.InputError, "speeds"):
            mapper.add_speed(0.5, 0.1, 2.0)
        with self.assertRaises(TypeError):
            mapper.add_odometry((0, 0), 2.0)


class Localization(support.Case):
    @classmethod
    def setUpClass(cls):
        folder = support.tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.map = support.pathlib.Path(folder.name) / "lab.gpkg"
        support.map_frames(cls.map, count=60)
        cls.images = support.frames("lab-map", count=60)

    def test_heading_and_wheels_in_the_dark(self):
        localizer = ceilmap.CeilingLocalizer(self.map, start=(0, 0, 0))
        dark = np.zeros((480, 640), np.uint8)
        truth = ceilmap.Map(self.map).poses
        for i, (image, stamp) in enumerate(self.images[:20]):
            localizer.add_odometry(truth[i, 1:3].tolist() + [0], stamp)
            localizer.add_heading(0.25, 0.02, stamp)
            estimate = localizer.add_ceiling(image if i < 19 else dark, stamp)
            if i == 18:
                self.assertTrue(estimate)
                heading, sigma = estimate.heading
                self.assertAlmostEqual(heading, 0.25)
                self.assertAlmostEqual(sigma, 0.02, delta=0.01)
                self.assertEqual(estimate.heading_frame, "relative")
                self.assertGreater(estimate.peak, 0.5)
                self.assertGreaterEqual(estimate.blocks, estimate.inliers)
                covariance = estimate.covariance
        self.assertEqual(estimate.status, "predicted")
        self.assertFalse(estimate)
        self.assertAlmostEqual(estimate.pose[0], truth[19, 1], delta=0.02)
        self.assertGreater(estimate.covariance[0, 0], covariance[0, 0])
        self.assertEqual(localizer.report["predicted"], 1)
        self.assertEqual(localizer.sensed()["wheels"]["samples"], 20)

    def test_restart_near_a_pose(self):
        localizer = ceilmap.CeilingLocalizer(self.map, ceilmap.Rig.load(support.UP_RIG))
        first = localizer.add_ceiling(*self.images[5])
        self.assertFalse(first)  # one image alone is not confirmed
        self.assertEqual((first.pose, first.covariance, first.matrix, first.tum), (None,) * 4)
        self.assertEqual(first.places.shape, (first.hypotheses, 4))
        x, y, yaw = ceilmap.Map(self.map).trajectory[["x", "y", "yaw"]][40]
        localizer.restart((x, y, yaw), np.diag([0.1, 0.1, 0.05]) ** 2)
        estimate = localizer.add_ceiling(*self.images[40])
        self.assertTrue(estimate)
        np.testing.assert_allclose(estimate.pose[:2], [x, y], atol=0.002)
        localizer.restart()
        self.assertFalse(localizer.add_ceiling(*self.images[41]))

    def test_faults(self):
        make = ceilmap.CeilingLocalizer
        missing = self.map.with_name("none.gpkg")
        self.assert_fails(ceilmap.InputError, f"{missing}: no such file", make, missing)
        self.assert_fails(
            ceilmap.InputError, "start_covariance: give start too",
            make, self.map, start_covariance=np.eye(3),
        )
        self.assert_fails(
            ceilmap.InputError, "start_covariance: shape is (2, 2), must be (3, 3), of (x, y, yaw)",
            make, self.map, start=(0, 0, 0), start_covariance=np.eye(2),
        )
        self.assert_fails(
            ceilmap.InputError,
            "start_covariance: must be finite and symmetric, with variances > 0 on its diagonal",
            make, self.map, start=(0, 0, 0), start_covariance=-np.eye(3),
        )


class Rig(support.Case):
    def test_facts(self):
        rig = ceilmap.Rig.parse(SIMPLE_RIG)
        self.assertEqual((rig.ceiling_height, rig.axle_behind_mast), (2.6, 0))
        self.assertEqual(rig.cameras, {"up": (640, 480)})
        self.assertEqual(rig.yaml, SIMPLE_RIG)
        self.assertTrue(any(line.startswith("a = 0") for line in rig.assumed))
        self.assertEqual(rig.scaled_to("up", (320, 240)).cameras, {"up": (320, 240)})
        self.assertEqual(rig.cameras, {"up": (640, 480)})
        self.assertEqual(ceilmap.Rig.nominal((640, 480), 70, 2.6, 0.4).ceiling_height, 2.6)

    def test_faults(self):
        self.assert_fails(
            ceilmap.InputError, "camera 'down': must be up, forward or omni",
            ceilmap.Rig.parse(SIMPLE_RIG).scaled_to, "down", (320, 240),
        )
        file = self.folder / "rig.yaml"
        file.write_text(SIMPLE_RIG.replace("h: 2.6", "h: -2.6"))
        with self.assertRaisesRegex(ceilmap.InputError, f"^{file}:2: h = -2.6, must be [^\n]*$"):
            ceilmap.Rig.load(file)


if __name__ == "__main__":
    unittest.main()
