"""Maps the ceiling with one robot, localizes another one on that map, and draws both.

    python3 samples/python/map_localize_plot.py [OUTPUT_DIR]
"""
import pathlib
import sys

import ceilmap
import cv2
import matplotlib.pyplot as plt
import numpy as np

samples = pathlib.Path(__file__).resolve().parents[1]
out = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")


def drive(recording, robot):
    """Gives a robot all images of a recording; yields what is known of it at each of them."""
    video = cv2.VideoCapture(str(samples / recording / "up.mp4"))
    for index, stamp in np.loadtxt(samples / recording / "frames.csv", delimiter=",", skiprows=1):
        image = cv2.cvtColor(video.read()[1], cv2.COLOR_BGR2GRAY)
        yield robot.add_ceiling(image, stamp, int(index))


mapper = ceilmap.CeilingMapper(ceilmap.Rig.load(samples / "lab-map/rig.yaml"), out / "lab.gpkg")
placed = sum(map(bool, drive("lab-map", mapper)))
mapped = mapper.finish()
errors = ceilmap.evaluate(np.loadtxt(samples / "lab-map/truth.tum"), mapped.poses)
print(f"mapped {placed} images; RMSE {1e3 * errors['position_m']['rmse']:.2f} mm")

rig = ceilmap.Rig.load(samples / "lab-second-robot/rig.yaml")
localizer = ceilmap.CeilingLocalizer(out / "lab.gpkg", rig)
found = np.array([e.pose for e in drive("lab-second-robot", localizer) if e])
print(f"localized {len(found)} images of the second robot")

mosaic = ceilmap.Map(out / "lab.gpkg").mosaic()
plt.imshow(np.ma.masked_where(mosaic.alpha == 0, mosaic.image), "gray", extent=mosaic.extent)
plt.plot(*mapped.poses[:, 1:3].T, label="first robot, mapped")
plt.plot(*found[:, :2].T, label="second robot, localized")
plt.legend()
plt.savefig(out / "map.png", dpi=150)
