#!/usr/bin/env bash
# How exact must the rig be? Experiment 1 of samples/experiments.sh with one number of rig.yaml wrong by 1, 2 and 5 %,
# as a Markdown table (compensation/README.md holds one).
#   samples/sensitivity.sh [OUTPUT_DIR]     default: samples/out/sensitivity
set -euo pipefail

# shellcheck source=samples/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
prepare "${1:-$root/samples/out/sensitivity}"
sample=$root/samples/lab-debris-1

# The sample's rig with one number ($1) times a factor ($2): a, d, h, or the focal length of camera up or forward.
wrong_rig() {
  awk -v what="$1" -v factor="$2" '
    /^[adh]:/ && what == substr($1, 1, 1) { sub(/[0-9.]+/, factor * $2) }
    /^  [a-z]+:$/ { camera = substr($1, 1, length($1) - 1) }
    # The mount of the forward camera stands d above the floor; the matrix says it once more.
    what == "d" && camera == "forward" && /translation:/ { $0 = "      translation: [0, 0, " factor * 0.45 "]" }
    what == "d" && camera == "forward" && /^      matrix:/ { next }
    /camera_matrix:/ && what == "f_" camera {
      match($0, /data: \[[0-9.]+/)
      focal = substr($0, RSTART + 7, RLENGTH - 7)
      gsub(focal, sprintf("%.6f", factor * focal))
    }
    { print }' "$sample/rig.yaml"
}

# `largest error along the path in cm, RMSE of pitch in degrees` of a method ($2) with a rig ($1).
measure() {
  local name=$2
  "$ceilmap" map --force --quiet --rig "$1" --up "$sample/up.mp4" --forward "$sample/forward.mp4" --stamps "$sample/frames.csv" \
    --tilt "$name" -o "$out/map.gpkg" --trajectory "$out/after.tum" --uncompensated "$out/before.tum"
  rm -rf "$out/report"
  "$ceilmap" evaluate --force --quiet --truth "$sample/truth.tum" --before "$out/before.tum" "$name=$out/after.tum" \
    -o "$out/report" >/dev/null
  awk -F, '
    NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    { printf "%.2f cm, %.3f deg", 100 * $column["along_m"], $column["pitch_rmse_deg"] }
  ' "$out/report/compensation.csv"
}

row() {
  local cells="| $1 |" cell method
  for method in matsumoto forward ceiling fused; do
    cell=$(measure "$2" "$method")
    cells+=" $cell |"
  done
  echo "$cells"
}

echo
echo '| wrong | matsumoto | forward | ceiling | fused |'
echo '|---|---|---|---|---|'
row 'nothing' "$sample/rig.yaml"
for what in a d h f_up f_forward; do
  for percent in 1 2 5; do
    wrong_rig "$what" "1.0$percent" >"$out/rig.yaml"
    row "$what, by $percent %" "$out/rig.yaml"
  done
done
