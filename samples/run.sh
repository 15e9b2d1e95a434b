#!/usr/bin/env bash
# Installs what is missing, builds ceilmap, maps a bundled recording, finds a second robot on the map, takes debris
# out of a third drive, and measures how a fourth one turns; all scored, and in a report to look at.
#   samples/run.sh [OUTPUT_DIR]     default: samples/out
set -euo pipefail

# shellcheck source=samples/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
prepare "${1:-$root/samples/out}" --plots
sample=$root/samples/lab-map
report=$out/report
rm -rf "$report"
mkdir "$report"

echo
echo "1. A ceiling map from the upward camera's video"
"$ceilmap" map --force --rig "$sample/rig.yaml" --up "$sample/up.mp4" --stamps "$sample/frames.csv" \
  -o "$out/lab.gpkg" --trajectory "$out/lab.tum" --picture "$out/lab.png" --summary "$out/lab.json" \
  --report "$report/map-run"
echo
echo "2. What it scores against the exact truth (position after a planar alignment)"
"$ceilmap" evaluate --force --truth "$sample/truth.tum" map="$out/lab.tum" --map "$out/lab.gpkg" -o "$report/map"
echo
echo "3. Another robot, with another camera on another day, switched on anywhere on that map"
second=$root/samples/lab-second-robot
"$ceilmap" localize --force "$out/lab.gpkg" --rig "$second/rig.yaml" --up "$second/up.mp4" \
  --stamps "$second/frames.csv" -o "$out/second.tum" --status "$out/second.csv" --report "$report/second-run"
echo
echo "4. What that scores"
"$ceilmap" evaluate --force --truth "$second/truth.tum" --frame-from "$sample/truth.tum" "$out/lab.tum" \
  second="$out/second.csv" --map "$out/lab.gpkg" -o "$report/second"
echo
echo "5. A drive over debris: every frame taken as level, then the tilt measured by forward camera and ceiling, and taken out"
debris=$root/samples/lab-debris-1
map_debris() {  # NAME [OPTION...]
  "$ceilmap" map --force --rig "$debris/rig.yaml" --up "$debris/up.mp4" --forward "$debris/forward.mp4" \
    --stamps "$debris/frames.csv" -o "$out/$1.gpkg" --trajectory "$out/$1.tum" "${@:2}"
}
map_debris debris-level --tilt none --quiet
map_debris debris
echo
echo "6. What both score (samples/experiments.sh has the whole of it)"
"$ceilmap" evaluate --force --truth "$debris/truth.tum" --before "$out/debris-level.tum" --before-own-run \
  debris="$out/debris.tum" --map "$out/debris.gpkg" -o "$report/debris"
echo
echo "7. How a robot turns, by a camera under a convex mirror, and what that scores (samples/compass-experiments.sh has more)"
omni=$root/samples/lab-omni-circle
"$ceilmap" heading --force --rig "$omni/rig.yaml" --omni "$omni/omni.mp4" --stamps "$omni/frames.csv" \
  --truth "$omni/truth.tum" -o "$out/heading.csv" --plot "$report/heading-run"
"$ceilmap" evaluate --force --truth "$omni/truth.tum" compass="$out/heading.csv" -o "$report/heading" --quiet
cp "$root/samples/report.html" "$report/index.html"
echo
echo "The map         $out/lab.gpkg   (QGIS and GDAL open it; 'ceilmap info' describes it)"
echo "The trajectory  $out/lab.tum"
echo "The second one  $out/second.tum, and its status frame by frame in second.csv"
echo "The headings    $out/heading.csv"
echo "The picture     $out/lab.png    (seen from above)"
echo "The report      $report/index.html   (all of this to look at, in a browser)"
