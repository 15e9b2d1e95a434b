#!/usr/bin/env bash
# The two experiments of Matsumoto et al. 2010, "Visual compensation in localization of a robot on a ceiling map", on
# bundled recordings: a robot drives straight over debris. It maps its drive, and it is localized on the ceiling map that
# lab-map made, with five ways of measuring tilt. Prints the paper's table beside ours, writes it to matsumoto.csv, and
# draws the figures.
#   samples/experiments.sh [OUTPUT_DIR]     default: samples/out/experiments
set -euo pipefail

# shellcheck source=samples/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
prepare "${1:-$root/samples/out/experiments}" --plots
lab=$root/samples/lab-map
# none takes every frame as level: the error before compensation is that of a run of its own.
methods=(none matsumoto forward ceiling fused)

# The pose of the first, level line of a trajectory as X,Y,YAW_DEG: with it the map lies in the frame of the truth, and
# positions can be drawn on it.
first_pose() {
  awk '!/^#/ { printf "%.9f,%.9f,%.9f\n", $2, $3, 2 * atan2($7, $8) * 45 / atan2(1, 1); exit }' "$1"
}

# The ceiling map of the room, by a robot on a level floor.
map_lab() {
  echo
  echo "mapping lab-map"
  "$ceilmap" map --force --quiet --rig "$lab/rig.yaml" --up "$lab/up.mp4" --stamps "$lab/frames.csv" \
    --origin "$(first_pose "$lab/truth.tum")" -o "$out/lab.gpkg" --trajectory "$out/lab.tum" --picture "$out/lab.png"
}

# The drive of a recording ($1) with a method ($3) into the folder $2: as a map, and on the map of the room.
run_mapping() {
  "$ceilmap" map --force --quiet --rig "$1/rig.yaml" --up "$1/up.mp4" --forward "$1/forward.mp4" \
    --stamps "$1/frames.csv" --origin "$(first_pose "$1/truth.tum")" --tilt "$3" \
    -o "$2/$3.gpkg" --trajectory "$2/$3.tum" --picture "$2/$3.png"
}
run_localization() {
  "$ceilmap" localize --force --quiet "$out/lab.gpkg" --rig "$1/rig.yaml" --up "$1/up.mp4" --forward "$1/forward.mp4" \
    --stamps "$1/frames.csv" --tilt "$3" -o "$2/$3.tum"
}

# All methods ($3...: options for the alignment) against the truth of a recording ($1) and the run without compensation. A
# map has a frame of its own: each is aligned by its level frames. Robots on one map share the alignment of that map.
evaluate() {
  local sample=$1 folder=$2 method estimates=()
  for method in "${methods[@]}"; do estimates+=("$method=$folder/$method.tum"); done
  rm -rf "$folder/report"
  "$ceilmap" evaluate --force --truth "$sample/truth.tum" --before "$folder/none.tum" "${@:3}" "${estimates[@]}" \
    -o "$folder/report" >"$folder/evaluation.txt"
}

# The paper's rows, as its text has them: experiment 1 "reduced from 21 to 2 cm", "9.52%"; experiment 2 "from 17 to 2 cm
# and from 9 to 1 cm respectively", "11.76 and 11.11%".
row='%-24s %8s %8s   %8s %8s   %8s\n'
paper_rows() {
  # shellcheck disable=SC2059
  case $1 in
    1)
      printf "$row" 'Matsumoto 2010, before' 21 '' '' '' ''
      printf "$row" 'Matsumoto 2010, after' 2 '9.52 %' '' '' ''
      ;;
    2)
      printf "$row" 'Matsumoto 2010, before' 17 '' 9 '' ''
      printf "$row" 'Matsumoto 2010, after' 2 '11.76 %' 1 '11.11 %' ''
      ;;
  esac
}

