#!/usr/bin/env bash
# What tests/package.sh runs inside of a clean Debian 12: installs the packages and uses them.
set -euo pipefail

cd /trial
export DEBIAN_FRONTEND=noninteractive
before=$(dpkg-query -W | wc -l)
apt-get install -y -qq ./packages/*.deb cmake make g++ man-db >install.log 2>&1 || {
  tail -20 install.log >&2
  exit 1
}
echo "apt installed $(($(dpkg-query -W | wc -l) - before)) packages"

ceilmap --version
ceilmap map --quiet --rig lab-map/rig.yaml --up lab-map/up.mp4 --stamps lab-map/frames.csv -o lab.gpkg --trajectory lab.tum
ceilmap evaluate --truth lab-map/truth.tum lab.tum
man -P cat ceilmap-map | head -4
grep -q 'complete -F _ceilmap ceilmap' /usr/share/bash-completion/completions/ceilmap

if compgen -G 'packages/python3-*' >/dev/null; then
  python3 -c 'import ceilmap; print("import ceilmap:", ceilmap.__version__)'
fi

# Its other targets compile every installed header, which the integration tests do.
cmake -S consumer -B built >cmake.log 2>&1 || {
  cat cmake.log >&2
  exit 1
}
cmake --build built --target consumer simulator_consumer >>cmake.log 2>&1 || {
  tail -20 cmake.log >&2
  exit 1
}
built/consumer
built/simulator_consumer
