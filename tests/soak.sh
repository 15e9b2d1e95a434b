#!/usr/bin/env bash
# Lets `ceilmap localize` track a robot that drives to and fro without end, and reports the growth of its memory.
#   tests/soak.sh [MINUTES=30] [PROGRAM=build/release/app/ceilmap]
# Prints frames, the memory in use (VmRSS) and its slope in kB a minute, by least squares over all
# that was sampled every five seconds after the first fifth of the time. Exits with 1 when the program
# failed, or memory grew by more than 1 MB in ten minutes beyond what the slope is uncertain by.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
minutes=${1:-30}
program=$(realpath "${2:-$root/build/release/app/ceilmap}")
folder=$(mktemp -d)
feeder=
runner=
cleanup() {
  if [[ -n $runner ]]; then kill -KILL "$runner" 2>/dev/null || true; fi
  if [[ -n $feeder ]]; then kill "$feeder" 2>/dev/null || true; fi
  rm -rf "$folder"
}
trap cleanup EXIT
cd "$folder"

cat > scene.yaml <<'SCENE'
seed: 20
room: {length_m: 9, width_m: 7}
ceiling: {lamp_every_x: 4, lamp_every_y: 3}
fixtures: {sprinklers_per_100m2: 12}
camera: {width_px: 320, height_px: 240, focal_px: 230}
path: {kind: loops, area_m: [2, 2, 6, 4.5], laps: 1, corner_radius_m: 0.6, speed_m_s: 0.6}
SCENE
"$program" simulate scene.yaml -o room --pictures --quiet
"$program" map --rig room/rig.yaml --up room/up --stamps room/frames.csv -o room.gpkg --quiet
ls room/up/*.png > forth
{ cat forth; tac forth; } > to-and-fro

mkfifo pictures
(trap '' PIPE; while xargs cat < to-and-fro 2>/dev/null; do :; done > pictures) &
feeder=$!
"$program" localize room.gpkg --rig room/rig.yaml --up pictures -o t.tum --status t.csv \
    --summary summary.json > /dev/null 2> messages &
runner=$!

ends=$((SECONDS + minutes * 60))
begin=$SECONDS
while ((SECONDS < ends)) && kill -0 "$runner" 2>/dev/null; do
  rss_kb=$(awk '/^VmRSS/ {print $2}' "/proc/$runner/status" 2>/dev/null || true)
  if [[ -n $rss_kb ]]; then echo "$((SECONDS - begin)) $rss_kb"; fi
  sleep 5
done > samples
kill -INT "$runner" 2>/dev/null || true
status=0
wait "$runner" || status=$?
runner=
if ((status != 0)); then
  echo "soak: exit code $status: $(tail -1 messages)" >&2
  exit 1
fi

frames=$(grep -o '"frames": *[0-9]*' summary.json | head -1 | grep -o '[0-9]*$')
placed=$(grep -cv '^#' t.tum)
awk -v from=$((minutes * 12)) -v minutes="$minutes" -v frames="$frames" -v placed="$placed" '
  $1 >= from {
    n++; t = $1 / 60; st += t; sr += $2; stt += t * t; str += t * $2; srr += $2 * $2
    if (n == 1) first = $2
    last = $2; if ($2 > most) most = $2
  }
  END {
    if (n < 3) { print "soak: too short for a slope"; exit 1 }
    d = n * stt - st * st; slope = (n * str - st * sr) / d
    rest = (srr - sr * sr / n) - slope * slope * d / n
    sigma = rest > 0 ? sqrt(rest / (n - 2) * n / d) : 0
    printf "soak: %d min, %d frames, %.1f %% placed; RSS %d kB after warming up, %d kB at the end, ", \
        minutes, frames, 100 * placed / frames, first, last
    printf "%d kB at the most; slope %.1f +- %.1f kB/min\n", most, slope, sigma
    exit !(slope - 2 * sigma < 100)
  }' samples
