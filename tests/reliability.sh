#!/usr/bin/env bash
# What the program survives: faults of the system and of recordings, memory over a long run, hostile
# files. Prints the tables, each with its time; exits with 1 when the invariant breaks (no wrong pose
# that is sure, no map lost, no crash, no leak).
#   tests/reliability.sh                     all of it: hours
#   tests/reliability.sh system recordings   these of the parts system, recordings, odometry, bags, fisheye, heights, memory, files
# The last lines are one table: each part with its date, its time, and whether it held.
# The environment sets MINUTES (30) of memory, INPUTS (1000000) a reader of files, and BUILD
# (build/release; tests/run.sh makes it). What files needs it builds itself, with clang.
set -uo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
parts=("$@")
if ((${#parts[@]} == 0)); then parts=(system recordings odometry bags fisheye heights memory files); fi
for part in "${parts[@]}"; do
  if [[ ! $part =~ ^(system|recordings|odometry|bags|fisheye|heights|memory|files)$ ]]; then
    echo "reliability.sh: unknown part '$part', must be system, recordings, odometry, bags, fisheye, heights, memory or files" >&2
    exit 2
  fi
done
build=$(realpath "${BUILD:-$root/build/release}")
if [[ ! -x $build/app/ceilmap || ! -x $build/tests/faults/ceilmap_faults ]]; then
  echo "reliability.sh: $build has no ceilmap and ceilmap_faults; run tests/run.sh first" >&2
  exit 2
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
status=0

table=()
for part in "${parts[@]}"; do
  start=$SECONDS
  held=yes
  case $part in
    memory)
      echo "## Memory"
      "$root/tests/soak.sh" "${MINUTES:-30}" "$build/app/ceilmap" || held=no
      ;;
    files)
      echo "## Hostile files"
      "$root/tests/fuzz.sh" "${INPUTS:-1000000}" || held=no
      ;;
    *)
      echo "## Faults: $part"
      "$build/tests/faults/ceilmap_faults" "$part" -o "$folder/$part" || held=no
      ;;
  esac
  if [[ $held == no ]]; then status=1; fi
  table+=("| $part | $(date -u +%Y-%m-%d) | $(((SECONDS - start + 30) / 60)) | $held |")
done
printf '%s\n' "## All parts" '| part | date | minutes | held |' '|---|---|---|---|' "${table[@]}"
exit "$status"
