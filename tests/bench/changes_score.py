#!/usr/bin/env python3
"""Scores changes found on a ceiling against the schedule of simulated sessions.

  changes_score.py --map MAP_RUN MAP.tum --found FOUND.csv [--grace N] [--optional DETAIL,...] RUN...

MAP_RUN, RUN: folders of `ceilmap simulate`: that of the map, and those that updated it, in their order. The schedule is
changes.csv of the last RUN; truth.tum and rig.yaml of all tell what the robots have seen.
MAP.tum: the trajectory of the map; its rigid fit to truth.tum of MAP_RUN brings found polygons into the world.
FOUND.csv, in the map's coordinates, metres: kind,first_session,last_session and either min_x,min_y,max_x,max_y or wkt
(POLYGON or MULTIPOLYGON, even-odd). Sessions are numbers of `simulate --session`, or empty.
--grace N: changes of the last N runs need not be found. --optional: details of changes.csv that need not be found.

A scheduled change counts with the area that a robot has seen while it showed. It is found when at least half of that area
is found; a found polygon is right when at least half of it lies on scheduled changes of any kind up to its last session.
Areas on a grid of 5 cm. Prints one JSON object. Needs Debian's python3, python3-numpy and python3-yaml.
"""
import argparse
import csv
import json
import pathlib
import re
import sys

import numpy as np
import yaml

CELL = 0.05  # m
LEAST = 0.05  # m^2 seen of a change that counts


def read_tum(path):
    return np.loadtxt(path, ndmin=2)


def yaws(poses):
    x, y, z, w = poses[:, 4:8].T
    return np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def rigid_fit(estimate, truth):
    """R, t with world = R map + t, by least squares over the common stamps (to 1 ms)."""
    nearest = np.abs(truth[:, :1] - estimate[:, 0]).argmin(0)
    common = np.abs(truth[nearest, 0] - estimate[:, 0]) < 1e-3
    if common.sum() < 2:
        sys.exit("changes_score.py: the trajectory and the truth of the map have no stamps in common")
    p, q = estimate[common, 1:3], truth[nearest[common], 1:3]
    s, d = p - p.mean(0), q - q.mean(0)
    a = np.arctan2((s[:, 0] * d[:, 1] - s[:, 1] * d[:, 0]).sum(), (s * d).sum())
    r = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return r, q.mean(0) - r @ p.mean(0)


class Grid:
    def __init__(self, low, high):
        self.low = np.floor(np.asarray(low) / CELL) * CELL
        self.shape = tuple(np.ceil((np.asarray(high) - self.low) / CELL).astype(int)[::-1] + 1)

    def fill(self, rings):
        """Cells whose centres lie inside of the rings (even-odd)."""
        mask = np.zeros(self.shape, bool)
        rings = [(np.asarray(r, float) - self.low) / CELL - 0.5 for r in rings]
        points = np.vstack(rings)
        first, last = max(0, int(np.ceil(points[:, 1].min()))), min(self.shape[0] - 1, int(points[:, 1].max()))
        for row in range(first, last + 1):
            cuts = []
            for ring in rings:
                a, b = ring, np.roll(ring, -1, 0)
                hit = (a[:, 1] <= row) != (b[:, 1] <= row)
                a, b = a[hit], b[hit]
                cuts += list(a[:, 0] + (row - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1]))
            cuts = np.clip(np.ceil(np.sort(cuts)), 0, self.shape[1]).astype(int)
            for start, end in zip(cuts[::2], cuts[1::2]):
                mask[row, start:end] ^= True
        return mask


    def window(self, box):
        """Slices of the cells whose centres lie inside of a rectangle along the axes."""
        low, high = ((np.asarray(b) - self.low) / CELL - 0.5 for b in (box.min(0), box.max(0)))
        first = np.maximum(0, np.ceil(low)).astype(int)
        end = np.clip(np.ceil(high), first, self.shape[::-1]).astype(int)
        return slice(first[1], end[1]), slice(first[0], end[0])


