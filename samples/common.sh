# What the scripts here begin with; they source this file. Sets root, the folder of the repository.
# shellcheck shell=bash

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# Installs what is missing (with the options of install-deps.sh that follow, if any), builds ceilmap, and makes the output
# folder $1. Sets out, that folder's full path, and ceilmap, the program's.
# shellcheck disable=SC2034
prepare() {
  "$root/samples/install-deps.sh" "${@:2}"
  cd "$root" || return
  cmake --preset release
  cmake --build --preset release --target ceilmap
  mkdir -p "$1"
  out=$(cd "$1" && pwd)
  ceilmap=$root/build/release/app/ceilmap
}

# The folder of a recording ($1), below the output folder: rendered from its scene in samples/scenes/papers or samples/scenes,
# unless that was done before. A bundled recording is where it is.
recording() {
  local folder=$out/recordings/$1 scene=$root/samples/scenes/papers/$1.yaml
  if [[ -d $root/samples/$1 ]]; then
    echo "$root/samples/$1"
    return
  fi
  [[ -f $scene ]] || scene=$root/samples/scenes/$1.yaml
  # A recording has a copy of its scene, written last.
  if ! cmp -s "$scene" "$folder/scene.yaml"; then
    mkdir -p "$out/recordings"
    "$ceilmap" simulate "$scene" -o "$folder" --force --quiet >&2
  fi
  echo "$folder"
}
