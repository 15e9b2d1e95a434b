#!/usr/bin/env bash
# Runs libFuzzer on every reader of what comes from elsewhere (tests/fuzz), as many at a time as there are cores, and
# prints a table; exits with 1 when something crashed, leaked, or took too long or too much memory. Needs clang and libclang-rt-14-dev.
#   tests/fuzz.sh                   a million inputs a reader; of map files 10000, since each is a file
#   tests/fuzz.sh 20000             so many
#   tests/fuzz.sh 20000 rig scene   of these readers only
# What libFuzzer finds worth keeping goes to build/fuzz/found/READER; inputs that crash to build/fuzz/crashes.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
runs=${1:-1000000}
if [[ ! $runs =~ ^[1-9][0-9]*$ ]]; then
  echo "fuzz.sh: '$runs' must be a number of inputs, e.g. 1000000" >&2
  exit 2
fi
shift || true

# Of so many inputs one is run: each takes that much longer than a line of text.
declare -A one_in=([map]=100)
# YAML takes a millisecond a kB: room for the samples' rigs and scenes, and no more.
declare -A longest_bytes=([rig]=2048 [change_rig]=2048 [camera_info]=2048 [scene]=2048 [manifest]=2048 [settings]=2048)
declare -A dictionary=([rig]=yaml [change_rig]=yaml [camera_info]=yaml [scene]=yaml [tum]=text [csv]=text [stamps]=text [headings]=text
  [status]=text [pairs]=text [colour_model]=json [mp4]=mp4 [http]=http [command_line]=command_line [arguments]=text
  [manifest]=site [edges]=edges [points]=text [range]=range [odometry]=text [gyro]=text [hypotheses]=text [settings]=yaml)
targets=("$@")
if ((${#targets[@]} == 0)); then
  for folder in tests/fuzz/corpus/*/; do targets+=("$(basename "$folder")"); done
fi

build=build/fuzz
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz
mkdir -p $build/crashes $build/logs

fuzz_one() {
  local name=$1 program=$build/tests/fuzz/fuzz_$1 found=$build/found/$1 words=()
  mkdir -p "$found"
  if [[ -n ${dictionary[$name]:-} ]]; then words=(-dict=tests/fuzz/dictionaries/"${dictionary[$name]}".dict); fi
  # Who allocated what is asked when an input that crashed is run again; to keep it for all slows long runs by a third.
  ASAN_OPTIONS=strict_string_checks=1:malloc_context_size=1:quarantine_size_mb=8 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 \
    "$program" -runs=$((runs / ${one_in[$name]:-1})) -seed=1 -max_len="${longest_bytes[$name]:-8192}" -timeout=10 -rss_limit_mb=2048 \
    -print_final_stats=1 -artifact_prefix=$build/crashes/"$name"- "${words[@]}" \
    "$found" tests/fuzz/corpus/"$name" >$build/logs/"$name".log 2>&1 || true
}

running=0
for name in "${targets[@]}"; do
  if ((running >= $(nproc))); then
    wait -n
    running=$((running - 1))
  fi
  fuzz_one "$name" &
  running=$((running + 1))
done
wait

bad=0
printf '%-15s %10s %8s %9s %11s %8s %6s\n' reader inputs 'a second' coverage 'new inputs' crashes leaks
for name in "${targets[@]}"; do
  log=$build/logs/$name.log
  stat() { sed -n "s/^stat::$1: *//p" "$log" | tail -1; }
  coverage=$(grep -o 'cov: [0-9]*' "$log" | tail -1 | cut -d' ' -f2 || true)
  leaks=$(grep -c 'ERROR: LeakSanitizer' "$log" || true)
  crashes=$(grep -cE 'SUMMARY: (libFuzzer|AddressSanitizer|UndefinedBehaviorSanitizer)' "$log" || true)
  crashes=$((crashes - leaks))
  printf '%-15s %10s %8s %9s %11s %8s %6s\n' "$name" "$(stat number_of_executed_units)" \
    "$(stat average_exec_per_sec)" "${coverage:-?}" "$(stat new_units_added)" "$crashes" "$leaks"
  # Without its statistics a run came to no end.
  if ((crashes + leaks > 0)) || ! grep -q '^Done ' "$log"; then
    bad=1
    echo "fuzz.sh: $name: see $log" >&2
  fi
done
exit $bad
