#!/usr/bin/env bash
# The experiments of the ViCTORiA compass (absolute heading by the colours around a robot) on simulated recordings: turns on
# the spot; a map filled by a walk, and kept up to date; coloured boards that come and go; places away from that of learning.
# Prints tables, and draws the figures.
#   samples/colour-experiments.sh [OUTPUT_DIR] [DATA]     default: samples/out/colours
# DATA, where it is given, has rendered recordings of a lab (lab-turn-learn, -again, -crowd, -away, lab-walk) to be run too.
set -euo pipefail

# shellcheck source=samples/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
data=${2:+$(cd "$2" && pwd)}
prepare "${1:-$root/samples/out/colours}" --plots
mkdir -p "$out/scenes" "$out/results"
grid=1.5,1.5,6,4,5,3    # of the room: x, y, width, height, columns, rows

# A full turn on the spot as poses of the base: the axle at X ($1), Y ($2), from START_DEG ($3) on, in so many frames ($4) and
# seconds ($5).
turn() {
  awk -v x="$1" -v y="$2" -v start="$3" -v frames="$4" -v seconds="$5" 'BEGIN {
    pi = 4 * atan2(1, 1)
    for (i = 0; i < frames; ++i) {
      yaw = start * pi / 180 + 2 * pi * i / frames
      printf "%.6f %.9f %.9f 0 0 0 %.9f %.9f\n", 100 + seconds * i / frames, x + 0.14 * cos(yaw), y + 0.14 * sin(yaw),
        sin(yaw / 2), cos(yaw / 2)
    }
  }'
}

# Scenes from the bundled ones: filters of their text.
small() { sed 's/^forward: {focal_px: 543.58/forward: {width_px: 320, height_px: 240, focal_px: 271.79/'; }
exposed() { sed "s/^picture: {/picture: {exposure_gain: $1, /"; }    # so many times as much light
along() { sed "s|^path: .*|path: {$1}|"; }    # another path
boards() {    # the first N of them
  awk -v most="$1" '/^movers:/ { inside = 1 } /^]/ { inside = 0 } !(inside && /^ *[0-9]/ && ++board > most)'
}

# Renders the scene from stdin as the recording NAME ($1); the rest are options.
record() {
  echo "rendering $1"
  cat >"$out/scenes/$1.yaml"
  "$ceilmap" simulate "$out/scenes/$1.yaml" --quiet --force -o "$out/$1" "${@:2}"
}

# The same of a turn on the spot: NAME X Y START_DEG FRAMES SECONDS.
record_turn() {
  turn "${@:2}" >"$out/scenes/$1.tum"
  along "kind: tum, tum_file: $1.tum" | record "$1"
}

room() { cat "$root/samples/scenes/colour-room.yaml"; }
ring() { small <"$root/samples/scenes/colour-boards.yaml"; }

# The files of a recording ($1), a folder.
files_of() { printf '%s\n' --rig "$1/rig.yaml" --forward "$1/forward.mp4" --stamps "$1/frames.csv"; }

# Learns a model ($1, its name) from a recording ($2); the rest are options.
learn() {
  local files
  readarray -t files < <(files_of "$2")
  "$ceilmap" compass learn --force --quiet "${files[@]}" --poses "$2/truth.tum" -o "$out/$1.colours" --summary "$out/$1.json" "${@:3}"
}

# Puts a recording ($3) into a copy ($2) of a model ($1).
update() {
  local files
  readarray -t files < <(files_of "$3")
  "$ceilmap" compass update --force --quiet "$out/$1.colours" "${files[@]}" --poses "$3/truth.tum" -o "$out/$2.colours"
}

# A number by its key ($2) from a summary ($1), where each key stands on a line of its own.
number() {
  awk -v key="\"$2\":" '$1 == key { sub(/,$/, "", $2); print $2; found = 1; exit } END { exit !found }' "$1"
}

# Headings of a recording ($2) by a model ($1), into a result (the name $3); the rest are options.
query() {
  local files
  readarray -t files < <(files_of "$2")
  "$ceilmap" compass query --force --quiet "$out/$1.colours" "${files[@]}" --truth "$2/truth.tum" -o "$out/results/$3.csv" \
    --summary "$out/results/$3.json" "${@:4}"
}

# The same, and prints the mean error in rad. The place is not known.
mean_error_anywhere() {
  query "$@"
  number "$out/results/$3.json" mean_rad | awk '{ printf "%.4f", $1 }'
}

# The same where the place is known.
mean_error() { mean_error_anywhere "$@" --poses "$2/truth.tum"; }

row='%-26s %12s %12s %12s %12s\n'
# shellcheck disable=SC2059
head_of_turns() { printf "$row" 'mean error, rad' 'place known' 'not known' 'as published' 'Sturm & Visser'; }

