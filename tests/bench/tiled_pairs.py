#!/usr/bin/env python3
"""Registration without a prediction under tiled ceilings: pairs of other places, and pairs of one place.

usage: tiled_pairs.py -o DIR [--ceilmap PROGRAM] [--seed 1] [--others 1500] [--true 600] [ARGUMENT ...]

Renders random views of simulated ceilings (WORLDS below: halls of up to 100 m, strong to invisible grain of the
tiles, marks, strict lattices, other noise and blur; everything from the seed), and registers by `ceilmap register`
(ARGUMENTs are passed on):
  others  two views that have nothing in common but the grid: any match is wrong;
  true    two views with 60 to 95 % in common: right within 3 px and 0.5 deg.
Views that exist in DIR are reused. Needs python3-yaml and python3-numpy. Prints a table of worlds; exits with 1 when
a pair of other places is taken for a match.
"""
import argparse
import copy
import csv
import math
import os
import subprocess

import numpy as np
import yaml

MAX_PX = 3.0
MAX_DEG = 0.5
TRUE_OVERLAP = (0.6, 0.95)
FOCAL_PX = 457
CAMERA_M = 0.4
SIZE = (640, 480)
PLACES = 60  # views of a world, of which each third one has a second view that overlaps

# name, scene file, what differs from it
WORLDS = [
    ("hall", "hall", {}),
    ("hall-fine", "hall", {"ceiling": {"speckle_contrast": 0.02}}),
    ("hall-bare", "hall", {"ceiling": {"speckle_contrast": 0.005, "tile_contrast": 0.01, "stains_per_100m2": 1,
                                       "vents_per_100m2": 0.5}}),
    ("hall-noise", "hall", {"ceiling": {"speckle_contrast": 0.03}, "picture": {"shot_noise": 0.03}}),
    ("hall-blur", "hall", {"picture": {"blur_px": 1.8}}),
    ("hall-no-lamps", "hall", {"ceiling": {"speckle_contrast": 0.02, "lamp_every_x": 0, "lamp_every_y": 0,
                                           "lamps_off_share": 0}}),
    ("hall-dense-lamps", "hall", {"ceiling": {"speckle_contrast": 0.02, "lamp_every_x": 3, "lamp_every_y": 3}}),
    ("warehouse", "warehouse", {}),
    ("warehouse-fine", "warehouse", {"ceiling": {"speckle_contrast": 0.02}}),
    ("small-tiles", "hall", {"room": {"height_m": 3}, "ceiling": {"tile_length_m": 0.3, "tile_width_m": 0.3,
                                                                  "speckle_contrast": 0.03}}),
    ("long-tiles", "hall", {"ceiling": {"tile_length_m": 1.2, "speckle_contrast": 0.02}}),
    ("periodic", "periodic", {}),
    ("periodic-hall", "periodic-hall", {}),
    ("periodic-marks", "periodic-hall", {"ceiling": {"marks": 400}}),
    ("corridor", "corridor", {}),
]


def merge(base, changes):
    for key, value in changes.items():
        if isinstance(value, dict):
            merge(base.setdefault(key, {}), value)
        else:
            base[key] = value
    return base


def motion(a, b, px_per_m):
    """Image motion a -> b (tx, ty, theta) of a level camera: R_b' (p - t_b), image (u, v) = f (Y, -X) / Z."""
    c, s = math.cos(b[2]), math.sin(b[2])
    dx, dy = a[0] - b[0], a[1] - b[1]
    x, y = c * dx + s * dy, -s * dx + c * dy
    turn = a[2] - b[2]
    return px_per_m * y, -px_per_m * x, math.atan2(math.sin(turn), math.cos(turn))


def overlap(m, samples=40):
    xs = ((np.arange(samples) + 0.5) / samples - 0.5) * SIZE[0]
    ys = ((np.arange(samples) + 0.5) / samples - 0.5) * SIZE[1]
    x, y = np.meshgrid(xs, ys)
    c, s = math.cos(m[2]), math.sin(m[2])
    u, v = c * x - s * y + m[0], s * x + c * y + m[1]
    return float(np.mean((np.abs(u) < SIZE[0] / 2) & (np.abs(v) < SIZE[1] / 2)))


def random_yaw(rng):
    """Along the grid, as robots drive in rows, or anything."""
    if rng.random() < 0.5:
        return rng.integers(4) * math.pi / 2 + rng.normal(0, 0.01)
    return rng.uniform(-math.pi, math.pi)


def random_views(rng, room, px_per_m):
    """Poses (x, y, yaw); those from PLACES on are second views of places 0, 3, 6, ..."""
    margin = min(2.5, 0.45 * room["width_m"])

    def pose():
        return (rng.uniform(margin, room["length_m"] - margin), rng.uniform(margin, room["width_m"] - margin),
                random_yaw(rng))

    poses = [pose() for _ in range(PLACES)]
    reach = math.hypot(*SIZE) / px_per_m
    second = []
    for first in poses[::3]:
        while True:
            x, y = first[0] + rng.uniform(-reach, reach), first[1] + rng.uniform(-reach, reach)
            other = (x, y, random_yaw(rng))
            inside = (margin <= x <= room["length_m"] - margin and margin <= y <= room["width_m"] - margin)
            if inside and TRUE_OVERLAP[0] <= overlap(motion(first, other, px_per_m)) <= TRUE_OVERLAP[1]:
                second.append(other)
                break
    return poses + second


