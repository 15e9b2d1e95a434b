#!/usr/bin/env bash
# The experiments of Labrosse 2004 and 2006, visual compasses from a camera under a convex mirror, on recordings like those of
# the papers (samples/scenes/papers, rendered into the output folder unless they are there) and on others. Prints the paper's
# tables 1, 3 and 4 beside ours and a table of all compasses; writes them as CSV, and draws headings and errors of fft.
#   samples/compass-experiments.sh [OUTPUT_DIR] [RECORDING...]     default: samples/out/experiments, all; some 20 minutes
set -euo pipefail

# shellcheck source=samples/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
prepare "${1:-$root/samples/out/experiments}" --plots
names=("${@:2}")
[[ ${#names[@]} -gt 0 ]] || names=(circle-1 circle-2 rotate-right straight-1 straight-2
  grass-1 grass-2 car-park pavement-straight grass-straight one-feature lab-omni-circle lab-omni-straight omni-rooms passing-car)

# The papers unwrap without calibration, about the middle of the image, with a row per pixel of radius; 2006 the nearest pixel,
# 2004 that ("not smooth") or between pixels ("smooth").
ring=(--ring 239.5,239.5,70,220 --row-spacing pixel)
nearest=("${ring[@]}" --interpolation nearest)
smooth=("${ring[@]}" --interpolation bilinear)

# Headings of a recording ($1) into $2.csv and figures about them into $2.json, beside others; the rest are options.
measure() {
  local folder=$1 result=$2
  shift 2
  while (($(jobs -rp | wc -l) >= $(nproc))); do wait -n; done
  "$ceilmap" heading --force --quiet --omni "$folder/omni.mp4" --stamps "$folder/frames.csv" --truth "$folder/truth.tum" \
    -o "$result.csv" --summary "$result.json" "$@" 2>"$result.log" || { cat "$result.log" >&2 && false; } &
}

# All methods on a recording in a folder ($1), into a folder ($2).
measure_all() {
  local folder=$1 skip
  mkdir -p "$2"
  for skip in {0..11}; do
    measure "$folder" "$2/fx-$skip" "${nearest[@]}" --method labrosse2006 --skip "$skip"
  done
  measure "$folder" "$2/atm" "${nearest[@]}" --method labrosse2006 --threshold 0.6055
  measure "$folder" "$2/probes" "${smooth[@]}" --method labrosse2006-probes
  measure "$folder" "$2/2004-not-smooth" "${nearest[@]}" --method labrosse2004
  measure "$folder" "$2/2004-smooth" "${smooth[@]}" --method labrosse2004
  measure "$folder" "$2/fft" --rig "$folder/rig.yaml" --plot "$2"
  if uneven "$folder"; then measure "$folder" "$2/fft-level" --rig "$folder/rig.yaml" --tilt "$folder/truth.tum"; fi
  wait
}

# Whether the ground of a recording ($1) tilts the robot: then its tilt is taken out of the panoramas too.
uneven() {
  grep -qs 'uneven_deg:' "$1/scene.yaml"
}

# A number by its key ($3) from a summary ($1), the first after the key $2, where each key stands on a line of its own.
number() {
  awk -v after="\"$2\":" -v key="\"$3\":" '$1 == after { begun = 1 }
    begun && $1 == key { sub(/,$/, "", $2); print $2; found = 1; exit } END { exit !found }' "$1"
}

# The n of the Fx n with the least error at the end, from the summaries in a folder ($1): the paper's choice.
best_skip() {
  local skip
  for skip in {0..11}; do
    echo "$skip $(number "$1/fx-$skip.json" errors end_deg)"
  done | awk '{ error = $2 < 0 ? -$2 : $2 } NR == 1 || error < least { least = error; best = $1 } END { print best }'
}

# A line of compass.csv: recording ($1), method ($2), from a summary ($3).
add_row() {
  local cells=() key
  for key in max rmse; do cells+=("$(number "$3" error_deg "$key")"); done
  for key in signed_mean_deg std_deg drift_deg_per_s drift_deg_per_m end_deg; do cells+=("$(number "$3" errors "$key")"); done
  printf '%s,%s,%s,%s' "$1" "$2" "$(number "$3" quality references)" "$(number "$3" program frames)"
  printf ',%s' "${cells[@]/null/}"
  awk -v ms="$(number "$3" stages_ms compass)" -v frames="$(number "$3" program frames)" 'BEGIN { printf ",%.3f\n", ms / frames }'
}

# Table 1: statistics of the normalised amplitude with the best skip of a recording ($1) and the next, from the headings in a
# folder ($2). The median of the second is the threshold by the paper's rule.
amplitudes() {
  local best skip
  best=$(best_skip "$2")
  for skip in "$best" $((best + 1)); do
    [[ -f $2/fx-$skip.csv ]] || continue
    awk -F, 'NR > 2 { print $4 }' "$2/fx-$skip.csv" | sort -g | awk -v name="$1" -v skip="$skip" '
      { value[NR] = $1; sum += $1; squares += $1 * $1 }
      END { mean = sum / NR; median = NR % 2 ? value[(NR + 1) / 2] : (value[NR / 2] + value[NR / 2 + 1]) / 2
        printf "%s,%d,%.4f,%.4f,%.4f,%.4f,%.4f\n", name, skip, mean, sqrt(squares / NR - mean * mean), median, value[1], value[NR] }'
  done
}

# The threshold by the rule of Table 1, if it was measured on circle-1.
rule() {
  awk -F, '$1 == "circle-1" { median = $5 } END { print median }' "$table1"
}

# Columns of a CSV file ($1) as a table; the first line is its head.
as_table() {
  column -s, -t <(sed 's/,,/,-,/g; s/,,/,-,/g; s/,$/,-/' "$1")
}

table1=$out/compass-amplitudes.csv
all=$out/compass.csv
echo "recording,skip,mean,std,median,min,max" >"$table1"
echo "recording,method,references,frames,max_deg,rms_deg,mean_deg,std_deg,slope_deg_s,slope_deg_m,end_deg,ms_frame" >"$all"
for name in "${names[@]}"; do
  echo "$name" >&2
  results=$out/compass-$name
  folder=$(recording "$name")
  measure_all "$folder" "$results"
  amplitudes "$name" "$results" >>"$table1"
  best=$(best_skip "$results")
  threshold=$(rule)
  if [[ -n $threshold ]]; then
    measure "$folder" "$results/atm-rule" "${nearest[@]}" --method labrosse2006 --threshold "$threshold"
    wait
  fi
  {
    add_row "$name" "Fx $best" "$results/fx-$best.json"
    add_row "$name" "Atm 0.6055" "$results/atm.json"
    [[ -z $threshold ]] || add_row "$name" "Atm $threshold" "$results/atm-rule.json"
    add_row "$name" "2006-probes" "$results/probes.json"
    add_row "$name" "2004 not smooth" "$results/2004-not-smooth.json"
    add_row "$name" "2004 smooth" "$results/2004-smooth.json"
    add_row "$name" "fft" "$results/fft.json"
    if uneven "$folder"; then add_row "$name" "fft tilt known" "$results/fft-level.json"; fi
  } >>"$all"
done

# Tables 3 and 4: the paper's rows, each followed by ours of the same kind.
tables=$out/compass-tables-3-4.csv
awk -F, -v OFS=, 'function rounded(value) { return value == "" ? "" : sprintf("%.3f", value) }
  FNR == 1 { if (NR == 1) print "recording", "by", "method", "references", "frames", "max_deg", "mean_deg", "std_deg", "slope_deg_s", "slope_deg_m"; next }
  NR == FNR { if (!(($1, substr($2, 1, 2)) in ours)) ours[$1, substr($2, 1, 2)] = $1 OFS "ceilmap" OFS $2 OFS $3 OFS $4 OFS rounded($5) OFS rounded($7) OFS rounded($8) OFS rounded($9) OFS rounded($10); next }
  ($1, substr($2, 1, 2)) in ours { print $1, "paper", $2, $3, $4, $5, $6, $7, $8, $9; print ours[$1, substr($2, 1, 2)] }' \
  "$all" "$root/samples/papers/labrosse2006-tables-3-4.csv" >"$tables"

echo
echo "Labrosse 2006, tables 3 and 4: the paper's recordings, and simulated ones like them by the published method"
as_table "$tables"
echo
echo "Table 1: normalised amplitude with the skip of the least error at the end and one more; the paper's first. The last median of"
echo "circle-1 is the threshold by the paper's rule, used as Atm beside the paper's own"
as_table <(cat "$root/samples/papers/labrosse2006-table1.csv" <(tail -n +2 "$table1"))
echo
echo "All compasses: largest and RMS error, slope, time a frame without unwrapping"
as_table <(awk -F, -v OFS=, 'NR == 1 { print "recording", "method", "max_deg", "rms_deg", "slope_deg_m", "ms_frame"; next }
  { print $1, $2, sprintf("%.2f", $5), sprintf("%.2f", $6), $10 == "" ? "-" : sprintf("%.3f", $10), sprintf("%.2f", $12) }' "$all")
echo
echo "Written: $all, $table1, $tables; figures of fft in $out/compass-*/"
