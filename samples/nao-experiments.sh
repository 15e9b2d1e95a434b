#!/usr/bin/env bash
# The ViCTORiA compass on pictures of real NAO robots with a coarse truth.
#   samples/nao-experiments.sh REAL [OUTPUT_DIR]     default: samples/out/nao
# REAL has nao-wander (github.com/davesnowdon/nao-datasets, folder 2013062102: turns in a canteen, poses by odometry) and
# nao-uva (github.com/physar/landmark_based_slam_dataset, folder black1: five places of a football field, OptiTrack).
# Each picture is asked for by a model of the others of its turn: they overlap by a half to two thirds, and in single pictures
# nothing is known from before.
set -euo pipefail

# shellcheck source=samples/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
if (($# < 1)); then
  echo "nao-experiments.sh: say where nao-wander and nao-uva are: samples/nao-experiments.sh REAL [OUTPUT_DIR]" >&2
  exit 2
fi
real=$(cd "$1" && pwd)
prepare "${2:-$root/samples/out/nao}"

# A rig with a forward camera only: WIDTH HEIGHT FOCAL_PX PITCH_UP_DEG HEIGHT_M.
rig() {
  awk -v w="$1" -v h="$2" -v f="$3" -v up="$4" -v z="$5" 'BEGIN {
    s = sin(up * atan2(0, -1) / 180); c = cos(up * atan2(0, -1) / 180)
    print "robot: nao\na: 0.05\nd: " z "\nh: 2.6\nframes: {map: map, base: base_link}\ncameras:\n  forward:"
    print "    type: pinhole\n    image_width: " w "\n    image_height: " h "\n    camera_name: forward"
    printf "    camera_matrix: {rows: 3, cols: 3, data: [%g, 0, %g, 0, %g, %g, 0, 0, 1]}\n", f, (w - 1) / 2, f, (h - 1) / 2
    print "    distortion_model: plumb_bob\n    distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}"
    printf "    base_link_to_camera:\n      frame: forward_optical_frame\n"
    printf "      matrix: [0, %.9f, %.9f, 0, -1, 0, 0, 0, 0, %.9f, %.9f, %g, 0, 0, 0, 1]\n", s, c, -c, s, z
  }'
}

# A line of a trajectory: STAMP X Y YAW, and the pitch of the head (nose up).
pose() { awk -v t="$1" -v x="$2" -v y="$3" -v yaw="$4" -v up="${5:-0}" 'BEGIN {
  # R = Rz(yaw) Ry(-up)
  cy = cos(yaw / 2); sy = sin(yaw / 2); cp = cos(-up / 2); sp = sin(-up / 2)
  printf "%.6f %.6f %.6f 0 %.9f %.9f %.9f %.9f\n", t, x, y, -sy * sp, cy * sp, sy * cp, cy * cp }'; }

# Learns from all pictures ($out/$1/*.jpg with $out/$1/poses.tum) but one, asks for that one; prints a row for each. The rest are
# options of learning and asking.
leave_one_out() {
  local folder=$out/$1 count i row
  count=$(wc -l <"$folder/poses.tum")
  for ((i = 0; i < count; ++i)); do
    rm -rf "$folder/one" "$folder/others"
    mkdir "$folder/one" "$folder/others"
    local others=()
    for ((row = 0; row < count; ++row)); do ((row == i)) || others+=("$row"); done
    for row in "${others[@]}"; do cp "$folder/$(printf '%03d' "$row").jpg" "$folder/others/"; done
    cp "$folder/$(printf '%03d' "$i").jpg" "$folder/one/"
    { echo index,timestamp; awk -v no=$((i + 1)) 'NR != no { print count++ "," $1 }' "$folder/poses.tum"; } >"$folder/others.csv"
    { echo index,timestamp; awk -v no=$((i + 1)) 'NR == no { print "0," $1 }' "$folder/poses.tum"; } >"$folder/one.csv"
    "$ceilmap" compass learn --force --quiet --rig "$folder/rig.yaml" --forward "$folder/others" --stamps "$folder/others.csv" \
      --poses "$folder/poses.tum" -o "$folder/model.colours" "${@:2}"
    "$ceilmap" compass query --force --quiet "$folder/model.colours" --rig "$folder/rig.yaml" --forward "$folder/one" \
      --stamps "$folder/one.csv" --poses "$folder/poses.tum" --truth "$folder/poses.tum" -o "$folder/one-heading.csv" "${@:2}"
    printf '%s,' "$(sed -n "$((i + 1))p" "$folder/names.txt")"
    tail -n 1 "$folder/one-heading.csv"
  done >"$folder/headings.csv"
  awk -F, -v name="$1" '{
      error = $7 < 0 ? -$7 : $7; sum += error; if ($5 >= 0.9) { ++sure; sure_sum += error }
      if (error <= 45) ++quadrant
      printf "%-14s %10.1f %8.1f %9.1f %10.2f %8.1f\n", $1, $3, $4, $6, $5, $7
    }
    END {
      printf "%s: mean error %.2f rad of %d, %d within 45 deg; %d certain", name, sum / NR * atan2(0, -1) / 180, NR, quadrant, sure
      if (sure) printf ": mean error %.2f rad", sure_sum / sure * atan2(0, -1) / 180
      print ""
    }' "$folder/headings.csv"
}