def write_scene(name, base, changes, folder, seed):
    """The scene with its poses. @return the poses and pixels per metre of ceiling."""
    scene = yaml.safe_load(open(os.path.join("samples/scenes", base + ".yaml")))
    merge(scene, copy.deepcopy(changes))
    scene["seed"] = seed
    scene.setdefault("camera", {}).update(focal_px=FOCAL_PX, mount_height_m=CAMERA_M)
    scene.setdefault("picture", {}).update(motion_blur=False)
    scene["picture"].pop("exposure_steps", None)
    px_per_m = FOCAL_PX / (scene["room"]["height_m"] - CAMERA_M)
    rng = np.random.default_rng([seed, sum(map(ord, name))])
    poses = random_views(rng, scene["room"], px_per_m)
    scene["path"] = {"kind": "tum", "tum_file": "views.tum"}
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "views.tum"), "w") as out:
        for i, (x, y, yaw) in enumerate(poses):
            out.write(f"{i} {x:.9f} {y:.9f} 0 0 0 {math.sin(yaw / 2):.12f} {math.cos(yaw / 2):.12f}\n")
    with open(os.path.join(folder, "views.yaml"), "w") as out:
        yaml.safe_dump(scene, out, sort_keys=False)
    return poses, px_per_m


def render(program, folder):
    done = os.path.join(folder, "complete")
    if os.path.exists(done):
        return
    subprocess.run([program, "simulate", os.path.join(folder, "views.yaml"), "-o", folder, "--pictures", "--force",
                    "--quiet"], check=True)
    open(done, "w").close()


def other_pairs(rng, poses, px_per_m, count):
    """Pairs of places that are further apart than two views reach."""
    apart = math.hypot(*SIZE) / px_per_m
    pairs = [(i, j) for i in range(PLACES) for j in range(PLACES)
             if i != j and math.hypot(poses[i][0] - poses[j][0], poses[i][1] - poses[j][1]) > apart]
    return [pairs[k] for k in rng.permutation(len(pairs))[:count]]


def judge(row, m):
    """'right', 'wrong' or 'none'. @param m  the true motion; None: nothing in common."""
    if row["ok"] != "1":
        return "none"
    if m is None:
        return "wrong"
    error = math.hypot(float(row["tx"]) - m[0], float(row["ty"]) - m[1])
    turn = abs((float(row["theta_deg"]) - math.degrees(m[2]) + 180) % 360 - 180)
    return "right" if error < MAX_PX and turn < MAX_DEG else "wrong"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--ceilmap", default="build/release/app/ceilmap")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--others", type=int, default=1500)
    parser.add_argument("--true", type=int, default=600, dest="true_pairs")
    parser.add_argument("--results", default="results.csv", help="name of the results in DIR")
    args, passed_on = parser.parse_known_args()

    truth = {}  # id -> world, true motion
    lines = []
    rng = np.random.default_rng(args.seed)
    for name, base, changes in WORLDS:
        folder = os.path.join(args.output, name)
        worlds_left = len(WORLDS) - len({world for world, _ in truth.values()})
        others = sum(m is None for _, m in truth.values())
        poses, px_per_m = write_scene(name, base, changes, folder, args.seed)
        render(args.ceilmap, folder)
        pairs = [(i, j, None) for i, j in
                 other_pairs(rng, poses, px_per_m, round((args.others - others) / worlds_left))]
        seconds = [(3 * k, PLACES + k) for k in range(len(poses) - PLACES)]
        seconds += [(j, i) for i, j in seconds]
        for i, j in seconds[:round(args.true_pairs / len(WORLDS))]:
            pairs.append((i, j, motion(poses[i], poses[j], px_per_m)))
        for i, j, m in pairs:
            key = f"{name}_{i}_{j}"
            truth[key] = (name, m)
            lines.append(f"{key},{name}/up/{i:06d}.png,{name}/up/{j:06d}.png\n")
    pairs_file = os.path.join(args.output, "pairs.csv")
    with open(pairs_file, "w") as out:
        out.write("id,reference,current\n" + "".join(lines))
    results = os.path.join(args.output, args.results)
    subprocess.run([args.ceilmap, "register", "--pairs", pairs_file, "-o", results, "--force", "--quiet"] + passed_on,
                   check=True, stdout=subprocess.DEVNULL)
    found = {row["id"]: row for row in csv.DictReader(open(results))}

    print(f"{'world':<18}{'others':>8}{'matches':>9}{'true':>7}{'right':>7}{'wrong':>7}")
    total = np.zeros(5, int)
    for name in [world for world, _, _ in WORLDS] + ["all"]:
        counts = np.zeros(5, int)
        for key, (world, m) in truth.items():
            if world == name:
                verdict = judge(found[key], m)
                counts += ([1, verdict == "wrong", 0, 0, 0] if m is None
                           else [0, 0, 1, verdict == "right", verdict == "wrong"])
        total += counts
        others, matches, true_pairs, right, wrong = total if name == "all" else counts
        print(f"{name:<18}{others:>8}{matches:>9}{true_pairs:>7}{right:>7}{wrong:>7}")
    return 1 if total[1] > 0 else 0


if __name__ == "__main__":
    raise SystemExit(main())
