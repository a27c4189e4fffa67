#!/usr/bin/env bash
# Installs what the tests need, builds, and runs every check: format, sanitizers, clang-tidy, and ctest last.
# PERCALE_DATA names a folder with scans (default ../shared/data); tests that want one are skipped without it.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh test
export PERCALE_DATA=${PERCALE_DATA:-$(realpath -m ../shared/data)}
jobs=$(nproc)

echo "== format"
git ls-files -z '*.c' '*.h' | xargs -0 clang-format --dry-run --Werror

echo "== build"
cmake --preset release
cmake --build build/release -j "$jobs"

echo "== unit tests with the address and undefined-behaviour sanitizers"
cmake --preset asan
cmake --build build/asan -j "$jobs"
ctest --test-dir build/asan -L unit --output-on-failure --no-tests=error --timeout 600

echo "== clang-tidy"
cmake --preset tidy -DPERCALE_BENCH=OFF -DPERCALE_TESTS=OFF
cmake --build build/tidy -j "$jobs"

echo "== all tests"
ctest --test-dir build/release --output-on-failure --no-tests=error --schedule-random
