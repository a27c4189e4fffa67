#!/usr/bin/env python3
"""Distortion of the parameterization beside the table F.1 of the thesis.

usage: distortion_table.py [--bench PROGRAM] [--commit C] SCAN... > table.md
Runs bench_pgp (build/release/bench/bench_pgp) on each SCAN with cells of ten mean edges (the thesis's size), without and with curl
correction, and prints a table in markdown. Needs Python's standard library only.
"""
import argparse
import datetime
import json
import pathlib
import shlex
import subprocess
import sys

from provenance import commit_of_tree, machine

# Li, thesis, table F.1: model, triangles, then stretch, shear and seconds of PGP and of ccPGP, on a machine of 1.7 GHz.
THESIS = [
    ("Horse", "20K", ("1.07", "0.20", "45"), ("1.176", "0.12", "53")),
    ("Bunny", "25K", ("1.029", "0.167", "58"), ("1.14", "0.14", "72")),
    ("Bull", "34.5K", ("1.064", "0.1774", "86"), ("1.209", "0.0885", "95")),
    ("Camel", "78K", ("1.048", "0.1596", "346"), ("1.654", "0.0711", "411")),
    ("David", "200K", ("1.121", "0.2398", "1055"), ("1.270", "0.1310", "1243")),
    ("Lion", "400K", ("1.123", "0.1728", "2022"), ("1.425", "0.0826", "2718")),
]
# Scans that show a model of the table; all others are other models.
SAME = {"stanford-bunny": "Bunny, at another resolution", "camelhead": "the head only of Camel"}
OPTIONS = ["--edge-factor", "5", "--pgp", "normalise"]  # half a period, in mean edges: cells of ten, as in the thesis


def measure(program, scan, curl, reach):
    """The figures of one run; None where it failed."""
    command = [program, scan] + OPTIONS + ["--curl", "on" if curl else "off", "--cancel", reach]
    print(shlex.join(command), file=sys.stderr, flush=True)
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    print(run.stderr, end="", file=sys.stderr)
    return json.loads(run.stdout) if run.returncode == 0 else None


def row_of(scan, curl, reach, figures):
    name = pathlib.Path(scan).name.split(".")[0]
    model = f"{name} ({SAME[name]})" if name in SAME else name
    method = ("PGP" if reach == "0" else "Percale") + (", curl correction" if curl else "")
    if figures is None:
        return [model, "-", method, "failed"] + ["-"] * 7
    return [model, f"{figures['triangles']:,}", method, f"{figures['stretch']:.3f}", f"{figures['stretch_core']:.3f}",
            f"{figures['shear']:.4f}", f"{figures['singular_percent']:.2f}", str(figures["raw_dislocations"]),
            str(figures["dislocations"]), str(figures["irregular"]), f"{figures['param_cpu_seconds']:.1f}"]


def thesis_rows():
    for model, triangles, *pair in THESIS:
        for method, (stretch, shear, seconds) in zip(("PGP", "ccPGP"), pair):
            yield [f"*{model}*", f"*{triangles}*", f"*thesis, {method}*", f"*{stretch}*", "-", f"*{shear}*"] + ["-"] * 4 + [f"*{seconds}*"]


def print_table(rows):
    """Without the columns that no row fills."""
    head = ["model", "triangles", "method", "stretch", "stretch of 99 %", "shear", "singular %", "dislocations of PGP",
            "dislocations left", "irregular vertices", "s"]
    used = [k for k in range(len(head)) if any(row[k] != "-" for row in rows)]
    head, rows = [head[k] for k in used], [[row[k] for k in used] for row in rows]
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * 3 + "---:|" * (len(head) - 3))
    for row in rows:
        print("| " + " | ".join(row) + " |")


INTRODUCTION = """# Distortion of the parameterization

Made by `bench/distortion_table.py`, which runs `bench_pgp` on each scan four times: cells of ten mean edges, all of one size as
far as the field lets them (no local refinement), without and with curl correction; `PGP` is the thesis's method, `Percale` cancels
dislocations after it as the program does. Rows in *italics* are table F.1 of the thesis (Li 2006; its table 3.1 is the same without
ccPGP), copied, on the thesis's own models and its machine of 1.7 GHz; they were not measured here. **The models differ**: only
the bunny and the camel's head show a shape that is also in the table, at another resolution, and of the camel only the head. So the
rows stand beside each other to show the range of the figures, not as a race.
"""

LEGEND = """
stretch: normalised L2 stretch over all triangles that are not singular, 1 for an isometry of any scale; a handful of nearly
collapsed triangles, most of them beside a cone, can make it large. stretch of 99 %: without the most stretched triangles, 1 % of the
area. shear: mean |cos| of the angle between the two parameter directions, 0 where they are square to each other. singular %: share of
triangles that are singular or flipped. irregular vertices: of the quads, cells split. s: CPU seconds of the parameterization (the
thesis's are of its machine). The thesis does not define its stretch and shear; these are the usual readings of the words.

Curl correction does what it is for: it takes most of PGP's dislocations away, on a torus, where nothing else stands in the way, all of
them, and there shear falls from 0.058 to 0.008. It makes cells up to four times as long, so that on scans of this size (a few hundred
cells, a cone every few cells) more of the surface lies within a cell of a cone, where no cell is square; there shear can rise.
Cancelling dislocations removes what curl correction would have removed, at equal cells, and is the program's default.
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scans", nargs="+", metavar="SCAN")
    parser.add_argument("--bench", default="build/release/bench/bench_pgp")
    parser.add_argument("--commit", default=commit_of_tree(), help="what the program was built from")
    args = parser.parse_args()
    where = machine("when the runs began")
    rows = []
    for scan in args.scans:
        for reach in ("0", "8"):
            for curl in (False, True):
                rows.append(row_of(scan, curl, reach, measure(args.bench, scan, curl, reach)))
    print(INTRODUCTION)
    print(f"* date: {datetime.date.today()}\n* machine: {where}; shared with other work while this ran, so times are rough\n"
          f"* commit: {args.commit}\n* command of each run: `bench_pgp SCAN {shlex.join(OPTIONS)} --curl off|on --cancel 0|8`\n")
    print_table(rows + list(thesis_rows()))
    print(LEGEND, end="")


if __name__ == "__main__":
    main()
