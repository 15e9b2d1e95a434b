#!/usr/bin/env bash
# Lists the licences of all Debian packages whose libraries `ldd` names for programs or libraries:
#   tests/licences.sh build/release/app/ceilmap          one line for each package: directly linked or not, licence
#   tests/licences.sh --gpl build/release/app/ceilmap    only what is under the GPL, and what links it
#   tests/licences.sh --users build/release/app/ceilmap  separated by tabs, the packages that link it last, for tests/sbom.py
# The licence is that of "Files: *" in /usr/share/doc/PACKAGE/copyright, and what is known better, below. Exit code 1: some
# is under the GPL.
set -euo pipefail

only_gpl=0 with_users=0
case ${1:-} in
  --gpl) only_gpl=1 ;;
  --users) with_users=1 ;;
esac
if ((only_gpl + with_users)); then shift; fi
if (($# == 0)); then
  echo "usage: tests/licences.sh [--gpl|--users] FILE..." >&2
  exit 2
fi

# Where the library has another licence than most of its sources, as the same copyright files say further down.
declare -A known=(
  [libblkid1]="LGPL-2.1+" [libmount1]="LGPL-2.1+" [libuuid1]="BSD-3-Clause" [libcom-err2]="MIT" [libkeyutils1]="LGPL-2+"
  [libltdl7]="LGPL-2+" [libmariadb3]="LGPL-2.1+" [libdw1]="LGPL-3+ or GPL-2+" [libelf1]="LGPL-3+ or GPL-2+"
  [libidn2-0]="LGPL-3+ or GPL-2+"
  [libcholmod3]="GPL-2+ (modules MatrixOps, Modify, Supernodal; LGPL-2.1+ otherwise)" [libspqr2]="GPL-2+"
)
# Debian configures FFmpeg with --enable-gpl.
for library in avcodec59 avformat59 avutil57 swresample4 swscale6; do known[lib$library]="GPL-2+ (FFmpeg with --enable-gpl)"; done

licence_of() {
  local copyright=/usr/share/doc/$1/copyright found
  if [[ -v known[$1] ]]; then
    echo "${known[$1]}"
    return
  fi
  found=$(awk '/^Files:/ { all = $2 == "*" } all && sub(/^License: */, "") { print; exit }' "$copyright")
  # A file that is not written for machines: of those in question none is under the GPL alone.
  echo "${found:-see $copyright}"
}

# Under the GPL without a choice of another.
is_gpl() {
  [[ $1 =~ (^|[^L])GPL ]] && ! [[ $1 =~ LGPL-[0-9.+]+\ or|or\ LGPL|MPL|BSD-3-clause\ or|Apache.*or ]]
}

needed_of() { objdump -p "$1" | awk '$1 == "NEEDED" { print $2 }'; }

declare -A package_of_name=() package_of_path=() path_of_name=() direct=() users=()
while read -r name path; do path_of_name[$name]=$(realpath "$path"); done < <(ldd "$@" | awk '$2 == "=>" && $3 ~ /^\// { print $1, $3 }' | sort -u)
# One search for all of them. Libraries stand in /usr/lib but may be recorded in /lib.
while IFS=: read -r package _ path; do package_of_path[/usr${path#/usr}]=$package; done < <(
  dpkg -S "${path_of_name[@]}" "${path_of_name[@]#/usr}" 2>/dev/null | sed 's/: /:/; s/^\([^:]*\):\//\1::\//'
)
for name in "${!path_of_name[@]}"; do
  path=${path_of_name[$name]}
  package_of_name[$name]=${package_of_path[/usr${path#/usr}]:-}
done
for file in "$@"; do
  for name in $(needed_of "$file"); do direct[${package_of_name[$name]:-none}]=1; done
done
for user in "${!path_of_name[@]}"; do
  for name in $(needed_of "${path_of_name[$user]}"); do
    package=${package_of_name[$name]:-}
    if [[ -n $package && $package != "${package_of_name[$user]}" && " ${users[$package]:-} " != *" ${package_of_name[$user]} "* ]]; then
      users[$package]+=" ${package_of_name[$user]}"
    fi
  done
done

found_gpl=0
while read -r package; do
  licence=$(licence_of "$package")
  gpl=0
  if is_gpl "$licence"; then gpl=1 found_gpl=1; fi
  if ((only_gpl && !gpl)); then continue; fi
  how=indirect
  if [[ -v direct[$package] ]]; then how=direct; fi
  if ((with_users)); then
    printf '%s\t%s\t%s\t%s\n' "$package" "$how" "${licence//$'\t'/ }" "$(xargs -n1 <<<"${users[$package]:-}" | sort | xargs)"
    continue
  fi
  printf '%-32s %-9s %s' "$package" "$how" "$licence"
  if ((only_gpl)) && [[ $how == indirect ]]; then printf '; used by%s' "${users[$package]:-}"; fi
  echo
done < <(printf '%s\n' "${package_of_name[@]}" | sed '/^$/d' | sort -u)
exit "$found_gpl"
