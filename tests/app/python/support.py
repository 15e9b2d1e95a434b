"""What the tests of the Python module share."""
import functools
import os
import pathlib
import subprocess
import tempfile
import unittest

import cv2
import numpy as np

import ceilmap

SOURCE = pathlib.Path(os.environ["CEILMAP_SOURCE_DIR"])
SAMPLES = SOURCE / "samples"
UP_RIG = SAMPLES / "lab-map" / "rig.yaml"


def run_ceilmap(*arguments, folder):
    """Runs the program to its end; returns its stdout. It must succeed."""
    command = [os.environ["CEILMAP_EXE"], *map(str, arguments)]
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if result.returncode != 0:
        raise AssertionError(f"{command} ended with {result.returncode}: {result.stderr}")
    return result.stdout


@functools.lru_cache(maxsize=None)
def frames(recording, camera="up", count=None):
    """The first images of a bundled recording, grey, and their stamps."""
    video = cv2.VideoCapture(str(SAMPLES / recording / f"{camera}.mp4"))
    stamps = np.loadtxt(SAMPLES / recording / "frames.csv", delimiter=",", skiprows=1)[:count, 1]
    return [(cv2.cvtColor(video.read()[1], cv2.COLOR_BGR2GRAY), stamp) for stamp in stamps]


def write_images(folder, images):
    """Writes images, as the program reads a folder."""
    folder.mkdir()
    for index, image in enumerate(images):
        cv2.imwrite(str(folder / f"{index:06}.png"), image)


def write_stamps(file, stamps):
    lines = [f"{index},{stamp:.6f}\n" for index, stamp in enumerate(stamps)]
    file.write_text("index,timestamp\n" + "".join(lines))


class Case(unittest.TestCase):
    """A test with a folder of its own, and comparison of whole messages."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def assert_fails(self, error, message, function, *arguments, **keywords):
        with self.assertRaises(error) as raised:
            function(*arguments, **keywords)
        self.assertIs(type(raised.exception), error)
        self.assertEqual(str(raised.exception), message)


def map_frames(path, recording="lab-map", count=30, **keywords):
    """Maps the start of a recording; returns the result."""
    mapper = ceilmap.CeilingMapper(ceilmap.Rig.load(UP_RIG), path, **keywords)
    for image, stamp in frames(recording, count=count):
        mapper.add_ceiling(image, stamp)
    return mapper.finish()
