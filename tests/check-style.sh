#!/usr/bin/env bash
# Format and include arrows over all sources, clang-tidy over the product's. Needs build/release (tests/run.sh makes it).
#   tests/check-style.sh         in a tenth of the time: clang-tidy sees the sources as the preset release compiles them,
#                                several as one; its analyzer looks into fewer calls, and the checks that take the longest
#                                are left out
#   tests/check-style.sh --deep  everything that .clang-tidy asks for, of each source alone; also finds sources that
#                                include too little
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
samples/install-deps.sh --dev

database=build/release
folders='(calib|mapping|localization|compensation|app|samples)'
checks=("-checks=-performance-unnecessary-value-param,-bugprone-reserved-identifier,-bugprone-stringview-nullptr,-bugprone-suspicious-include"
  -extra-arg=-Xclang -extra-arg=-analyzer-config -extra-arg=-Xclang -extra-arg=mode=shallow)
case "${1:-}" in
  '') ;;
  --deep)
    cmake --preset release -B build/style -D CMAKE_UNITY_BUILD=OFF >/dev/null
    cmake --build build/style --target page_template help_texts >/dev/null
    database=build/style
    checks=()
    ;;
  *)
    echo "check-style.sh: unknown argument '$1', must be --deep or nothing" >&2
    exit 2
    ;;
esac

if [[ ! -f $database/compile_commands.json ]]; then
  echo "check-style.sh: $database/compile_commands.json is missing; run tests/run.sh first" >&2
  exit 1
fi

echo "Format"
git ls-files -z --cached --others --exclude-standard -- '*.cpp' '*.hpp' |
  while IFS= read -r -d '' file; do
    if [[ -f $file ]]; then printf '%s\0' "$file"; fi
  done | xargs -0 -r clang-format --dry-run -Werror

echo "Includes"
tests/check-includes.sh

echo "clang-tidy"
log=$(mktemp)
commands=$(mktemp -d)
trap 'rm -rf "$log" "$commands"' EXIT
# Without the precompiled headers, which only the compiler can read.
sed -E 's# -Winvalid-pch -include [^ ]*/cmake_pch\.hxx##' "$database/compile_commands.json" >"$commands/compile_commands.json"
if ! run-clang-tidy -quiet -p "$commands" -j "$(nproc)" "${checks[@]}" \
  "^$PWD/($folders/|$database/$folders/.*/Unity/)" >"$log" 2>&1; then
  grep -E -A 4 '(warning|error):' "$log" || tail -n 20 "$log"
  echo "check-style.sh: clang-tidy has findings" >&2
  exit 1
fi
echo "Style is clean"
