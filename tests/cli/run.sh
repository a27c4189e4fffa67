#!/usr/bin/env bash
# Runs the test NAME.sh in an empty folder and compares what it prints and its exit code with NAME.stdout, NAME.stderr
# and NAME.exit beside it.   PERCALE=program tests/cli/run.sh NAME   (REFRESH=1 writes the expectations instead)
set -u
: "${PERCALE:?is the program to test}"
export here; here=$(cd "$(dirname "$0")" && pwd)
name=$1
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
mkdir work && cd work || exit 1
bash "$here/$name.sh" >../stdout 2>../stderr
code=$?
if [[ $code -eq 77 ]]; then cat ../stdout; exit 77; fi
if [[ -n ${REFRESH:-} ]]; then
    cp ../stdout "$here/$name.stdout"
    cp ../stderr "$here/$name.stderr"
    echo $code >"$here/$name.exit"
    exit 0
fi
status=0
diff -u "$here/$name.stdout" ../stdout || status=1
diff -u "$here/$name.stderr" ../stderr || status=1
[[ $code -eq $(<"$here/$name.exit") ]] || { echo "exit code $code, not $(<"$here/$name.exit")"; status=1; }
exit $status
