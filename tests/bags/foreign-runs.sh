#!/usr/bin/env bash
# `map` and `localize` over the same recording in bags of all kinds: an MCAP bag, and ROS 1 and rosbag2 bags that Debian's
# python3-rosbag and sqlite3 made of it. Prints a table; exits with 1 when a trajectory differs from that of the MCAP bag.
#   tests/bags/foreign-runs.sh RECORDING      a folder with rig.yaml, up.mp4, frames.csv and odometry.csv or truth.tum, as
#                                             `ceilmap simulate` writes it. Needs python3-rosbag, python3-sensor-msgs,
#                                             python3-nav-msgs, python3-tf2-msgs and the release build
set -euo pipefail

if (($# != 1)); then
  sed -n 's/^#   //p' "${BASH_SOURCE[0]}" >&2
  exit 2
fi
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$here/../../build/release
recording=$(cd "$1" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

convert="/usr/bin/python3 $here/convert_bag.py"
"$build/tests/integration/ceilmap_write_recording_bag" "$recording" run.mcap none
for compression in none lz4 bz2; do $convert ros1 run.mcap "ros1-$compression.bag" "$compression"; done
$convert rosbag2 run.mcap split
bags=(run.mcap ros1-none.bag ros1-lz4.bag ros1-bz2.bag split split/split_0.db3)

bad=0
for bag in "${bags[@]}"; do
  name=${bag//\//-}
  wheels=(--odometry "$bag" --odometry-topic /odom)
  "$build/app/ceilmap" map --rig "$recording/rig.yaml" --up "$bag" --up-topic /up/image_raw "${wheels[@]}" \
    -o "$name.gpkg" --trajectory "$name.tum" --quiet
  "$build/app/ceilmap" localize run.mcap.gpkg --rig "$recording/rig.yaml" --up "$bag" --up-topic /up/image_raw \
    "${wheels[@]}" -o "$name-located.tum" --quiet
  printf '%-20s' "$bag"
  for kind in .tum -located.tum; do
    poses=$(grep -vc '^#' "$name$kind")
    # The first file of a split bag is the beginning of the whole; what a map's end adds moves its poses.
    if [[ $bag == *_0.db3 ]]; then
      printf ' %6d poses of the beginning' "$poses"
    elif cmp -s "$name$kind" "run.mcap$kind"; then
      printf ' %6d poses, identical' "$poses"
    else
      printf ' %6d poses, DIFFERENT' "$poses"
      bad=1
    fi
  done
  printf '\n'
done
exit $bad
