#!/usr/bin/env bash
# The two experiments of Matsumoto et al. 2010, "Visual compensation in localization of a robot on a ceiling map", on
# bundled recordings: a robot drives straight over debris. Prints the paper's table beside ours, and draws its figures.
# Then those of Labrosse 2006, a visual compass, by samples/compass-experiments.sh.
#   samples/experiments.sh [OUTPUT_DIR]     default: samples/out/experiments
set -euo pipefail

# shellcheck source=samples/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
prepare "${1:-$root/samples/out/experiments}" --plots
methods=(forward ceiling fused)

# The pose of the first, level line of a trajectory as X,Y,YAW_DEG: with it the map lies in the frame of the truth, and
# positions can be drawn on it.
first_pose() {
  awk '!/^#/ { printf "%.9f,%.9f,%.9f\n", $2, $3, 2 * atan2($7, $8) * 45 / atan2(1, 1); exit }' "$1"
}

# Maps a recording ($1) with each way of measuring tilt, into the folder $2.
map_recording() {
  local sample=$1 folder=$2 method
  for method in "${methods[@]}"; do
    echo "mapping $(basename "$sample") with --tilt $method"
    "$ceilmap" map --force --quiet --rig "$sample/rig.yaml" --up "$sample/up.mp4" --forward "$sample/forward.mp4" \
      --stamps "$sample/frames.csv" --origin "$(first_pose "$sample/truth.tum")" --tilt "$method" \
      -o "$folder/$method.gpkg" --trajectory "$folder/$method.tum" --uncompensated "$folder/$method-before.tum" \
      --picture "$folder/$method.png"
  done
}

# The paper's table from the reports in a folder ($1). Of the paper's own figures only these are known here.
print_table() {
  local row='%-22s %11s %11s %10s   %11s %11s %10s\n'
  printf '%-22s %34s   %34s\n' '' 'x, along the path' 'y, across the path'
  # shellcheck disable=SC2059
  printf "$row" 'largest error' 'before cm' 'after cm' 'ratio' 'before cm' 'after cm' 'ratio'
  # shellcheck disable=SC2059
  printf "$row" 'Matsumoto et al. 2010' 'about 21' '-' 'about 0.11' '-' '-' '-'
  awk -F, 'FNR > 1 {
    printf "%-22s %11.2f %11.2f %10.3f   %11.2f %11.2f %10.3f\n", $1, 100 * $2, 100 * $3, $4, 100 * $5, 100 * $6, $7
  }' "$1"/report-{forward,ceiling,fused}/compensation.csv
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

# The figures in a folder ($1).
draw() {
  gnuplot -e "folder = '$1'; $(mosaic_place "$1/fused.gpkg")" "$root/samples/experiments.gp"
}

# Each method against the same run without it: a run's poses before and after compensation share one map, and so one way
# of aligning them with the truth.
evaluate() {
  local sample=$1 folder=$2 method
  : >"$folder/evaluation.txt"
  for method in "${methods[@]}"; do
    rm -rf "$folder/report-$method"
    "$ceilmap" evaluate --force --truth "$sample/truth.tum" --before "$folder/$method-before.tum" \
      "$method=$folder/$method.tum" -o "$folder/report-$method" >>"$folder/evaluation.txt"
    echo >>"$folder/evaluation.txt"
  done
}

experiment() {
  local number=$1 what=$2 sample=$root/samples/lab-debris-$1 folder=$out/experiment-$1
  echo
  echo "Experiment $number: $what"
  mkdir -p "$folder"
  map_recording "$sample" "$folder"
  evaluate "$sample" "$folder"
  echo
  print_table "$folder"
  draw "$folder"
}

experiment 1 "the front wheels climb debris, four times"
experiment 2 "the front wheels climb debris, and the wheels of either side"

echo
echo "The paper reports about 21 cm brought down to about 11 % of it, set here beside x of both experiments."
echo "Experiment 1 has no roll: across the path there is no error before, so its ratio there has no meaning."
echo "evaluation.txt in the folders below has errors of the estimated tilt, report-*/*-errors.csv those of each frame."
for number in 1 2; do
  echo
  echo "Experiment $number"
  for figure in positions errors tilt; do
    for format in svg png; do echo "  $out/experiment-$number/$figure.$format"; done
  done
done

"$root/samples/compass-experiments.sh" "$out"
