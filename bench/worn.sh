#!/usr/bin/env bash
# Scans that no setting was tuned on: shapes of the generator, and the scans of DATA worn, torn and refined.
# usage: worn.sh BENCH_SYNTH DATA FOLDER; then bench/scans.py FOLDER/*.ply -- --tolerance 0.3% > table.md
set -euo pipefail
if [ $# -ne 3 ]; then
    sed -n '2,3s/^# //p' "$0" >&2
    exit 2
fi
synth=$1 data=$2 folder=$3
mkdir -p "$folder"

make() { # NAME ARGUMENTS...
    "$synth" "${@:2}" -o "$folder/$1.ply" > /dev/null
}

make sphere-noise sphere --faces 20000 --noise 0.05
make torus-noise torus --faces 30000 --noise 0.05 --seed 3
make cylinder cylinder --faces 20000
make plane-ripple plane --faces 10000 --ripple 1
make cube cube --faces 20000
make vase-noise vase --faces 30000 --noise 0.05
make vase-needles vase --faces 8000 --subdivide 1 --needles 0.05
make blob-noise blob --genus 3 --faces 40000 --noise 0.05
make blob-holes blob --genus 0 --faces 30000 --ripple 0.5 --holes 5
make rocker-arm-noise "$data/rocker-arm.obj" --noise 0.1 --seed 5
make spot-holes "$data/spot.obj" --holes 6 --seed 2
make fandisk-fine "$data/fandisk.off" --subdivide 1 --noise 0.05
make fertility-fine "$data/fertility.off" --subdivide 1 --ripple 0.3
make bunny-needles "$data/stanford-bunny.obj" --needles 0.02 --shuffle
make max-twice "$data/decimated-max.obj" --copies 2
make wingnut-holes "$data/wingnut.obj" --subdivide 1 --holes 4
make botijo-soup "$data/botijo.obj" --noise 0.15 --seed 9 --unweld
make bunny-holes "$data/stanford-bunny.obj" --holes 8 --seed 31
make fertility-holes "$data/fertility.off" --holes 6 --seed 32
make vase-holes vase --faces 20000 --holes 8 --seed 33
make rocker-arm-holes "$data/rocker-arm.obj" --holes 5 --noise 0.05 --seed 34
make camelhead-holes "$data/camelhead.off" --holes 6 --seed 35
make max-holes "$data/decimated-max.obj" --subdivide 1 --holes 10 --seed 36
make nefertiti-shuffle "$data/nefertiti-lowres.obj" --shuffle --ripple 0.2 --seed 37
make beast-noise "$data/beast.obj" --noise 0.05 --seed 38
