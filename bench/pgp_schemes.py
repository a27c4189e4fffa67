#!/usr/bin/env python3
"""The outer schemes of PGP beside each other, on scans and on shapes of the generator.

usage: pgp_schemes.py [--bench PROGRAM] [--commit C] [--pgp A,B,...] SCAN|SHAPE... > table.md
Runs bench_pgp (build/release/bench/bench_pgp) on each and prints a table in markdown. Standard library only.
"""
import argparse
import datetime
import json
import os
import pathlib
import subprocess
import sys

from provenance import commit_of_tree, machine

COLUMNS = [("raw_dislocations", "dislocations of PGP"), ("raw_flipped", "flipped by PGP"), ("cones", "cones"),
           ("dislocations", "dislocations left"), ("flipped", "flipped left"), ("energy", "energy"), ("quads", "quads"),
           ("irregular", "irregular vertices"), ("steps", "steps"), ("iterations", "iterations"),
           ("pgp_cpu_seconds", "CPU s of PGP"), ("param_cpu_seconds", "CPU s of all")]

INTRODUCTION = """# The outer schemes of PGP

Made by `bench/pgp_schemes.py`, which runs `bench_pgp` on each scan: one field, then each scheme from the same random start, the steps
after PGP, layout and quads as the program makes them without any wish for a size, but without local refinement.
"""

LEGEND = """
`normalise`: the default, twelve normalise-and-solve steps of reach 8 to 0.7 periods to a residual of 1e-2, the last to 1e-4.
`normalise:6:8:0.7:1e-2`: six steps to 1e-2, the last to 1e-4. `newton`: the thesis's penalty and Newton's method. Dislocations,
flipped and cones are triangles, after PGP alone and after cancelling, integration and untangling ("left"); what cones there are is the
field's doing. energy: sum of weight * |M^r X_j - D X_i|^2 over the edges, all norms 1; what Newton minimises is another function. irregular
vertices: inner vertices of the quads whose number of quads is not 4. iterations: of the multigrid solver. CPU s of all: PGP and
everything until the coordinates are done, without layout and quads.
"""


def rows_of(program, scan, schemes):
    run = subprocess.run([program, scan, "--pgp", schemes], capture_output=True, text=True, check=False)
    print(run.stderr, end="", file=sys.stderr)
    return [json.loads(line) for line in run.stdout.splitlines()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scans", nargs="+", metavar="SCAN|SHAPE")
    parser.add_argument("--bench", default="build/release/bench/bench_pgp")
    parser.add_argument("--commit", default=commit_of_tree(), help="what the program was built from")
    parser.add_argument("--pgp", default="normalise,normalise:6:8:0.7:1e-2,newton")
    args = parser.parse_args()
    print(INTRODUCTION)
    where = machine("when the runs began; shared with other work")
    print(f"* date: {datetime.date.today()}\n* machine: {where}\n* commit: {args.commit}\n* threads: "
          f"{os.environ.get('OMP_NUM_THREADS', 'all')}\n")
    print("| scan | triangles | scheme | " + " | ".join(title for _, title in COLUMNS) + " |")
    print("|---|---:|---|" + "---:|" * len(COLUMNS), flush=True)
    sums = {}
    for scan in args.scans:
        for row in rows_of(args.bench, scan, args.pgp):
            name = pathlib.Path(scan).name.split(".")[0]
            print(f"| {name} | {row['triangles']:,} | {row['scheme']} | " + " | ".join(f"{row[key]:,}" for key, _ in COLUMNS) +
                  " |", flush=True)
            total = sums.setdefault(row["scheme"], dict.fromkeys((key for key, _ in COLUMNS), 0))
            for key in total:
                total[key] += row[key]
    for scheme, total in sums.items():
        print(f"| **all** | | {scheme} | " + " | ".join(f"{round(total[key], 1):,}" for key, _ in COLUMNS) + " |")
    print(LEGEND, end="")


if __name__ == "__main__":
    main()
