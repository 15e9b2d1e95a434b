"""Reading of maps."""
import gc
import os
import threading
import tracemalloc
import unittest

import numpy as np

import ceilmap
import support


class Map(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = support.tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.path = support.pathlib.Path(folder.name) / "lab.gpkg"
        cls.result = support.map_frames(cls.path, origin=(1, 2, 0.5), provenance="a test")
        cls.map = ceilmap.Map(cls.path)

    def test_tables(self):
        keyframes, trajectory = self.map.keyframes, self.map.trajectory
        self.assertEqual(len(trajectory), 30)
        self.assertEqual(list(trajectory["frame"]), list(range(30)))
        self.assertEqual(set(trajectory["status"]), {"tracking"})
        first = trajectory[0]
        np.testing.assert_allclose([first["x"], first["y"], first["yaw"]], [1, 2, 0.5], atol=1e-12)
        self.assertEqual(keyframes["id"][0], 0)
        self.assertFalse(keyframes["ambiguous"].any())
        np.testing.assert_allclose(  # the last keyframe's image was measured once more
            keyframes["x"],
            trajectory["x"][np.isin(trajectory["frame"], keyframes["frame"])],
            atol=0.001,
        )
        covariances = trajectory["covariance"]
        self.assertEqual(covariances.shape, (30, 3, 3))
        self.assertGreater(np.linalg.eigvalsh(covariances[-1]).min(), 0)
        np.testing.assert_array_equal(self.map.poses, self.result.poses)
        np.testing.assert_array_equal(self.map.poses[:, 0], trajectory["stamp"])

    def test_edges_connect_keyframes(self):
        keyframes = {row["id"]: row for row in self.map.keyframes}
        self.assertGreaterEqual(len(self.map.edges), len(keyframes) - 1)
        for edge in self.map.edges:
            a, b = keyframes[edge["from"]], keyframes[edge["to"]]
            c, s = np.cos(a["yaw"]), np.sin(a["yaw"])
            dx, dy = b["x"] - a["x"], b["y"] - a["y"]
            self.assertAlmostEqual(edge["x"], c * dx + s * dy, delta=0.002)
            self.assertAlmostEqual(edge["y"], c * dy - s * dx, delta=0.002)
            self.assertIn(edge["kind"], ("odometry", "loop"))
            self.assertGreater(np.linalg.eigvalsh(edge["information"]).min(), 0)

    def test_mosaic(self):
        mosaic = self.map.mosaic()
        self.assertIsInstance(mosaic.extent, tuple)
        left, right, bottom, top = mosaic.extent
        height, width = mosaic.image.shape
        self.assertEqual(mosaic.alpha.shape, (height, width))
        self.assertEqual((mosaic.image.dtype, mosaic.alpha.dtype), (np.uint8, np.uint8))
        self.assertEqual(mosaic.extent, self.map.extent)
        self.assertAlmostEqual(mosaic.resolution, self.map.metadata["resolution"], 12)
        self.assertAlmostEqual(right - left, width * mosaic.resolution)
        self.assertAlmostEqual(top - bottom, height * mosaic.resolution)
        x, y = self.map.poses[10, 1:3]
        column, row = int((x - left) / mosaic.resolution), int((top - y) / mosaic.resolution)
        self.assertEqual(mosaic.alpha[row, column], 255)
        small = self.map.mosaic(max_side=200)
        self.assertLessEqual(max(small.image.shape), 200)
        factor = round(small.resolution / mosaic.resolution)
        block = mosaic.image[row // factor * factor :, column // factor * factor :]
        self.assertAlmostEqual(
            float(small.image[row // factor, column // factor]),
            block[:factor, :factor].mean(), delta=2,
        )

    def test_arrays_outlive_their_owners(self):
        image = ceilmap.Map(self.path).mosaic().image
        gc.collect()
        np.testing.assert_array_equal(image, self.map.mosaic().image)
        self.assertIsNotNone(image.base, "a copy")

    def test_images_of_keyframes(self):
        image = self.map.image(0)
        self.assertEqual((image.shape, image.dtype), ((480, 640), np.uint8))
        self.assertGreater(ceilmap.register(image, support.frames("lab-map", count=30)[0][0]).peak, 0.9)

    def test_metadata_and_quality(self):
        metadata = self.map.metadata
        self.assertEqual(metadata["unit"], "m")
        self.assertEqual(metadata["ceiling_height"], 2.6)
        self.assertEqual(metadata["provenance"], "a test")
        self.assertEqual(metadata["view_size"], (640, 480))
        self.assertEqual(metadata["program_version"], ceilmap.__version__)
        self.assertEqual(self.map.rig().cameras, {"up": (640, 480)})
        self.assertEqual(self.map.rig().yaml, support.UP_RIG.read_text())
        self.assertEqual(self.map.path, self.path)
        self.assertEqual(self.map.quality, self.result.report["quality"])
        self.assertEqual(len(self.map.weak_spots), len(self.result.weak_spots))

    def test_read_from_several_threads(self):
        expected = [self.map.image(i).tobytes() for i in self.map.keyframes["id"]]
        read = {}

        def work(name):
            read[name] = [self.map.image(i).tobytes() for i in self.map.keyframes["id"]]

        threads = [threading.Thread(target=work, args=(name,)) for name in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual([read[name] == expected for name in range(4)], [True] * 4)

    def test_no_leak(self):
        opens = int(os.environ.get("CEILMAP_OPENS", "200"))

        def use():
            a_map = ceilmap.Map(self.path)
            return a_map.mosaic(200).image, a_map.keyframes, a_map.edges, a_map.metadata

        for _ in range(50):  # caches of the libraries fill
            use()
        tracemalloc.start()
        self.addCleanup(tracemalloc.stop)
        use()
        objects, pages = self.objects(), self.resident()
        for _ in range(opens):
            use()
        objects, pages = self.objects() - objects, self.resident() - pages
        if "CEILMAP_OPENS" in os.environ:
            print(f"{opens} maps opened: {objects} bytes of Python, {pages >> 10} KiB resident")
        self.assertLess(objects, 2000)
        self.assertLess(pages, 4 << 20)

    @staticmethod
    def objects():
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    @staticmethod
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


class Faults(support.Case):
    def test_no_map(self):
        missing = self.folder / "none.gpkg"
        self.assert_fails(ceilmap.InputError, f"{missing}: no such file", ceilmap.Map, missing)
        text = self.folder / "text.gpkg"
        text.write_text("no map\n" * 100)
        with self.assertRaises(ceilmap.InputError) as raised:
            ceilmap.Map(str(text))
        self.assertRegex(str(raised.exception), f"^{text}: .*$")
        self.assertIsInstance(raised.exception, ValueError)

    def test_arguments(self):
        path = self.folder / "lab.gpkg"
        support.map_frames(path, count=3)
        lab = ceilmap.Map(path)
        self.assert_fails(ceilmap.InputError, "max_side: must be >= 1", lab.mosaic, 0)
        self.assert_fails(
            ceilmap.InputError, f"{path}: the map holds no image of keyframe 77", lab.image, 77
        )


if __name__ == "__main__":
    unittest.main()
