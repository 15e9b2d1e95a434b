#!/usr/bin/env bash
# Reads MCAP files of ceilmap with the readers of its authors (npm: @mcap/core, @foxglove/rosmsg2-serialization): structure,
# every CRC, index, embedded definitions, and the value of each field.
#   tests/bags/validate-mcap.sh [BUILD_DIR]     default: build/release; needs node, npm and the network
# The npm packages go to a temporary folder, or to $CEILMAP_NPM where they stay.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
build=${1:-build/release}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
npm_folder=${CEILMAP_NPM:-$work/npm}

mkdir -p "$npm_folder"
(cd "$npm_folder" && npm install --no-audit --no-fund --silent --no-save @mcap/core@2 @foxglove/rosmsg@5 \
  @foxglove/rosmsg2-serialization@3 @foxglove/rosmsg-msgs-common@3 @foxglove/wasm-zstd@1 @foxglove/wasm-lz4@1)
cp tests/bags/validate-mcap.mjs "$npm_folder/"

for compression in none zstd lz4; do
  "$build/tests/app/bags/ceilmap_write_bag" "$work/all-$compression.mcap" "$compression"
  node "$npm_folder/validate-mcap.mjs" messages "$work/all-$compression.mcap"
done

# Bags of the commands beside their text files.
ceilmap=$PWD/$build/app/ceilmap
data=$PWD/samples/lab-map
cd "$work"
map() { "$ceilmap" map --quiet --force --rig "$data/rig.yaml" --up "$data/up.mp4" --stamps "$data/frames.csv" "$@"; }
map -o lab.gpkg --trajectory mapped.mcap
map -o lab.gpkg --trajectory mapped.tum
node "$npm_folder/validate-mcap.mjs" mapped mapped.mcap mapped.tum

locate() {
  "$ceilmap" localize lab.gpkg --quiet --force --up "$data/up.mp4" --stamps "$data/frames.csv" --status located.csv "$@"
}
locate -o located.mcap
locate -o located.tum
node "$npm_folder/validate-mcap.mjs" trajectory located.mcap located.tum located.csv

for format in mcap tum png; do "$ceilmap" export lab.gpkg --quiet --format "$format" -o "export.$format"; done
gdal_translate -q -of PNM -b 1 export.png export.pgm
node "$npm_folder/validate-mcap.mjs" map export.mcap export.tum export.pgm
