"""The module computes what the program computes, to the last bit."""
import csv
import json
import math
import unittest

import numpy as np

import ceilmap
import support


def tum_line(row):
    """As the program writes a pose."""
    q = row[4:] / np.linalg.norm(row[4:])
    return " ".join(
        [f"{row[0]:.6f}", *(f"{value:.9f}" for value in row[1:4]), *(f"{value:.12f}" for value in q)]
    )


def tum_lines(file):
    return [line for line in file.read_text().splitlines() if not line.startswith("#")]


class Program(support.Case):
    def pipelined(self, robot, images, forward=()):
        """As the program reads a recording."""
        estimates = []
        for index, (image, stamp) in enumerate(images):
            if forward:
                robot.add_forward(*forward[index])
            estimates.append(robot.add_ceiling_pipelined(image, stamp))
        return [e for e in estimates + [robot.flush()] if e is not None]

    def write(self, name, images):
        support.write_images(self.folder / name, [image for image, _ in images])
        support.write_stamps(self.folder / f"{name}.csv", [stamp for _, stamp in images])
        return self.folder / name, self.folder / f"{name}.csv"

    def assert_same_map(self, ours, programs):
        for table in ("keyframes", "trajectory", "edges", "weak_spots"):
            mine, theirs = getattr(ours, table), getattr(programs, table)
            self.assertEqual(mine.dtype, theirs.dtype)
            self.assertEqual(mine.tobytes(), theirs.tobytes(), table)
        self.assertEqual(ours.extent, programs.extent)
        np.testing.assert_array_equal(ours.mosaic().image, programs.mosaic().image)
        np.testing.assert_array_equal(ours.mosaic().alpha, programs.mosaic().alpha)
        self.assertEqual(ours.quality, programs.quality)

    def test_register(self):
        images = support.frames("lab-map", count=30)
        pairs = [(0, 1), (0, 5), (3, 0), (10, 29), (0, 29)]
        self.write("up", images)
        lines = [f"{i},up/{a:06}.png,up/{b:06}.png\n" for i, (a, b) in enumerate(pairs)]
        (self.folder / "pairs.csv").write_text("id,reference,current\n" + "".join(lines))
        for options in ((), ("--fixed-scale",)):
            support.run_ceilmap(
                "register", "--pairs", "pairs.csv", "-o", "out.csv", "--force", *options,
                folder=self.folder,
            )
            with (self.folder / "out.csv").open() as file:
                rows = list(csv.DictReader(file))
            self.assertEqual(len(rows), len(pairs))
            for (a, b), row in zip(pairs, rows):
                found = ceilmap.register(images[a][0], images[b][0], fixed_scale=bool(options))
                self.assertEqual(row["ok"], "01"[found.ok])
                if not found:
                    self.assertEqual((found.tx, row["tx"]), (None, ""))
                    continue
                self.assertEqual(f"{found.tx:.6f}", row["tx"])
                self.assertEqual(f"{found.ty:.6f}", row["ty"])
                self.assertEqual(f"{180 / math.pi * found.theta:.6f}", row["theta_deg"])
                self.assertEqual(f"{found.scale:.8f}", row["scale"])
                self.assertEqual(f"{found.peak:.6f}", row["peak"])
                self.assertEqual(f"{found.runner_up:.6f}", row["runner_up"])
            self.assertEqual(rows[0]["ok"], "1")

    def test_map_localize_evaluate(self):
        images, stamps = self.write("up", support.frames("lab-map", count=90))
        support.run_ceilmap(
            "map", "--rig", support.UP_RIG, "--up", images, "--stamps", stamps,
            "-o", "theirs.gpkg", "--trajectory", "theirs.tum", folder=self.folder,
        )
        mapper = ceilmap.CeilingMapper(ceilmap.Rig.load(support.UP_RIG), self.folder / "ours.gpkg")
        self.pipelined(mapper, support.frames("lab-map", count=90))
        result = mapper.finish()
        ours = ceilmap.Map(self.folder / "ours.gpkg")
        self.assert_same_map(ours, ceilmap.Map(self.folder / "theirs.gpkg"))
        self.assertEqual([*map(tum_line, result.poses)], tum_lines(self.folder / "theirs.tum"))
        np.testing.assert_array_equal(result.poses, ours.poses)
        self.localize()
        self.evaluate(ours)

    def localize(self):
        second = support.SAMPLES / "lab-second-robot" / "rig.yaml"
        recording = support.frames("lab-second-robot", count=60)
        images, stamps = self.write("second", recording)
        support.run_ceilmap(
            "localize", "theirs.gpkg", "--rig", second, "--up", images, "--stamps", stamps,
            "-o", "second.tum", "--status", "status.csv", folder=self.folder,
        )
        localizer = ceilmap.CeilingLocalizer(self.folder / "ours.gpkg", ceilmap.Rig.load(second))
        estimates = self.pipelined(localizer, recording)
        placed = [tum_line(e.tum) for e in estimates if e]
        self.assertGreater(len(placed), 20)
        self.assertEqual(placed, tum_lines(self.folder / "second.tum"))
        with (self.folder / "status.csv").open() as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([e.status for e in estimates], [row["status"] for row in rows])
        for estimate, row in zip(estimates, rows):
            if not estimate:
                self.assertEqual((row["peak"], row["inliers"]), ("", ""))
                continue
            self.assertEqual(row["inliers"], str(estimate.inliers))
            self.assertEqual(row["peak"], f"{estimate.peak:.{len(row['peak'].split('.')[1])}f}")
            self.assertAlmostEqual(float(row["sigma_x"]), estimate.covariance[0, 0] ** 0.5, 6)

    def evaluate(self, ours):
        truth = support.SAMPLES / "lab-map" / "truth.tum"
        support.run_ceilmap(
            "evaluate", "--truth", truth, "run=theirs.tum", "-o", "report", folder=self.folder
        )
        metrics = json.loads((self.folder / "report" / "metrics.json").read_text())
        theirs = metrics["estimates"]["run"]
        errors = ceilmap.evaluate(np.loadtxt(truth), np.loadtxt(self.folder / "theirs.tum"))
        frames = errors.pop("frames")
        self.assertEqual(len(frames), errors["matched"])
        self.assertLess({"position_m", "ape", "rpe", "segments"}, set(errors))
        for key, value in errors.items():
            self.assertEqual(value, theirs[key], key)

    def test_forward_camera_and_tilt(self):
        recording = support.SAMPLES / "lab-debris-1"
        up = support.frames("lab-debris-1", count=60)
        forward = support.frames("lab-debris-1", "forward", 60)
        images, stamps = self.write("up", up)
        ahead, _ = self.write("forward", forward)
        support.run_ceilmap(
            "map", "--rig", recording / "rig.yaml", "--up", images, "--forward", ahead,
            "--stamps", stamps, "-o", "theirs.gpkg", folder=self.folder,
        )
        rig = ceilmap.Rig.load(recording / "rig.yaml")
        mapper = ceilmap.CeilingMapper(rig, self.folder / "ours.gpkg")
        estimates = self.pipelined(mapper, up, forward)
        mapper.finish()
        self.assertGreater(max(abs(e.tilt[0]) for e in estimates), 0.01, "no bump in these images")
        ours = ceilmap.Map(self.folder / "ours.gpkg")
        self.assert_same_map(ours, ceilmap.Map(self.folder / "theirs.gpkg"))


if __name__ == "__main__":
    unittest.main()
