#!/usr/bin/env bash
# Installs what is missing, builds ceilmap and runs all its tests. The last line is "N passed, N failed".
#   tests/run.sh            all tests
#   tests/run.sh -R rig     arguments go to ctest
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
log=$(mktemp)
trap 'wait; rm -f "$log"' EXIT
installing=
if ((EUID == 0)); then
  # What only the tests need (a browser, Python modules, ROS 2's build tools) is installed while the build runs.
  samples/install-deps.sh
  samples/install-deps.sh --tests >"$log" 2>&1 &
  installing=$!
else
  samples/install-deps.sh --tests  # it may ask for a password, or refuse
fi
cmake --preset release
cmake --build --preset release
if [[ -n $installing ]] && ! wait "$installing"; then
  cat "$log" >&2
  exit 1
fi

report=build/release/ctest.xml
cases=build/release/gtest
rm -rf "$report" "$cases"
status=0
ctest --preset release -j "$(nproc)" --output-junit "$root/$report" "$@" || status=$?

if [[ ! -s $report ]]; then
  echo "tests/run.sh: ctest wrote no report" >&2
  exit 1
fi
# A program with GoogleTest counts by its tests, anything else as one. Only a test that skips itself or is switched off is
# neither: one that could not start has failed, and so has a program that failed outside of its tests.
passed=0
failed=0
while IFS=$'\t' read -r name state; do
  file=$cases/$name.xml
  wrong=0
  if [[ -s $file ]]; then
    read -r right wrong < <(awk '
      function value(name) { return match($0, " " name "=\"[0-9]+") ? substr($0, RSTART + length(name) + 3, RLENGTH) + 0 : 0 }
      $1 == "<testsuite" { wrong += value("failures") + value("errors"); left += value("disabled") + value("skipped"); all += value("tests") }
      END { print all - wrong - left, wrong }' "$file")
    passed=$((passed + right))
    failed=$((failed + wrong))
  elif [[ $state == run ]]; then
    passed=$((passed + 1))
  fi
  if [[ $state != run && $state != skipped && $state != disabled && $wrong == 0 ]]; then failed=$((failed + 1)); fi
done < <(awk -F'"' '
  function print_last() { if (name) print name "\t" state }
  /<testcase / { print_last(); name = $2; state = $0; sub(/.* status="/, "", state); sub(/".*/, "", state) }
  /<skipped message="SKIP_/ { state = "skipped" }
  END { print_last() }' "$report")
echo "$passed passed, $failed failed"
exit "$status"
