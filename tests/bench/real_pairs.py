#!/usr/bin/env python3
"""Registration of neighbouring real images, judged against SIFT + RANSAC.

usage: real_pairs.py DATA -o DIR [--ceilmap PROGRAM] [ARGUMENT ...]

DATA holds the folders of SETS below. All pairs of neighbouring images are reduced to at most 800 px, and
SIFT features, a ratio test of 0.85 and RANSAC on a similarity (5 px) give the motion to compare with, if at
least 40 matches agree. `ceilmap register` (ARGUMENTs are passed on) registers the same images at their full
size. An answer is right when its shift of the image's centre is within 2 % of the image's width.
Needs python3-opencv. Prints a table.
"""
import argparse
import csv
import gzip
import math
import os
import subprocess

import cv2
import numpy as np

MIN_INLIERS = 40
MAX_SHIFT = 0.02
SIFT_PX = 800
CYCLOID = (480, 640)
GREY = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION  # all images of a set have one size

# Images of a set and its neighbouring pairs (indices).
SETS = {
    "aerial-brighton": (["DJI_0033.JPG", "DJI_0034.JPG"], [(0, 1)]),
    "ceiling-cheepbot": (["1_0.jpg", "2_6.jpg", "3_-7.1.jpg", "4_7.1.jpg", "5_-14.jpg"], [(0, 1), (1, 2), (2, 3), (3, 4)]),
    "ceiling-croomba": ([f"Camera2_{i}.jpg" for i in range(1, 7)],
                        [(0, 1), (2, 3), (4, 5), (0, 2), (2, 4), (1, 3), (3, 5)]),
    "ceiling-cycloid": (None, [(i, i + 1) for i in range(199)]),
    "ceiling-tudelft": (["430_db_photo.jpg", "430_user_photo.jpg", "430_user1_photo.jpg"], [(0, 1), (1, 2), (0, 2)]),
}


def images_of(data, name, folder):
    """Writes the images of a set as grey PNG files (EXIF orientation ignored) and returns their paths."""
    os.makedirs(folder, exist_ok=True)
    paths = []
    if SETS[name][0] is None:
        raw = np.frombuffer(gzip.open(os.path.join(data, name, "data.raw.gz")).read(), np.uint8).reshape(-1, *CYCLOID)
        images = [(f"{i:03d}", image) for i, image in enumerate(raw)]
    else:
        images = [(os.path.splitext(f)[0], cv2.imread(os.path.join(data, name, f), GREY)) for f in SETS[name][0]]
    for stem, image in images:
        paths.append(os.path.join(folder, f"{name}_{stem}.png"))
        if not os.path.exists(paths[-1]):
            cv2.imwrite(paths[-1], image)
    return paths


def features(path, cache):
    if path not in cache:
        image = cv2.imread(path, cv2.IMREAD_GRAYSCALE)
        scale = max(1.0, max(image.shape) / SIFT_PX)
        small = cv2.resize(image, None, fx=1 / scale, fy=1 / scale, interpolation=cv2.INTER_AREA) if scale > 1 else image
        keypoints, descriptors = cv2.SIFT_create(contrastThreshold=0.01).detectAndCompute(small, None)
        points = np.array([k.pt for k in keypoints]).reshape(-1, 2)
        cache[path] = (points, descriptors, small.shape, image.shape[1] / small.shape[1])
    return cache[path]


def yardstick(path_a, path_b, cache):
    """(tx, ty, theta, scale, inliers) in full pixels, as `ceilmap register` defines them; None without an answer."""
    a, da, shape, factor = features(path_a, cache)
    b, db, shape_b, _ = features(path_b, cache)
    if shape != shape_b or da is None or db is None or min(len(a), len(b)) < 3:
        return None
    matches = [m[0] for m in cv2.BFMatcher(cv2.NORM_L2).knnMatch(da, db, k=2)
               if len(m) == 2 and m[0].distance < 0.85 * m[1].distance]
    if len(matches) < 3:
        return None
    cv2.setRNGSeed(1)
    m, inliers = cv2.estimateAffinePartial2D(a[[x.queryIdx for x in matches]], b[[x.trainIdx for x in matches]],
                                             ransacReprojThreshold=5, maxIters=10000, confidence=0.9999)
    if m is None:
        return None
    c = np.array([(shape[1] - 1) / 2, (shape[0] - 1) / 2])
    t = (m[:, :2] @ c + m[:, 2] - c) * factor
    return t[0], t[1], math.atan2(m[1, 0], m[0, 0]), math.hypot(m[1, 0], m[0, 0]), int(inliers.sum())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--ceilmap", default="build/release/app/ceilmap")
    parser.add_argument("--verbose", action="store_true", help="a line for each pair")
    args, passed_on = parser.parse_known_args()

    print(f"{'set':<18}{'pairs':>6}{'SIFT':>6}{'answered':>9}{'right':>6}{'wrong':>6}"
          f"{'other answers':>15}{'worst % of width':>18}")
    for name, (_, neighbours) in SETS.items():
        folder = os.path.join(os.path.abspath(args.output), name)
        paths = images_of(args.data, name, folder)
        neighbours = [(i, j) for i, j in neighbours
                      if cv2.imread(paths[i], 0).shape == cv2.imread(paths[j], 0).shape]
        pairs, results = os.path.join(folder, "pairs.csv"), os.path.join(folder, "results.csv")
        with open(pairs, "w") as out:
            out.write("id,reference,current\n")
            for i, j in neighbours:
                out.write(f"{i}-{j},{paths[i]},{paths[j]}\n")
        subprocess.run([args.ceilmap, "register", "--pairs", pairs, "-o", results, "--force"] + passed_on,
                       check=True, stdout=subprocess.DEVNULL)
        found = {row["id"]: row for row in csv.DictReader(open(results))}
        cache = {}
        sure = answered = right = wrong = others = 0
        worst = 0.0
        for i, j in neighbours:
            row = found[f"{i}-{j}"]
            ok = row["ok"] == "1"
            truth = yardstick(paths[i], paths[j], cache)
            judged = truth is not None and truth[4] >= MIN_INLIERS
            sure += judged
            others += ok and not judged
            off = math.nan
            width = cv2.imread(paths[i], 0).shape[1]
            if ok and truth:
                off = math.hypot(float(row["tx"]) - truth[0], float(row["ty"]) - truth[1]) / width
            if ok and judged:
                answered += 1
                good = off <= MAX_SHIFT
                right += good
                wrong += not good
                worst = max(worst, off)
            if args.verbose:
                sift = "none" if truth is None else "({:.0f}, {:.0f}) px {:.1f} deg x {:.3f}, {} inliers".format(
                    truth[0], truth[1], math.degrees(truth[2]), truth[3], truth[4])
                mine = "none" if not ok else "({:.0f}, {:.0f}) px {:.1f} deg x {:.3f}".format(
                    *(float(row[k]) for k in ("tx", "ty", "theta_deg", "scale")))
                print(f"  {i}-{j}: SIFT {sift}; ceilmap {mine}; {100 * off:.2f} %")
        print(f"{name:<18}{len(neighbours):>6}{sure:>6}{answered:>9}{right:>6}{wrong:>6}{others:>15}{100 * worst:>18.2f}")


if __name__ == "__main__":
    main()
