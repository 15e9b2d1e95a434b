#!/bin/bash
# A PostgreSQL server of a test's own, with PostGIS, without a network port and without passwords. Its
# data and its socket are in FOLDER, which must be empty; as root it runs as the user nobody.
#   postgres.sh start FOLDER     the server; user postgres, database site (with PostGIS) and plain (without)
#   postgres.sh stop FOLDER
# Exit status 77 and a message where PostgreSQL or PostGIS is not installed.
set -eu
action=$1 folder=$2
bin=$(ls -d /usr/lib/postgresql/*/bin 2>/dev/null | sort -V | tail -1)
[ -n "$bin" ] || bin=$(dirname "$(command -v initdb || echo /nowhere/initdb)")
if ! [ -x "$bin/initdb" ] || ! ls /usr/share/postgresql/*/extension/postgis.control > /dev/null 2>&1; then
  echo "PostgreSQL with PostGIS is not installed (Debian: postgresql-postgis)" >&2
  exit 77
fi
as_user=()
[ "$(id -u)" != 0 ] || as_user=(runuser -u nobody --)
cd /
if [ "$action" = stop ]; then
  "${as_user[@]}" "$bin/pg_ctl" -D "$folder/data" -m immediate stop > /dev/null
  exit
fi
[ "$(id -u)" != 0 ] || chown nobody "$folder"
"${as_user[@]}" "$bin/initdb" -D "$folder/data" -U postgres -A trust -E UTF8 --no-locale --no-sync > /dev/null
"${as_user[@]}" "$bin/pg_ctl" -D "$folder/data" -w -l "$folder/log" \
  -o "-k $folder -c listen_addresses= -c fsync=off" start > /dev/null
"$bin/psql" -q -h "$folder" -U postgres -c 'CREATE DATABASE site' -c 'CREATE DATABASE plain' postgres
"$bin/psql" -q -h "$folder" -U postgres -c 'CREATE EXTENSION postgis' site
