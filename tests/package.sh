#!/usr/bin/env bash
# Builds the Debian packages, checks them with lintian, and tries them in a clean Debian 12, where apt installs them:
# the program on a sample, the manual pages, the Python module, and a project that uses find_package(ceilmap).
#   tests/package.sh          builds all with the preset package
#   tests/package.sh BUILD    packages what the build folder BUILD holds
# Needs root, and Debian's archive as /etc/apt names it: it downloads 1 GB.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=${1:-}
if ((EUID != 0)); then
  echo "package.sh: run as root, which a chroot needs" >&2
  exit 1
fi
samples/install-deps.sh --packages
# Where the clean system's packages come from.
sources=()
for file in /etc/apt/sources.list /etc/apt/sources.list.d/debian.sources; do
  if [[ -s $file ]] && grep -q bookworm "$file"; then sources+=("$file"); fi
done

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
begin=$SECONDS
# step NAME: what the step before took, and the name of the next.
step() {
  echo "== $1 ($((SECONDS - begin)) s)"
}

if [[ -z $build ]]; then
  step "build"
  build=build/package
  cmake --preset package
  cmake --build --preset package
fi
step "packages"
cpack --config "$build/CPackConfig.cmake" -B "$work" >"$work/cpack.log" || {
  cat "$work/cpack.log" >&2
  exit 1
}
mkdir -p "$build/packages"
rm -f "$build"/packages/*.deb
cp "$work"/*.deb "$build/packages"
for package in "$build"/packages/*.deb; do
  echo "$(basename "$package"): $(du -k "$package" | cut -f1) kB, installed $(dpkg-deb -f "$package" Installed-Size) kB"
  echo "  Depends: $(dpkg-deb -f "$package" Depends)"
done

step "lintian"
lintian --allow-root --fail-on error "$build"/packages/*.deb

step "clean Debian 12"
trial=$work/trial
mkdir "$trial"
cp -r "$build/packages" samples/lab-map tests/integration/consumer tests/package-trial.sh "$trial"
# shellcheck disable=SC2016  # $1 is the folder of the clean system, which mmdebstrap names
mmdebstrap --quiet --mode=root --variant=apt --format=null \
  --aptopt='APT::Install-Recommends "false"' --aptopt='Acquire::Retries "3"' \
  --customize-hook="copy-in $trial /" --customize-hook='chroot "$1" bash /trial/package-trial.sh' \
  bookworm - "${sources[@]}"
step "done"
