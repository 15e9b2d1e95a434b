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
