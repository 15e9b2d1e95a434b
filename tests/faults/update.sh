#!/usr/bin/env bash
# tests/faults/update.sh DIR [KILLS]: a map of samples/scenes/changing-hall.yaml is updated in runs that are killed (SIGKILL) at
# KILLS moments (20) spread over the whole run: each leaves the old map or the new one, byte by byte, and no lock. Then two
# robots update it at once: one of them is refused. CEILMAP names the program. DIR keeps rendered recordings (five minutes) for the
# next run. On two cores about five minutes more. Not part of CTest.
set -euo pipefail
ceilmap=$(realpath "${CEILMAP:-build/release/app/ceilmap}")
scene=$(realpath "$(dirname "$0")/../../samples/scenes/changing-hall.yaml")
kills=${2:-20}
export SOURCE_DATE_EPOCH=1700000000
mkdir -p "$1"
cd "$1"

for session in 0 2; do
  [[ -e s$session/done ]] && continue
  "$ceilmap" simulate "$scene" --session "$session" -o "s$session" --force --quiet
  touch "s$session/done"
done
[[ -e old.gpkg ]] ||
  "$ceilmap" map --rig s0/rig.yaml --up s0/up.mp4 --stamps s0/frames.csv -o old.gpkg --quiet

update() { "$ceilmap" update map.gpkg --rig s2/rig.yaml --up s2/up.mp4 --stamps s2/frames.csv --at-once --quiet; }

cp old.gpkg map.gpkg
begin=$(date +%s%N)
update
whole_ms=$((($(date +%s%N) - begin) / 1000000))
mv map.gpkg new.gpkg
cp old.gpkg map.gpkg
update
cmp map.gpkg new.gpkg
echo "undisturbed: $whole_ms ms; again the same bytes"

old=0
new=0
for ((kill = 1; kill <= kills; ++kill)); do
  cp old.gpkg map.gpkg
  # Half of the kills in the last fifth, where the map is written.
  if ((kill % 2)); then moment_ms=$((whole_ms * kill / kills)); else moment_ms=$((whole_ms * (4 * kills + kill) / (5 * kills))); fi
  setsid "$ceilmap" update map.gpkg --rig s2/rig.yaml --up s2/up.mp4 --stamps s2/frames.csv --at-once --quiet 2>/dev/null &
  child=$!
  sleep "$((moment_ms / 1000)).$(printf '%03d' $((moment_ms % 1000)))"
  kill -KILL -- "-$child" 2>/dev/null || true
  wait "$child" 2>/dev/null || true
  if cmp -s map.gpkg old.gpkg; then old=$((old + 1)); elif cmp -s map.gpkg new.gpkg; then new=$((new + 1)); else
    echo "killed after $moment_ms ms: neither the old map nor the new one" >&2
    exit 1
  fi
done
update
echo "killed $kills times: $old times the old map, $new times the new one; updated again after the last"

cp old.gpkg map.gpkg
update 2>first.err &
first=$!
codes=()
code=0
update 2>second.err || code=$?
codes+=("$code")
code=0
wait "$first" || code=$?
codes+=("$code")
cat first.err second.err
sessions=$("$ceilmap" info map.gpkg --changes --json | python3 -c 'import json, sys; print(len(json.load(sys.stdin)["sessions"]))')
echo "two at once: exit codes ${codes[*]}, $sessions session(s) in the map"
[[ " ${codes[*]} " == *" 0 "* && " ${codes[*]} " == *" 2 "* && $sessions == 1 ]]
cmp map.gpkg new.gpkg
echo "the map of the one that was not refused, byte by byte"