# A row of the table: a recording ($2), called $3, by a model ($1) and, if it is given, one of Sturm & Visser ($4).
turn_row() {
  local known anywhere published sturm=
  known=$(mean_error "$1" "$2" "$3")
  anywhere=$(mean_error_anywhere "$1" "$2" "$3-anywhere")
  published=$(mean_error "$1" "$2" "$3-published" --no-parallax)
  if [[ -n ${4:-} ]]; then sturm=$(mean_error "$4" "$2" "$3-sturm"); fi
  # shellcheck disable=SC2059
  printf "$row" "$3" "$known" "$anywhere" "$published" "$sturm"
}

experiment_1() {
  local gain
  room | record_turn turn-learn 3 3 0 90 9
  for gain in 0.94 0.85 0.7; do room | exposed "$gain" | record_turn "turn-again-$gain" 3 3 137 60 10; done
  learn large "$out/turn-learn"
  learn large-sturm "$out/turn-learn" --method sturm
  echo
  echo "Experiment 1: turns on the spot, learned from another one (other start, and exposure: times the light)"
  head_of_turns
  for gain in 0.94 0.85 0.7; do turn_row large "$out/turn-again-$gain" "turn-again-$gain" large-sturm; done
}

# The recordings of the lab: also experiment 3 with people, and turns away from the place of learning.
experiment_lab() {
  local name updating published
  learn lab "$data/lab-turn-learn"
  learn lab-sturm "$data/lab-turn-learn" --method sturm
  update lab lab-walked "$data/lab-walk"
  echo
  echo "Rendered lab: learned from lab-turn-learn"
  head_of_turns
  for name in again crowd away; do turn_row lab "$data/lab-turn-$name" "lab-turn-$name" lab-sturm; done
  turn_row lab "$data/lab-walk" lab-walk lab-sturm
  updating=$(mean_error lab "$data/lab-walk" lab-walk-update --update)
  published=$(mean_error lab "$data/lab-walk" lab-walk-update-published --update --no-parallax)
  # shellcheck disable=SC2059
  printf "$row" 'lab-walk, updating' "$updating" '' "$published" ''
  echo "learned from lab-walk too"
  for name in again away; do turn_row lab-walked "$data/lab-turn-$name" "lab-turn-$name, walked"; done
  update lab lab-away "$data/lab-turn-away"
  echo "learned from lab-turn-away too: its own frames"
  for name in again away; do turn_row lab-away "$data/lab-turn-$name" "lab-turn-$name, learned"; done
}

