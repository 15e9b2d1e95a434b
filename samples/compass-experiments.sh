#!/usr/bin/env bash
# The experiments of Labrosse 2006 (the paper's Table 3), a visual compass from a camera under a convex mirror, on bundled
# recordings: a circle and a straight line. Prints the paper's indoor figures beside ours, and draws those of fft.
#   samples/compass-experiments.sh [OUTPUT_DIR]     default: samples/out/experiments
set -euo pipefail

# shellcheck source=samples/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
prepare "${1:-$root/samples/out/experiments}" --plots
row='%-24s %9s %8s %8s %11s %11s %8s\n'

# Headings of a recording ($1) into FOLDER/NAME.csv, their errors into FOLDER/NAME.json ($2); the rest are options.
measure() {
  local sample=$1 result=$2
  shift 2
  "$ceilmap" heading --force --quiet --rig "$sample/rig.yaml" --omni "$sample/omni.mp4" --stamps "$sample/frames.csv" \
    --truth "$sample/truth.tum" -o "$result.csv" --summary "$result.json" "$@"
}

# All methods on a recording ($1), into a folder ($2). Labrosse unwraps with rows even in radius.
measure_all() {
  local sample=$1 folder=$2 skip
  local paper=(--method labrosse2006 --row-spacing radius)
  for skip in {0..6}; do
    measure "$sample" "$folder/fx-$skip" "${paper[@]}" --skip "$skip"
  done
  measure "$sample" "$folder/atm" "${paper[@]}" --threshold 0.6055
  measure "$sample" "$folder/fft" --plot "$folder"
}

# A number by its key ($2) from a summary ($1), where each key stands on a line of its own.
number() {
  awk -v key="\"$2\":" '$1 == key { sub(/,$/, "", $2); print $2; found = 1 } END { exit !found }' "$1"
}

# The n of the Fx n with the least largest error, from the summaries in a folder ($1).
best_skip() {
  local skip
  for skip in {0..6}; do
    echo "$skip $(number "$1/fx-$skip.json" max)"
  done | awk 'NR == 1 || $2 < least { least = $2; best = $1 } END { print best }'
}

# A row of the table, called $1, from a summary ($2).
print_row() {
  local cells=() key
  for key in max rmse end_deg drift_deg_per_m drift_deg_per_s; do
    cells+=("$(number "$2" "$key" | awk '{ if ($1 == "null") print "-"; else printf "%.3f", $1 }')")
  done
  # shellcheck disable=SC2059
  printf "$row" "$1" "${cells[@]}" "$(number "$2" matched)"
}

# The table from a folder ($1), below what the paper says of such a drive: its largest error ($2) and drift a metre ($3).
print_table() {
  local best
  best=$(best_skip "$1")
  # shellcheck disable=SC2059
  printf "$row" '' 'max deg' 'RMS deg' 'end deg' 'drift deg/m' 'drift deg/s' 'frames'
  # shellcheck disable=SC2059
  printf "$row" 'Labrosse 2006, indoors' "$2" '-' '-' "$3" '-' '-'
  print_row "Fx $best" "$1/fx-$best.json"
  print_row 'Atm 0.6' "$1/atm.json"
  print_row 'fft' "$1/fft.json"
}

experiment() {
  local name=$1 what=$2 paper_max=$3 paper_drift=$4 folder=$out/compass-$1
  echo
  echo "Compass, $name: $what"
  mkdir -p "$folder"
  measure_all "$root/samples/lab-omni-$name" "$folder"
  print_table "$folder" "$paper_max" "$paper_drift"
}

experiment circle "once around, 1 m radius" "<= 6.9" "<= 0.213"
experiment straight "5 m without a turn" "<= 6.9" "-"

echo
echo "Of the paper: indoors at most 6.9 deg error, drift at most 0.213 deg/m on circles (CIRCLE2), Table 3; '-': not known here."
echo "Fx n is the best n of 0 to 6 on that recording, known only with the truth; frames are those that have a heading."
echo
for name in circle straight; do
  for figure in "$out/compass-$name"/*.{svg,png}; do echo "  $figure"; done
done
