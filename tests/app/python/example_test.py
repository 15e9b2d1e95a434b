"""The example of samples/python runs as its README says."""
import re
import subprocess
import sys
import unittest

import cv2

import support


class Example(support.Case):
    def test_maps_localizes_and_draws(self):
        script = support.SAMPLES / "python" / "map_localize_plot.py"
        result = subprocess.run(
            [sys.executable, str(script), str(self.folder)], capture_output=True, text=True
        )
        self.assertEqual(result.returncode, 0, result.stderr)
        printed = re.fullmatch(
            r"mapped (\d+) images; RMSE ([\d.]+) mm\nlocalized (\d+) images of the second robot\n",
            result.stdout,
        )
        self.assertEqual(printed.group(1), "230")
        self.assertLess(float(printed.group(2)), 0.3)
        self.assertGreater(int(printed.group(3)), 110)
        picture = cv2.imread(str(self.folder / "map.png"))
        self.assertGreater(picture.std(), 20, "the mosaic is not in the picture")


if __name__ == "__main__":
    unittest.main()
