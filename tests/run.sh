#!/usr/bin/env bash
# Installs what is missing, builds ceilmap and runs all its tests. The last line is "N passed, N failed".
#   tests/run.sh            all tests
#   tests/run.sh -R rig     arguments go to ctest
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
samples/install-deps.sh --tests
cmake --preset release
cmake --build --preset release

report=build/release/ctest.xml
rm -f "$report"
status=0
ctest --preset release -j "$(nproc)" --output-junit "$root/$report" "$@" || status=$?

if [[ ! -s $report ]]; then
  echo "tests/run.sh: ctest wrote no report" >&2
  exit 1
fi
count() { grep -c "$1" "$report" || true; }
# Only a test that skips itself or is switched off is neither: one that could not start has failed.
passed=$(count '<testcase .* status="run"')
left_out=$(($(count '<skipped message="SKIP_') + $(count '<testcase .* status="disabled"')))
failed=$(($(count '<testcase ') - passed - left_out))
echo "$passed passed, $failed failed"
exit "$status"