# Angle bins of the cells of a model ($1): the cell's centre x, y, the first and last direction in deg, filled (1) or not (0).
cells() {
  awk -v grid="$grid" 'BEGIN { split(grid, g, ","); bins = 180 }
    function print_cell(    b) {
      if (!count++) return
      x = g[1] + ((count - 2) % g[5] + 0.5) * g[3] / g[5]
      y = g[2] + (int((count - 2) / g[5]) + 0.5) * g[4] / g[6]
      for (b = 0; b < bins; ++b) print x, y, b * 360 / bins, (b + 1) * 360 / bins, (b in filled)
      delete filled
    }
    /^\[/ { print_cell() }
    match($0, /"bin":[0-9]+/) { filled[substr($0, RSTART + 6, RLENGTH - 6)] = 1 }
    END { print_cell() }' "$1"
}

# Fills a map by a walk. Then whether updating helps: on another walk, with a model of one turn and with that of the walk.
experiment_2() {
  local model known anywhere updating
  local walk="kind: random_walk, area_m: [1.5, 1.5, 7.5, 5.5], length_m: 200, frame_rate_hz: 5"
  walk+=", speed_m_s: 0.8, turn_rate_deg_s: 90"
  local after="kind: waypoints, speed_m_s: 0.5, turn_rate_deg_s: 40, frame_rate_hz: 5, start_stamp_s: 400, waypoints_m: ["
  after+="3, 3, 5.9, 4.6, 6.8, 2.2, 4.4, 1.8, 2.1, 4.9, 4.2, 5.1, 6.9, 5.2, 5.5, 2.9, 2.2, 2.0, 3, 3]"
  room | small | along "$walk" | record walk --frames 900
  room | small | along "$after" | record walk-after
  room | small | record_turn turn-small 3 3 0 60 10
  learn walk "$out/walk" --grid "$grid"
  learn turn "$out/turn-small"
  cells "$out/walk.colours" >"$out/results/cells.txt"
  echo
  echo "Experiment 2: a map of 15 cells, filled by 3 minutes of a random walk"
  awk '{ cell = $1 " " $2; all[cell]++; filled[cell] += $5 }
    END {
      for (cell in all) if (filled[cell]) { ++seen; bins += all[cell]; full += filled[cell] }
      printf "%d cells visited, %.1f %% of their bins filled\n", seen, 100 * full / bins
    }' "$out/results/cells.txt"
  # shellcheck disable=SC2059
  printf "$row" 'mean error of another walk' 'place known' 'not known' 'updating' ''
  for model in turn walk; do
    known=$(mean_error "$model" "$out/walk-after" "after-$model")
    anywhere=$(mean_error_anywhere "$model" "$out/walk-after" "after-$model-anywhere")
    updating=$(mean_error "$model" "$out/walk-after" "after-$model-update" --update)
    # shellcheck disable=SC2059
    printf "$row" "model of the $model" "$known" "$anywhere" "$updating" ''
  done
}

experiment_3() {
  local learned shown errors place
  for learned in 2 6 9 10; do
    ring | boards "$learned" | record_turn "boards-learn-$learned" 3.5 3.5 0 60 10
    learn "boards-$learned" "$out/boards-learn-$learned"
  done
  for shown in {1..10}; do
    ring | boards "$shown" | record_turn "boards-$shown" 3.5 3.5 200 60 10
  done
  for shown in {1..10}; do
    errors=("$shown")
    for learned in 2 6 9 10; do
      errors+=("$(mean_error "boards-$learned" "$out/boards-$shown" "boards-$learned-$shown")")
    done
    for learned in 2 6 9 10; do
      errors+=("$(mean_error_anywhere "boards-$learned" "$out/boards-$shown" "boards-$learned-$shown-anywhere")")
    done
    echo "${errors[*]}"
  done >"$out/results/boards.txt"
  echo
  echo "Experiment 3: mean error, rad, with 1 to 10 boards around the robot, by models learned with 2, 6, 9, 10; place known"
  printf '%6s %9s %9s %9s %9s\n' boards 2 6 9 10
  awk '{ printf "%6d %9.4f %9.4f %9.4f %9.4f\n", $1, $2, $3, $4, $5 }' "$out/results/boards.txt"
  awk '{ for (i = 2; i <= 5; ++i) if ($i > known) known = $i; for (i = 6; i <= 9; ++i) if ($i > anywhere) anywhere = $i }
    END { printf "the largest: %.4f; %.4f where the place is not known\n", known, anywhere }' "$out/results/boards.txt"
  for place in '' -anywhere; do
    awk -F, -v place="${place:+ not}" 'FNR > 1 {
        ++frames
        error = ($6 < 0 ? -$6 : $6) * atan2(0, -1) / 180
        if ($4 >= 0.9) { ++sure; sum += error; if (error > 0.3) ++wrong }
      }
      END {
        printf "frames with a confidence of at least 0.9, place%s known: %.0f %%, mean error %.4f, %.1f %% of them above 0.3\n",
          place, 100 * sure / frames, sum / sure, 100 * wrong / sure
      }' "$out"/results/boards-{2,6,9,10}-{1,2,3,4,5,6,7,8,9,10}"$place".csv
  done
}

# Turns ever farther from the place of learning: one cell, and the grid that the walk filled.
experiment_4() {
  local away x y model errors
  for away in 0.0 0.5 1.0 1.5 2.0 2.5; do
    read -r x y < <(awk -v d="$away" 'BEGIN { printf "%.4f %.4f\n", 3 + 0.940 * d, 3 + 0.342 * d }')
    room | small | record_turn "away-$away" "$x" "$y" 70 60 10
  done
  for away in 0.0 0.5 1.0 1.5 2.0 2.5; do
    errors=("$away")
    for model in turn walk; do
      errors+=("$(mean_error "$model" "$out/away-$away" "away-$away-$model")")
      errors+=("$(mean_error_anywhere "$model" "$out/away-$away" "away-$away-$model-anywhere")")
      errors+=("$(mean_error "$model" "$out/away-$away" "away-$away-$model-published" --no-parallax)")
    done
    echo "${errors[*]}"
  done >"$out/results/distance.txt"
  echo
  echo "Experiment 4: mean error, rad, of turns away from the place of learning"
  printf '%6s %32s   %32s\n' '' 'one cell, by a turn at 0 m' 'the grid of the walk'
  printf '%6s %10s %10s %10s   %10s %10s %10s\n' 'm' 'known' 'not known' 'published' 'known' 'not known' 'published'
  awk '{ printf "%6.1f %10.4f %10.4f %10.4f   %10.4f %10.4f %10.4f\n", $1, $2, $3, $4, $5, $6, $7 }' \
    "$out/results/distance.txt"
}

experiment_1
experiment_2
experiment_3
experiment_4
if [[ -n $data ]]; then experiment_lab; fi

echo
echo "Of the papers: below 0.10 rad on turns on the spot, at most 0.41 rad with boards that come and go. Known or not: whether"
echo "the position of the robot is given. As published: known, without a correction of directions for the position."
gnuplot -e "folder = '$out'" "$root/samples/colour-experiments.gp"
echo
for figure in cells updating boards distance; do
  for format in svg png; do echo "  $out/$figure.$format"; done
done
