#!/usr/bin/env bash
# The plan of a site on a real Slurm: one node, this machine, in a folder of its own. Not part of the tests, because it
# needs Debian's slurm-wlm and munge and half a minute; skipped with a message where these are missing.
#   tests/app/site/slurm.sh [CEILMAP]
# With a program beside CEILMAP that stands for it and fails for one recording in its first run: the arrays, their
# dependencies, a second submission that makes what is missing, and an end by scancel.
set -euo pipefail

ceilmap=$(realpath -- "${1:-build/release/app/ceilmap}")
for program in sbatch slurmctld slurmd munged mungekey; do
  if ! command -v "$program" >/dev/null; then
    echo "slurm.sh: skipped: $program is missing; apt-get install slurm-wlm munge"
    exit 0
  fi
done

folder=$(mktemp -d)
chmod 755 "$folder"
host=$(hostname -s)
finish() {
  for name in slurmd slurmctld munged; do
    if [[ -e $folder/$name.pid ]]; then kill "$(cat "$folder/$name.pid")" 2>/dev/null || true; fi
  done
  sleep 1
  rm -rf "$folder"
}
trap finish EXIT
fail() {
  echo "slurm.sh: $*" >&2
  tail -n 20 "$folder"/*.log >&2 || true
  exit 1
}

mkdir -m 700 "$folder/state" "$folder/spool" "$folder/munge"
mkdir -m 755 "$folder/run"
mungekey --create --keyfile "$folder/munge/key"
munged --key-file "$folder/munge/key" --socket "$folder/run/munge" --pid-file "$folder/munged.pid" \
  --log-file "$folder/munge/log" --seed-file "$folder/munge/seed" --force
cat >"$folder/slurm.conf" <<END
ClusterName=ceilmap
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$((20000 + RANDOM % 10000))
SlurmdPort=$((30000 + RANDOM % 2000))
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$folder/run/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=0
KillWait=5
MinJobAge=300
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES State=UP
END
export SLURM_CONF=$folder/slurm.conf
slurmctld
slurmd || fail "slurmd does not start"
for _ in $(seq 50); do
  if sinfo -h -o %T 2>/dev/null | grep -q idle; then break; fi
  sleep 0.2
done
sinfo -h -o %T | grep -q idle || fail "no node"

# The site: three recordings and a program that writes its words and inputs to its -o file.
site=$folder/site
mkdir "$site"
cd "$site"
touch rig.yaml "it's \$HOME #1.mp4" b.mp4 c.mp4
cat >site.yaml <<'END'
output: site.gpkg
recordings:
  - {name: a, rig: rig.yaml, up: "it's $HOME #1.mp4"}
  - {name: b, rig: rig.yaml, up: b.mp4}
  - {name: c, rig: rig.yaml, up: c.mp4}
options: {map: [--word, "$(touch hacked) '"]}
END
cat >stand-in <<'END'
#!/bin/sh
for word; do
  case $before in -o) output=$word ;; esac
  before=$word
done
case $* in *up=b.mp4*) if [ ! -e allowed ]; then echo "ceilmap: no ceiling" >&2; exit 1; fi ;; esac
if [ -e slow ]; then trap 'echo part >"$output"; exit 0' TERM INT; touch begun; while :; do sleep 0.1; done; fi
echo "$1" >>ran
for word; do printf '%s\n' "$word"; done >"$output.partial"
mv "$output.partial" "$output"
END
chmod +x stand-in

wait_for_jobs() {
  for _ in $(seq 600); do
    if [[ -z $(squeue -h 2>/dev/null) ]]; then return 0; fi
    sleep 0.2
  done
  squeue >&2
  fail "jobs do not end"
}

"$ceilmap" site plan site.yaml --format sbatch --program ./stand-in -o site.sh --quiet
echo "first submission: the map of b fails"
bash site.sh
wait_for_jobs
[[ $(cat site.work/logs/map-b.log) == "ceilmap: no ceiling" ]] || fail "the log of the failed map"
[[ -e site.work/matches/a--c.edges ]] || fail "the other maps were not matched"
grep -qx -- 'site.work/maps/c.gpkg' site.gpkg || fail "the site lacks c"
if grep -q 'b.gpkg' site.gpkg; then fail "the site has b"; fi

echo "second submission: what is missing"
touch allowed
rm -f ran
bash site.sh
wait_for_jobs
[[ $(sort ran | tr '\n' ' ') == "map match match solve " ]] || fail "made again: $(cat ran)"
grep -qx -- 'site.work/maps/b.gpkg' site.gpkg || fail "the site lacks b"
grep -qxF -- "\$(touch hacked) '" site.work/maps/a.gpkg || fail "a word has changed"
if [[ -e hacked ]]; then fail "a word was run"; fi

echo "the same as by make and by 'site run'"
cp site.gpkg by-slurm.gpkg
find site.work -name '*.gpkg' -o -name '*.edges' | sort | xargs md5sum >by-slurm.md5
rm -r site.work site.gpkg
"$ceilmap" site plan site.yaml --format make --program ./stand-in -o site.mk --quiet
make -s -j 2 -f site.mk >/dev/null
md5sum --quiet -c by-slurm.md5
cmp site.gpkg by-slurm.gpkg
rm -r site.work site.gpkg
"$ceilmap" site run site.yaml --program ./stand-in --quiet
md5sum --quiet -c by-slurm.md5
cmp site.gpkg by-slurm.gpkg

echo "scancel: no part of a result is left"
rm -r site.work site.gpkg
touch slow
bash site.sh >/dev/null
for _ in $(seq 100); do
  if [[ -e begun ]]; then break; fi
  sleep 0.1
done
[[ -e begun ]] || fail "no job has begun"
scancel --user "$(id -un)"
wait_for_jobs
if [[ -n $(find site.work -name '*.gpkg' 2>/dev/null) ]]; then fail "a part of a map is left"; fi
echo "slurm.sh: passed"
