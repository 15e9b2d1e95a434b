#!/usr/bin/env bash
# Holds every #include "folder/..." against the layers. Each folder with a CMakeLists.txt of its own is a layer and may
# include only what its row names: no arrow points upward, and there are no cycles. Tests may include all of the product and
# the tests of what their folder may include. samples/embed/ and samples/ros2/ are projects of their own on top of the
# installed libraries.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Lowest first: a row may only name rows above it.
rows=(
  "calib/base:"
  "calib/wheels: calib/base"
  "calib: calib/wheels calib/base"
  "calib/solve: calib calib/base"
  "mapping/heights: calib/base"
  "mapping/registration: mapping/heights calib calib/base"
  "mapping/graph: mapping/heights calib/base"
  "mapping/places: mapping/registration calib/base"
  "mapping/survey: calib/base"
  "mapping/store: mapping/survey mapping/graph mapping/heights calib/base"
  "mapping/mosaic: mapping/store mapping/graph mapping/registration mapping/heights calib calib/base"
  "mapping/change: mapping/mosaic mapping/store mapping/places mapping/graph mapping/registration mapping/heights calib calib/base"
  "mapping: mapping/mosaic mapping/store mapping/survey mapping/places mapping/graph mapping/registration mapping/heights calib calib/wheels calib/base"
  "compensation: mapping/registration mapping/heights calib calib/base"
  "compensation/mount: compensation mapping/registration mapping/heights calib/solve calib calib/wheels calib/base"
  "localization/compass: mapping/registration calib/wheels calib/base"
  "localization/compass/labrosse: localization/compass calib/base"
  "localization/compass/colour: calib calib/base"
  "localization: mapping mapping/mosaic mapping/store mapping/places mapping/graph mapping/registration mapping/heights calib calib/wheels calib/base"
  "localization/robot: localization localization/compass localization/compass/colour compensation mapping mapping/change mapping/store mapping/mosaic
    mapping/survey mapping/graph mapping/registration calib calib/wheels calib/base"
  "samples/simulator: calib calib/base"
  "app/evaluation: calib/base"
  "app/page: mapping/store mapping/graph calib/base"
  "app/manual:"
  "app/terminal: calib/base"
  "app/bags: calib/base"
  "app/files: app/bags app/evaluation localization/robot localization localization/compass localization/compass/colour mapping/graph mapping/survey calib/wheels calib/base"
  "app/recordings: app/bags app/files app/terminal samples/simulator localization/robot compensation localization localization/compass
    localization/compass/labrosse localization/compass/colour mapping mapping/registration compensation/mount calib/solve calib calib/wheels calib/base"
  "app/figures: app/recordings app/files app/terminal app/evaluation localization/compass calib/base"
  "app/reports: app/figures app/recordings app/bags app/files app/terminal app/page app/evaluation localization/robot localization
    localization/compass/colour compensation/mount calib/solve mapping mapping/change mapping/mosaic mapping/store mapping/survey mapping/graph mapping/heights calib calib/wheels calib/base"
  "app/live: app/reports app/files app/page app/terminal mapping/mosaic mapping/store mapping/graph calib calib/base"
  "app/site: calib/base"
  "app/commands: app/site app/live app/reports app/figures app/recordings app/bags app/files app/terminal app/page samples/simulator
    localization/robot localization localization/compass localization/compass/labrosse localization/compass/colour mapping mapping/change mapping/mosaic mapping/store
    mapping/survey mapping/graph mapping/registration compensation/mount calib/solve calib calib/wheels calib/base"
  "app/python: app/evaluation localization/robot localization localization/compass/labrosse localization/compass/colour mapping
    mapping/store mapping/graph mapping/registration calib calib/base"
  "app: app/commands app/files app/manual app/terminal calib/base"
)
# tests/X may include tests/Y where X may include Y, and tests/support; and besides:
test_rows=(
  "tests/support: calib/base"
  "tests/mapping/mosaic: tests/mapping/registration"
  "tests/mapping: tests/compensation"
  "tests/localization/robot: tests/compensation"
  "tests/app/reports: tests/compensation"
  "tests/integration: tests/mapping/store tests/calib/solve"
  "tests/fuzz: tests/mapping/store"
  "tests/faults:"
  "tests/bench: tests/calib/solve tests/mapping/graph tests/mapping/registration tests/localization/compass tests/app/bags"
)

declare -A may_include=()
for row in "${rows[@]}"; do
  layer=${row%%:*}
  for lower in ${row#*:}; do
    if [[ ! -v may_include[$lower] ]]; then
      echo "check-includes.sh: the row of $layer names $lower, which must have a row above it" >&2
      exit 1
    fi
  done
  may_include[$layer]="$layer ${row#*:}"
done
declare -A tests_may_include=()
for row in "${test_rows[@]}"; do tests_may_include[${row%%:*}]=${row#*:}; done

# Sets `layer`: the longest folder of a path that has a row; of tests, the folder itself; or nothing. Not by its output,
# because a process for each #include would take a minute.
find_layer() {
  layer=${1%/*}
  if [[ $layer == tests* ]]; then return; fi
  while [[ ! -v may_include[$layer] && $layer == */* ]]; do layer=${layer%/*}; done
  if [[ ! -v may_include[$layer] ]]; then layer=; fi
}

bad=0
while IFS=: read -r file line text; do
  included=${text#*\"}
  included=${included%%\"*}
  find_layer "$file"
  from=$layer
  find_layer "$included"
  to=$layer
  if [[ -z $to || $included != */* ]]; then
    echo "$file:$line: \"$included\" must name its folder from the project's root, e.g. \"calib/base/pose2.hpp\"" >&2
    bad=1
  elif [[ $from == tests* ]]; then
    allowed="$from tests/support ${tests_may_include[$from]:-} "
    for lower in ${may_include[${from#tests/}]:-}; do allowed+="tests/$lower "; done
    if [[ $to == tests* && " $allowed" != *" $to "* ]]; then
      echo "$file:$line: $from must not include $to (\"$included\"); what both need goes to tests/support" >&2
      bad=1
    fi
  elif [[ " ${may_include[$from]} " != *[[:space:]]$to[[:space:]]* && ${may_include[$from]%% *} != "$to" ]]; then
    echo "$file:$line: $from must not include $to (\"$included\"); it may include:" ${may_include[$from]} >&2
    bad=1
  fi
done < <(git ls-files '*.hpp' '*.cpp' | grep -vE '^(samples/embed|samples/ros2|tests/samples/ros2|tests/integration/consumer)/' |
  xargs grep -nE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"' || true)
exit "$bad"
