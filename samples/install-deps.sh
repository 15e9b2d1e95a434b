#!/usr/bin/env bash
# Installs from Debian what is missing to build ceilmap and to run its tests.
#   samples/install-deps.sh         compiler, libraries, test libraries
#   samples/install-deps.sh --plots also gnuplot, which draws the figures of --plot, experiments and benchmarks
#   samples/install-deps.sh --python also python3-opencv and python3-matplotlib, for samples/python
#   samples/install-deps.sh --tests all of that, a browser, which the tests of the page drive, and what builds the ROS 2 package
#   samples/install-deps.sh --dev   gnuplot and the tools of the style checks
#   samples/install-deps.sh --packages what tests/package.sh needs
# Needs root or sudo only when something is missing.
set -euo pipefail

packages=(
  cmake ninja-build g++ pkg-config
  libopencv-dev libfftw3-dev libkissfft-dev libeigen3-dev libceres-dev libgdal-dev libsqlite3-dev gdal-bin libyaml-cpp-dev
  nlohmann-json3-dev libcli11-dev libspdlog-dev libfmt-dev libhnswlib-dev
  libavformat-dev libavcodec-dev libswscale-dev libcpp-httplib-dev libjs-leaflet libjs-dygraphs
  libzstd-dev liblz4-dev libbz2-dev libdeflate-dev
  libgtest-dev libgmock-dev libbenchmark-dev
  pybind11-dev python3-dev python3-numpy
)
case "${1:-}" in
  '') ;;
  --plots) packages+=(gnuplot-nox) ;;
  --python) packages+=(python3-opencv python3-matplotlib) ;;
  --tests)
    packages+=(gnuplot-nox python3-opencv python3-matplotlib chromium chromium-driver
      ament-cmake rosidl-cmake rosidl-generator-c-cpp)
    ;;
  --dev) packages+=(clang-format clang-tidy gnuplot-nox) ;;
  --packages) packages+=(dpkg-dev lintian mmdebstrap) ;;
  *)
    echo "install-deps.sh: unknown argument '$1', must be --plots, --python, --tests, --dev, --packages or nothing" >&2
    exit 2
    ;;
esac

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  if [[ $status != installed ]]; then
    missing+=("$package")
  fi
done
if ((${#missing[@]} == 0)); then
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "install-deps.sh: missing ${missing[*]}; run as root: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
echo "Installing ${missing[*]}"
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -q --no-install-recommends "${missing[@]}"
