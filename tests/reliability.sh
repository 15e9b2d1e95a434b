#!/usr/bin/env bash
# What the program survives: faults of recordings and of the system, memory over a long run, hostile
# files. Prints the tables; exits with 1 when the invariant breaks (no wrong pose that is sure, no map
# lost, no crash).
#   tests/reliability.sh [SOAK_MINUTES=30] [BUILD=build/release]
set -uo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
minutes=${1:-30}
build=$(realpath "${2:-$root/build/release}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
status=0

echo "## Faults of the system"
"$build/tests/faults/ceilmap_faults" system -o "$folder/system" || status=1
echo "## Faults of recordings"
"$build/tests/faults/ceilmap_faults" recordings -o "$folder/recordings" || status=1
echo "## Memory"
"$root/tests/soak.sh" "$minutes" "$build/app/ceilmap" || status=1
if [[ -x $root/tests/fuzz.sh ]]; then
  echo "## Hostile files"
  "$root/tests/fuzz.sh" || status=1
fi
exit "$status"
