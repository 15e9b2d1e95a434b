#!/usr/bin/env bash
# Installs what is missing, builds ceilmap and maps the bundled recording: a map, a trajectory and a picture, scored.
#   samples/run.sh [OUTPUT_DIR]     default: samples/out
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out=${1:-$root/samples/out}
"$root/samples/install-deps.sh"
cd "$root"
cmake --preset release
cmake --build --preset release --target ceilmap
mkdir -p "$out"
out=$(cd "$out" && pwd)
ceilmap=$root/build/release/app/ceilmap
sample=$root/samples/lab-map

echo
echo "1. A ceiling map from the upward camera's video"
"$ceilmap" map --rig "$sample/rig.yaml" --up "$sample/up.mp4" --stamps "$sample/frames.csv" \
  -o "$out/lab.gpkg" --trajectory "$out/lab.tum" --picture "$out/lab.png" --summary "$out/lab.json"
echo
echo "2. What it scores against the exact truth (position after a planar alignment)"
"$ceilmap" evaluate --truth "$sample/truth.tum" map="$out/lab.tum"
echo
echo "The map         $out/lab.gpkg   (QGIS and GDAL open it; 'ceilmap info' describes it)"
echo "The trajectory  $out/lab.tum"
echo "The picture     $out/lab.png    (seen from above)"
