#!/usr/bin/env bash
# tests/faults/site.sh DIR [KILLS]: a site of 20 simulated recordings (site.py) is made undisturbed, and again in runs that
# are killed (SIGKILL) at KILLS random moments (10). The bytes of the map must be the same, and its errors small.
# CEILMAP names the program, JOBS the jobs at a time (2). DIR keeps rendered recordings (half an hour) for the next run.
# On two cores about 80 minutes. Not part of CTest.
set -euo pipefail
ceilmap=$(realpath "${CEILMAP:-build/release/app/ceilmap}")
tools=$(realpath "$(dirname "$0")")
kills=${2:-10}
jobs=${JOBS:-2}
mkdir -p "$1"
cd "$1"

[[ -e site.yaml ]] || /usr/bin/python3 "$tools/site.py" scenes
for scene in s??.yaml; do
  folder=${scene%.yaml}
  [[ -e $folder/done ]] && continue
  "$ceilmap" simulate "$scene" -o "$folder" --force --quiet
  touch "$folder/done"
done

site_run() { "$ceilmap" site run site.yaml -j "$jobs" --quiet; }

rm -rf site.work site.gpkg undisturbed.gpkg
begin=$SECONDS
site_run
whole=$((SECONDS - begin))
mv site.gpkg undisturbed.gpkg
rm -rf site.work
echo "undisturbed, -j $jobs: $whole s"

RANDOM=7
begin=$SECONDS
for ((kill = 1; kill <= kills; ++kill)); do
  # On average the killed runs do as much as one undisturbed run.
  moment=$((2 * whole * RANDOM / (32768 * kills)))
  setsid "$ceilmap" site run site.yaml -j "$jobs" --quiet 2>/dev/null &
  child=$!
  sleep "$moment"
  kill -KILL -- "-$child" 2>/dev/null || true
  code=0
  wait "$child" 2>/dev/null || code=$?
  done=$(grep -ls '^state: done' site.work/jobs/*.job | wc -l || true)
  echo "killed after $moment s (exit code $code): $done jobs done"
done
site_run
echo "killed $kills times: $((SECONDS - begin)) s in all"
cmp site.gpkg undisturbed.gpkg
echo "the same bytes"
/usr/bin/python3 "$tools/site.py" score
