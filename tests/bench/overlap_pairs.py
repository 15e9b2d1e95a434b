#!/usr/bin/env python3
"""Registration of pairs of frames by the fraction of the image that they have in common.

usage: overlap_pairs.py RECORDING -o DIR [--ceilmap PROGRAM] [--pairs 400] [ARGUMENT ...]

RECORDING holds up.mp4, rig.yaml (level ceiling, pinhole without distortion) and truth.tum. Random pairs of
frames of every band of overlap are drawn with a fixed seed, registered by `ceilmap register` (ARGUMENTs
are passed on), and compared with the truth. An answer is right within 3 px and 0.5 deg. Needs
python3-opencv and python3-yaml. Prints a table; exits with 1 when an answer is wrong.
"""
import argparse
import csv
import math
import os
import subprocess

import cv2
import numpy as np
import yaml

MAX_PX = 3.0
MAX_DEG = 0.5
BANDS = [(10, 20), (20, 30), (30, 40), (40, 50), (50, 60), (60, 80)]


def read_rig(path):
    """Distance of the ceiling from the camera `up`, and the camera matrix."""
    rig = yaml.safe_load(open(path))
    up = rig["cameras"]["up"]
    distance = rig["h"] - up["base_link_to_camera"]["translation"][2]
    return distance, np.array(up["camera_matrix"]["data"], float).reshape(3, 3)


def read_truth(path):
    rows = np.loadtxt(path)
    yaw = 2 * np.arctan2(rows[:, 6], rows[:, 7])
    return np.column_stack([rows[:, 1], rows[:, 2], yaw])


def motion(a, b, distance, focal):
    """Image motion a -> b (tx, ty, theta) of a level camera: R_b' (p - t_b), image (u, v) = f (Y, -X) / Z."""
    def to_image(x, y):
        return np.array([focal * y / distance, -focal * x / distance])
    theta_base = a[2] - b[2]
    c, s = math.cos(-b[2]), math.sin(-b[2])
    dx, dy = a[0] - b[0], a[1] - b[1]
    t = to_image(c * dx - s * dy, s * dx + c * dy)
    theta = math.atan2(math.sin(theta_base), math.cos(theta_base))
    return t[0], t[1], theta


def overlap(m, width, height, samples=40):
    xs = ((np.arange(samples) + 0.5) / samples - 0.5) * width
    ys = ((np.arange(samples) + 0.5) / samples - 0.5) * height
    x, y = np.meshgrid(xs, ys)
    c, s = math.cos(m[2]), math.sin(m[2])
    u = c * x - s * y + m[0]
    v = s * x + c * y + m[1]
    return float(np.mean((np.abs(u) < width / 2) & (np.abs(v) < height / 2)))


def write_frames(video, folder):
    os.makedirs(folder, exist_ok=True)
    if os.path.exists(os.path.join(folder, "complete")):
        return
    capture = cv2.VideoCapture(video)
    i = 0
    while True:
        ok, frame = capture.read()
        if not ok:
            break
        cv2.imwrite(os.path.join(folder, f"{i:05d}.png"), cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))
        i += 1
    open(os.path.join(folder, "complete"), "w").close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--ceilmap", default="build/release/app/ceilmap")
    parser.add_argument("--pairs", type=int, default=400)
    args, passed_on = parser.parse_known_args()

    distance, k = read_rig(os.path.join(args.recording, "rig.yaml"))
    truth = read_truth(os.path.join(args.recording, "truth.tum"))
    frames = os.path.join(args.output, "frames")
    write_frames(os.path.join(args.recording, "up.mp4"), frames)
    height, width = cv2.imread(os.path.join(frames, "00000.png"), cv2.IMREAD_GRAYSCALE).shape

    rng = np.random.default_rng(1)
    chosen = {band: [] for band in BANDS}
    for i, j in rng.integers(0, len(truth), (400000, 2)):
        if all(len(c) >= args.pairs for c in chosen.values()):
            break
        if i == j:
            continue
        if np.hypot(*(truth[i, :2] - truth[j, :2])) * k[0, 0] / distance > math.hypot(width, height):
            continue
        m = motion(truth[i], truth[j], distance, k[0, 0])
        common = 100 * overlap(m, width, height)
        for band in BANDS:
            if band[0] <= common < band[1] and len(chosen[band]) < args.pairs:
                chosen[band].append((i, j, m, common))

    pairs = os.path.join(args.output, "pairs.csv")
    with open(pairs, "w") as out:
        out.write("id,reference,current\n")
        for band in BANDS:
            for n, (i, j, _, _) in enumerate(chosen[band]):
                out.write(f"{band[0]}_{n},frames/{i:05d}.png,frames/{j:05d}.png\n")
    results = os.path.join(args.output, "results.csv")
    subprocess.run([args.ceilmap, "register", "--pairs", pairs, "-o", results, "--force"] + passed_on,
                   check=True, stdout=subprocess.DEVNULL)
    found = {row["id"]: row for row in csv.DictReader(open(results))}

    any_wrong = False
    print(f"{'overlap':>10}{'pairs':>7}{'right':>9}{'wrong':>9}{'median px':>11}{'p95 px':>8}{'median ms':>11}")
    for band in BANDS:
        right, wrong, errors, ms = 0, 0, [], []
        for n, (i, j, m, common) in enumerate(chosen[band]):
            row = found[f"{band[0]}_{n}"]
            if row["ok"] != "1":
                continue
            error = math.hypot(float(row["tx"]) - m[0], float(row["ty"]) - m[1])
            turn = abs((float(row["theta_deg"]) - math.degrees(m[2]) + 180) % 360 - 180)
            ms.append(float(row["ms"]))
            if error < MAX_PX and turn < MAX_DEG:
                right += 1
                errors.append(error)
            else:
                wrong += 1
                any_wrong = True
                print(f"# wrong: {i} {j} {common:.0f} %: {error:.1f} px {turn:.2f} deg")
        total = max(1, len(chosen[band]))
        median, p95 = np.percentile(errors, [50, 95]) if errors else (math.nan, math.nan)
        print(f"{band[0]:>5}-{band[1]} %{len(chosen[band]):>7}{100 * right / total:>8.1f}%{100 * wrong / total:>8.2f}%"
              f"{median:>11.3f}{p95:>8.3f}{np.median(ms) if ms else math.nan:>11.2f}")
    return 1 if any_wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
