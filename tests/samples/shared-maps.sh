#!/bin/bash
# Runs the commands of "One map for many robots" in samples/GUIDE.md as they are printed, each block alone, as an unprivileged user,
# and checks their results. Usage: shared-maps.sh CEILMAP. A block whose servers are not installed is left out with a message; exit
# status 77 if all are.
set -u
program=$(readlink -f "$1")
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
failed=0

# The block that contains a text, without its indentation.
block() {
  sed -n '/^## 7\./,$p' "$root/samples/GUIDE.md" | awk -v text="$1" '
    /^    / { block = block substr($0, 5) "\n"; next }
    { if (index(block, text)) printf "%s", block; block = "" }
    END { if (index(block, text)) printf "%s", block }'
}

# Runs a block in its own folder and session, whose processes end with it. $1: a text of it; $2: folder; $3: check of its results.
run() {
  local folder=$work/$2
  mkdir "$folder"
  cp "$work/lab.gpkg" "$folder/"
  for file in rig.yaml:rig2.yaml up.mp4:up2.mp4 frames.csv:frames2.csv; do
    cp "$root/samples/lab-second-robot/${file%:*}" "$folder/${file#*:}"
  done
  { echo 'set -eu'; block "$1"; echo "$3"; } > "$folder/recipe.sh"
  local as_user=()
  if [ "$(id -u)" = 0 ]; then
    chown -R nobody "$folder"
    as_user=(runuser -u nobody --)
  fi
  (cd "$folder" && exec env HOME="$folder" CEILMAP_CACHE="$folder/cache" PATH="$work/bin:$PATH" \
    setsid "${as_user[@]}" bash recipe.sh) > "$folder/out" 2> "$folder/err" &
  local session=$!
  wait $session
  local status=$?
  kill -- -$session 2> /dev/null  # the servers; PostgreSQL has a session of its own
  [ ! -e "$folder/db/postmaster.pid" ] || kill -QUIT "$(head -1 "$folder/db/postmaster.pid")"
  if [ $status != 0 ]; then
    echo "the block of '$1' in samples/GUIDE.md fails:" >&2
    cat "$folder/out" "$folder/err" >&2
    failed=1
  fi
}

blocks=
if command -v http-server > /dev/null; then blocks+=' web'; else echo 'left out: http-server is not installed' >&2; fi
if command -v s3rver > /dev/null; then blocks+=' bucket'; else echo 'left out: s3rver is not installed' >&2; fi
if ls /usr/lib/postgresql/*/bin/initdb /usr/share/postgresql/*/extension/postgis.control > /dev/null 2>&1; then
  blocks+=' database'
else
  echo 'left out: PostgreSQL with PostGIS is not installed' >&2
fi
[ -n "$blocks" ] || exit 77

chmod 755 "$work"
mkdir "$work/bin"
ln -s "$program" "$work/bin/ceilmap"
sample=$root/samples/lab-map
"$program" map --quiet --rig "$sample/rig.yaml" --up "$sample/up.mp4" --stamps "$sample/frames.csv" -o "$work/lab.gpkg" || exit 1

if [[ $blocks == *web* ]]; then
  run http-server web '
    ceilmap localize lab.gpkg --quiet --rig rig2.yaml --up up2.mp4 --stamps frames2.csv -o here.tum
    cmp second.tum here.tum
    test -s cache/maps.sqlite'
fi
if [[ $blocks == *bucket* ]]; then
  run s3rver bucket-of-maps '
    ceilmap info lab.gpkg --json > here.json
    ceilmap info /vsis3/maps/lab.gpkg --json | cmp - here.json'
fi
if [[ $blocks == *database* ]]; then
  # Ten robots at a time; then their password must not be shown.
  run initdb database '
    for i in 0 1 2 3 4 5 6 7 8 9; do
      ceilmap export lab.gpkg --quiet --format postgis --name "robot $i" -o "PG:host=$PWD/db user=site dbname=site" & writers="${writers:-} $!"
    done
    for writer in $writers; do wait $writer; done
    counts=$(psql -At -h $PWD/db -U site site -c "SELECT count(DISTINCT map_id), count(*) / 11.0 = (SELECT count(*) FROM ceilmap.edges WHERE map_id = (SELECT min(id) FROM ceilmap.maps)) FROM ceilmap.edges")
    test "$counts" = "11|t"
    ceilmap export lab.gpkg --format postgis --force --summary s.json -o "PG:host=$PWD/db user=site dbname=site password=secret" > said 2>&1
    ! grep secret said s.json
    test -s lab.tif
    pg_ctl -D db -m immediate stop'
fi
rm -rf "$work"
exit $failed