# Pictures of nao-wander by their numbers ($2 ...) as the turn $1.
wander() {
  local folder=$out/$1 number count=0
  mkdir -p "$folder"
  : >"$folder/poses.tum"
  : >"$folder/names.txt"
  rig 1280 960 1087 15 0.45 >"$folder/rig.yaml"    # 61 deg wide; the head is raised, by the cupboards' lines about 15 deg
  for number in "${@:2}"; do
    cp "$real/nao-wander/20130621-02-$number.jpg" "$folder/$(printf '%03d' "$count").jpg"
    echo "picture-$number" >>"$folder/names.txt"
    read -r x y yaw < <(sed 's/.*"position": \[\([^]]*\)\].*/\1/; s/,//g' "$real/nao-wander/20130621-02-$number.json" |
      awk '{ print $1, $2, $6 }')
    pose "$count" "$x" "$y" "$yaw" >>"$folder/poses.tum"
    count=$((count + 1))
  done
}

# The five places of nao-uva: nominal places and headings, the head's pitch as recorded.
uva() {
  local folder=$out/$1 place x y yaw down count=0
  mkdir -p "$folder"
  : >"$folder/poses.tum"
  : >"$folder/names.txt"
  rig 640 480 597 -1.2 0.5 >"$folder/rig.yaml"    # NAO v6, upper camera: 56.3 deg wide, looks down by 1.2 deg
  while read -r place x y yaw; do
    cp "$real/nao-uva/black1/$place/imagetop.jpg" "$folder/$(printf '%03d' "$count").jpg"
    echo "$place" >>"$folder/names.txt"
    down=$(tail -n 1 "$real/nao-uva/black1/$place/record.csv" | tr -d '\r' | cut -d, -f3)
    turn=$(tail -n 1 "$real/nao-uva/black1/$place/record.csv" | tr -d '\r' | cut -d, -f5)
    pose "$count" "$x" "$y" "$(awk -v a="$yaw" -v b="$turn" 'BEGIN { print a * atan2(0, -1) / 180 + b }')" "-$down" \
      >>"$folder/poses.tum"
    count=$((count + 1))
  done <<'PLACES'
point1 1.30 1.20 -135
point2 2.70 0.00 180
point3 2.20 -1.50 135
point4 -1.60 -1.20 45
point5 -2.10 0.90 135
PLACES
}

printf '%-14s %10s %8s %9s %10s %8s   (deg)\n' picture heading sigma odometry confidence error
wander wander-a 18 20 25 22 23 24 26 27
leave_one_out wander-a
wander wander-b 165 166 167 168 169 170 171 172
leave_one_out wander-b
uva uva
echo
echo "nao-uva as asked for (60 % of each picture above the horizon):"
"$ceilmap" compass learn --force --rig "$out/uva/rig.yaml" --forward "$out/uva" --poses "$out/uva/poses.tum" -o "$out/uva/none.colours" ||
  true
echo "nao-uva with a fifth above the horizon:"
leave_one_out uva --min-above-horizon 0.2
