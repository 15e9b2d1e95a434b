#!/usr/bin/env bash
# Bags that are written by programs of others (Debian's python3-rosbag, @mcap/core, sqlite3) are read by app/bags, and each
# image is compared with OpenCV's conversion of its pixels: as grey and as BGR, bit by bit. Prints a table; exits with 1 when
# an image differs. Installs the packages of Node.js into a temporary folder.
#   tests/bags/foreign.sh             needs python3-rosbag, python3-sensor-msgs, python3-opencv, Node.js with npm, and
#                                     build/release/tests/bench/ceilmap_bags_bench
#   tests/bags/foreign.sh DIR         keeps the bags in DIR
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bench=$here/../../build/release/tests/bench/ceilmap_bags_bench
if [[ ! -x $bench ]]; then
  echo "foreign.sh: $bench is missing; run: cmake --build --preset release --target ceilmap_bags_bench" >&2
  exit 1
fi
if (($# > 0)); then
  mkdir -p "$1"
  folder=$(cd "$1" && pwd)
else
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
fi

python=/usr/bin/python3
cd "$folder"
cp "$here/foreign_mcap.mjs" .
npm install --silent --no-fund --no-audit --prefix . \
  @mcap/core@2 @foxglove/rosmsg@5 @foxglove/rosmsg2-serialization@3 @foxglove/wasm-zstd@1 lz4js@0.2 >npm.log 2>&1 ||
  { cat npm.log >&2; exit 1; }
$python "$here/foreign_images.py" images .

containers=()
# Container, file: writes it, and keeps its name.
add() { containers+=("$1"); }
for compression in none zstd lz4; do
  node foreign_mcap.mjs . "mcap-$compression" $compression
  add "mcap-$compression"
done
node foreign_mcap.mjs . mcap-loose none loose && add mcap-loose
node foreign_mcap.mjs . mcap-unindexed zstd unindexed && add mcap-unindexed
for compression in none lz4 bz2; do
  $python "$here/foreign_images.py" ros1 . "ros1-$compression" $compression
  add "ros1-$compression"
done
rm -f db3
$python "$here/foreign_images.py" rosbag2 . db3 && add db3

bad=0
printf '%-14s' encoding
printf ' %-14s' "${containers[@]}"
printf '\n'
for container in "${containers[@]}"; do
  "$bench" checksums "$container" >"read-$container.txt" || bad=1
done
for encoding in $(cut -d/ -f2 expected.txt | awk '!seen[$0]++'); do
  printf '%-14s' "$encoding"
  for container in "${containers[@]}"; do
    # A topic is "/ENCODING/...".
    if diff -q <(grep "^/$encoding/" expected.txt) <(grep "^/$encoding/" "read-$container.txt") >/dev/null; then
      printf ' %-14s' identical
    else
      printf ' %-14s' DIFFERENT
      bad=1
    fi
  done
  printf '\n'
done
images=$(wc -l <expected.txt)
echo "$images images in each of ${#containers[@]} bags"
exit $bad
