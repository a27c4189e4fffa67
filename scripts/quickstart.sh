#!/usr/bin/env bash
# Installs what is missing, builds Percale, and converts a scan: the one given, else one from a Debian package.
#   scripts/quickstart.sh [SCAN [OPTIONS OF percale convert]]
set -euo pipefail
scan=${1:+$(realpath -- "$1")}
[[ $# -gt 0 ]] && shift
cd "$(dirname "$0")/.."

if [[ -n $scan ]]; then scripts/setup.sh build; else scripts/setup.sh demo; fi

cmake --preset release -DPERCALE_TESTS=OFF -DPERCALE_BENCH=OFF -B build/quickstart
cmake --build build/quickstart

if [[ -z $scan ]]; then
    # The Stanford bunny, closed, 75,408 triangles.
    set -- --quads 5k
    scan=$PWD/build/bunny.off
    archive=$(dpkg-query -L libcgal-demo | grep '/data\.tar\.gz$')
    if [[ ! -f $archive ]]; then
        # Small Debian images install no documentation; the package itself still holds the archive.
        (cd build && apt-get download libcgal-demo && dpkg-deb -x libcgal-demo_*.deb cgal-demo)
        archive=build/cgal-demo$archive
    fi
    tar -xzf "$archive" -O data/meshes/bunny00.off >"$scan"
fi
name=$(basename "$scan")
name=${name%.gz}
out=out/${name%.*}
status=0
build/quickstart/percale convert "$scan" -o "$out" --force "$@" || status=$?
# 5: all outputs are there, and the message says what the result misses.
[[ $status -eq 0 || $status -eq 5 ]] || exit $status
echo
echo "The results are in $out: quads.obj, result.h5, report.json and pictures."
exit $status