# The table of a task ($2) from the report in a folder ($3), and its lines in matsumoto.csv. The paper has one task: it
# plots the positions on the ceiling map. Without roll there is no error across the path to be reduced, and no ratio.
print_table() {
  local experiment=$1 task=$2 folder=$3
  echo
  echo "Experiment $experiment, $task: largest error along and across the path, and its ratio to the error with none"
  # shellcheck disable=SC2059
  printf "$row" '' 'along cm' 'ratio' 'across cm' 'ratio' 'frames'
  paper_rows "$experiment"
  awk -F, -v experiment="$experiment" -v task="$task" -v csv="$out/matsumoto.csv" -v row="$row" '
    FNR == 1 { split("", column); for (i = 1; i <= NF; ++i) column[$i] = i; next }
    NR == FNR { placed[$column["estimate"]] = $column["matched"]; all = $column["expected"]; next }
    {
      name = $column["estimate"]
      along = $column["along_m"]; across = $column["across_m"]; ratio = $column["along_ratio"]
      has_roll = $column["across_before_m"] > 0.01
      printf row, name, sprintf("%.2f", 100 * along), sprintf("%.2f %%", 100 * ratio), sprintf("%.2f", 100 * across),
        has_roll ? sprintf("%.2f %%", 100 * $column["across_ratio"]) : "", placed[name] "/" all
      printf "%s,%s,%s,%.6f,%.6f,%.6f,%d,%d\n", experiment, task, name, along, across, ratio, placed[name], all >>csv
    }' "$folder/report/estimates.csv" "$folder/report/compensation.csv"
}

# The errors of the estimated tilt, from the report in a folder ($2).
print_tilt() {
  echo
  echo "Experiment $1: error of pitch and roll in degrees, RMSE and largest"
  awk -F, '
    NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    $column["estimate"] != "none" {
      printf "%-24s pitch %6.3f %6.3f   roll %6.3f %6.3f\n", $column["estimate"], $column["pitch_rmse_deg"],
        $column["pitch_max_deg"], $column["roll_rmse_deg"], $column["roll_max_deg"]
    }' "$2/report/compensation.csv"
}

# Where a map ($1) has its mosaic, as settings for gnuplot: the centre of its lower left pixel, and a pixel's size.
mosaic_place() {
  "$ceilmap" info --json "$1" | awk -F'[:,]' '
    /"grid"/ { grid = 1 }
    grid && /"(min_x|max_y|resolution|height_px)"/ { gsub(/[" ]/, "", $1); value[$1] = $2 }
    grid && /}/ { exit }
    END {
      size = value["resolution"]
      printf "mosaic_x = %.9f; mosaic_y = %.9f; mosaic_pixel = %.9f", value["min_x"] + size / 2,
        value["max_y"] - (value["height_px"] - 0.5) * size, size
    }'
}

# The figures of a folder ($1) over the mosaic of a map ($2, without its extension).
draw() {
  gnuplot -e "folder = '$1'; mosaic = '$2.png'; $(mosaic_place "$2.gpkg")" "$root/samples/experiments.gp"
}

experiment() {
  local number=$1 what=$2 sample=$root/samples/lab-debris-$1 folder=$out/experiment-$1 method
  echo
  echo "Experiment $number: $what"
  mkdir -p "$folder/mapping" "$folder/localization"
  for method in "${methods[@]}"; do
    echo "mapping lab-debris-$number, and localizing it on the map of lab-map, with --tilt $method"
    run_mapping "$sample" "$folder/mapping" "$method"
    run_localization "$sample" "$folder/localization" "$method"
  done
  evaluate "$sample" "$folder/mapping" --before-own-run
  evaluate "$sample" "$folder/localization" --frame-from "$lab/truth.tum" "$out/lab.tum"
  print_table "$number" mapping "$folder/mapping"
  print_table "$number" localization "$folder/localization"
  print_tilt "$number" "$folder/mapping"
  draw "$folder/mapping" "$folder/mapping/fused"
  draw "$folder/localization" "$out/lab"
}

echo 'experiment,task,method,max_along_m,max_across_m,ratio,frames_placed,frames' >"$out/matsumoto.csv"
map_lab
experiment 1 "the front wheels climb debris, four times"
experiment 2 "the front wheels climb debris, and the wheels of either side"

echo
echo "These recordings are ray-traced and their calibration is exact: the ratios are not those of a real robot."
echo "Experiment 1 has no roll: there is no error across the path to be reduced."
echo "  $out/matsumoto.csv   the figures of all tables; ratio: along the path"
echo "  $out/experiment-*/*/evaluation.txt   more figures; report/*-errors.csv those of each frame"
for figure in positions errors tilt; do echo "  $out/experiment-*/*/$figure.svg and .png"; done
