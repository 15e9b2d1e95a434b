#!/usr/bin/env bash
# Format and include arrows over all sources, clang-tidy over the product's.
#   tests/check-style.sh         in a tenth of the time: clang-tidy sees all libraries of some top-level folders as one,
#                                so that it reads their headers once; its analyzer looks into fewer calls, and checks that
#                                take long, for mistakes that these sources have no occasion for, are left out
#   tests/check-style.sh --deep  everything that .clang-tidy asks for, of each source alone; also finds sources that
#                                include too little
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
samples/install-deps.sh --dev

database=build/style
folders='(calib|mapping|localization|compensation|app|samples)'
unity=(-D CEILMAP_STYLE=ON -D CMAKE_UNITY_BUILD=ON -D CMAKE_UNITY_BUILD_BATCH_SIZE=0)
# A check costs what it takes to look at the libraries' headers. These are about C strings, sizes and macros, which the
# sources have next to none of, or find what the compiler's warnings find too.
left_out=(
  bugprone-assert-side-effect
  bugprone-misplaced-widening-cast
  bugprone-multiple-statement-macro
  bugprone-not-null-terminated-result
  bugprone-reserved-identifier
  bugprone-sizeof-expression
  bugprone-stringview-nullptr
  bugprone-suspicious-include
  bugprone-suspicious-semicolon
  bugprone-suspicious-string-compare
  bugprone-undelegated-constructor
  bugprone-unused-raii
  bugprone-unused-return-value
  performance-unnecessary-value-param
)
checks=("-checks=$(printf ',-%s' "${left_out[@]}")"
  -extra-arg=-Xclang -extra-arg=-analyzer-config -extra-arg=-Xclang -extra-arg=mode=shallow)
case "${1:-}" in
  '') ;;
  --deep)
    unity=(-D CEILMAP_STYLE=OFF -D CMAKE_UNITY_BUILD=OFF)
    checks=()
    ;;
  *)
    echo "check-style.sh: unknown argument '$1', must be --deep or nothing" >&2
    exit 2
    ;;
esac

echo "Format"
git ls-files -z --cached --others --exclude-standard -- '*.cpp' '*.hpp' |
  while IFS= read -r -d '' file; do
    if [[ -f $file ]]; then printf '%s\0' "$file"; fi
  done | xargs -0 -r clang-format --dry-run -Werror

echo "Includes"
tests/check-includes.sh

echo "Names"
# Bounds are called kMax and kMin, ratios and fractions by these words.
if git grep -nE '\bk(Most|Least)([A-Z]|\b)|[a-z]_part\b' -- '*.cpp' '*.hpp'; then
  echo "check-style.sh: names that the project does not use" >&2
  exit 1
fi

echo "clang-tidy"
cmake --preset release -B "$database" "${unity[@]}" >/dev/null
cmake --build "$database" --target page_template help_texts >/dev/null
log=$(mktemp)
commands=$(mktemp -d)
trap 'rm -rf "$log" "$commands"' EXIT
# Without the precompiled headers, which only the compiler can read.
sed -E 's# -Winvalid-pch -include [^ ]*/cmake_pch\.hxx##' "$database/compile_commands.json" >"$commands/compile_commands.json"
# The longest first, which are those with most sources, and the findings of one source together.
if ! sed -nE "s#^ *\"file\": \"($PWD/($folders/|$database/($folders|CMakeFiles)/.*/Unity/).*)\",?\$#\1#p" \
  "$commands/compile_commands.json" | xargs wc -l | grep -v ' total$' | sort -rn | awk '{print $2}' |
  xargs -P "$(nproc)" -I FILE sh -c 'findings=$("$@" 2>&1) || { echo "$findings"; exit 1; }' sh \
    clang-tidy -quiet -p "$commands" "${checks[@]}" FILE >"$log" 2>&1; then
  grep -E -A 4 '(warning|error):' "$log" || tail -n 20 "$log"
  echo "check-style.sh: clang-tidy has findings" >&2
  exit 1
fi
echo "Style is clean"
