#!/usr/bin/env bash
# Installs the Debian packages that Percale needs and that are missing, by name.
#   scripts/setup.sh build     what building takes
#   scripts/setup.sh test      that, and what the tests take
#   scripts/setup.sh demo      that of build, and a real scan to try it on
set -euo pipefail

build=(gcc cmake ninja-build pkg-config ocl-icd-opencl-dev opencl-c-headers pocl-opencl-icd libhdf5-dev libmetis-dev
       libpng-dev zlib1g-dev libdeflate-dev scdoc)
test=(g++ libcmocka-dev clang clang-format clang-tidy libclang-rt-dev libomp-dev hdf5-tools git
      python3 python3-numpy python3-h5py python3-vtk9 python3-gmsh)
demo=(libcgal-demo)

case "${1:-build}" in
build) wanted=("${build[@]}") ;;
test) wanted=("${build[@]}" "${test[@]}") ;;
demo) wanted=("${build[@]}" "${demo[@]}") ;;
*) echo "usage: $0 [build|test|demo]" >&2; exit 2 ;;
esac

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "$0: this is not a Debian system; install by hand what these packages hold: ${wanted[*]}" >&2
    exit 1
fi

missing=()
for package in "${wanted[@]}"; do
    state=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
    [[ $state == installed* ]] || missing+=("$package")
done
[[ ${#missing[@]} -eq 0 ]] && exit 0

as_root=()
if [[ $(id -u) -ne 0 ]]; then
    command -v sudo >/dev/null || { echo "$0: run as root, or install: ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
fi
echo "installing ${missing[*]}"
"${as_root[@]}" apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}"