def rectangle(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


def seen_by(run, grid):
    """What the camera of a run has seen of the ceiling, without the outer 5 % of its images."""
    rig = yaml.safe_load((run / "rig.yaml").read_text())
    up = rig["cameras"]["up"]
    k = np.array(up["camera_matrix"]["data"]).reshape(3, 3)
    pose = np.array(up["base_link_to_camera"]["matrix"]).reshape(4, 4)
    w, h = up["image_width"], up["image_height"]
    corners = rectangle(0.05 * w, 0.05 * h, 0.95 * w, 0.95 * h)
    rays = np.column_stack([(corners - k[:2, 2]) / k[[0, 1], [0, 1]], np.ones(4)]) @ pose[:3, :3].T
    at_base = pose[:2, 3] + (rig["h"] - pose[2, 3]) * rays[:, :2] / rays[:, 2:]
    mask = np.zeros(grid.shape, bool)
    poses = read_tum(run / "truth.tum")
    for position, yaw in zip(poses[:, 1:3], yaws(poses)):
        r = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        mask |= grid.fill([at_base @ r.T + position])
    return mask


def read_schedule(run):
    with open(run / "changes.csv", newline="") as f:
        return [{**row, "session": int(row["session"]),
                 "box": rectangle(*(float(row[k]) for k in ("x_min", "y_min", "x_max", "y_max")))}
                for row in csv.DictReader(f)]


def session_of(run):
    match = re.search(r"^session: (\d+)", (run / "scene.yaml").read_text(), re.M)
    return int(match.group(1)) if match else 0


def read_found(path):
    with open(path, newline="") as f:
        for row in csv.DictReader(f):
            if row.get("wkt"):
                rings = [[tuple(map(float, p.split()[:2])) for p in ring.split(",")]
                         for ring in re.findall(r"\(([^()]+)\)", row["wkt"])]
            else:
                rings = [rectangle(*(float(row[k]) for k in ("min_x", "min_y", "max_x", "max_y")))]
            yield row, rings


def ratio(a, b):
    return float(a / b) if b > 0 else None


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--map", nargs=2, type=pathlib.Path, required=True, metavar=("MAP_RUN", "MAP.tum"))
    p.add_argument("--found", type=pathlib.Path, required=True)
    p.add_argument("--grace", type=int, default=0)
    p.add_argument("--optional", default="", help="details, e.g. switched_off,switched_on")
    p.add_argument("runs", nargs="+", type=pathlib.Path)
    a = p.parse_args()

    built = session_of(a.map[0])
    runs = {session_of(run): run for run in a.runs}
    schedule = [c for c in read_schedule(a.runs[-1]) if c["session"] > built]
    r, t = rigid_fit(read_tum(a.map[1]), read_tum(a.map[0] / "truth.tum"))
    found = [(row, [np.asarray(ring) @ r.T + t for ring in rings]) for row, rings in read_found(a.found)]

    corners = np.vstack([c["box"] for c in schedule] + [ring for _, rings in found for ring in rings] + [[(0, 0)]])
    grid = Grid(corners.min(0) - 1, corners.max(0) + 1)
    seen = {n: seen_by(run, grid) for n, run in runs.items()}
    seen_ever = np.logical_or.reduce(list(seen.values())) | seen_by(a.map[0], grid)
    found_masks = [grid.fill(rings) for _, rings in found]
    found_all = np.logical_or.reduce(found_masks) if found else np.zeros(grid.shape, bool)
    boxes = [grid.window(c["box"]) for c in schedule]

    last_needed = sorted(runs)[-1 - a.grace] if a.grace < len(runs) else -1
    by_kind, needed_all = {}, np.zeros(grid.shape, bool)
    for i, change in enumerate(schedule):
        if change["session"] > last_needed or change["detail"] in a.optional.split(","):
            continue
        shown = np.zeros(grid.shape, bool)[boxes[i]]
        for n in (n for n in sorted(runs) if n >= change["session"]):
            shows = seen[n][boxes[i]].copy()
            for later in (j for j in range(i + 1, len(schedule)) if schedule[j]["session"] <= n):
                hidden = [slice(max(0, x.start - y.start), max(0, x.stop - y.start))
                          for x, y in zip(boxes[later], boxes[i])]
                shows[tuple(hidden)] = False
            shown |= shows
        if shown.sum() * CELL**2 < LEAST:
            continue
        needed_all[boxes[i]] |= shown
        count = by_kind.setdefault(change["kind"], [0, 0])
        count[0] += int((shown & found_all[boxes[i]]).sum() >= 0.5 * shown.sum())
        count[1] += 1

    def scheduled(last):
        mask = np.zeros(grid.shape, bool)
        for box in (boxes[i] for i, c in enumerate(schedule) if c["session"] <= last):
            mask[box] = True
        return mask

    true = {n: scheduled(n) for n in {max(runs), *(int(row.get("last_session") or max(runs)) for row, _ in found)}}
    right = sum(int(mask.any() and (mask & true[int(row.get("last_session") or max(runs))]).sum() >= 0.5 * mask.sum())
                for (row, _), mask in zip(found, found_masks))
    truth_all = true[max(runs)]
    hits, total = (sum(v[i] for v in by_kind.values()) for i in (0, 1))
    print(json.dumps({
        "changes": total, "changes_found": hits, "recall": ratio(hits, total),
        "polygons": len(found), "polygons_right": right, "precision": ratio(right, len(found)),
        "area_recall": ratio((needed_all & found_all).sum(), needed_all.sum()),
        "area_precision": ratio((truth_all & found_all).sum(), found_all.sum()),
        "area_scheduled_m2": float(needed_all.sum() * CELL**2), "area_found_m2": float(found_all.sum() * CELL**2),
        "area_seen_m2": float(seen_ever.sum() * CELL**2),
        "recall_by_kind": {k: ratio(*v) for k, v in sorted(by_kind.items())},
        "found_by_kind": {k: sum(row["kind"] == k for row, _ in found) for k in sorted({row["kind"] for row, _ in found})},
    }, indent=1))


if __name__ == "__main__":
    main()
