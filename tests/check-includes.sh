#!/usr/bin/env bash
# Holds every #include "folder/..." against the layers:
#   calib <- registration <- mapping <- localization <- app
#   calib <- registration <- compensation <- app
#   calib <- calibration <- app
#   calib <- colour <- app
#   calib <- evaluation <- app
#   calib <- registration <- mapping <- page <- app
# calib/solve/ (calibration), mapping/registration/, localization/compass/, localization/compass/colour/, app/evaluation/ and app/page/ are layers of their own. tests/ may include anything, and so may
# samples/embed/, a project of its own on top of the installed libraries.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."

declare -A may_include=(
  [calib]="calib"
  [calibration]="calibration calib"
  [registration]="registration calib"
  [mapping]="mapping registration calib"
  [compass]="compass calib registration"
  [colour]="colour calib"
  [localization]="localization compass mapping registration calib"
  [compensation]="compensation registration calib"
  [evaluation]="evaluation calib"
  [page]="page mapping registration calib"
  [app]="app page evaluation calibration colour localization compass compensation mapping registration calib samples"
  [samples]="samples calib"
)

layer_of() {
  case "$1" in
    calib/solve/*) echo calibration ;;
    mapping/registration/*) echo registration ;;
    localization/compass/colour/*) echo colour ;;
    localization/compass/*) echo compass ;;
    app/evaluation/*) echo evaluation ;;
    app/page/*) echo page ;;
    calib/* | mapping/* | localization/* | compensation/* | app/* | samples/* | tests/*) echo "${1%%/*}" ;;
  esac
}

bad=0
while IFS=: read -r file line text; do
  included=${text#*\"}
  included=${included%%\"*}
  from=$(layer_of "$file")
  to=$(layer_of "$included")
  if [[ -z $to ]]; then
    echo "$file:$line: \"$included\" must name its folder from the project's root, e.g. \"calib/pose2.hpp\"" >&2
    bad=1
  elif [[ " ${may_include[$from]} " != *" $to "* ]]; then
    echo "$file:$line: $from must not include $to (\"$included\"); it may include: ${may_include[$from]}" >&2
    bad=1
  fi
done < <(grep -rnE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"' --include='*.hpp' --include='*.cpp' \
  calib mapping localization compensation app samples | grep -v '^samples/embed/' || true)
exit "$bad"
