#!/usr/bin/env python3
"""Distortion of the parameterization beside the table F.1 of the thesis.

usage: distortion_table.py [--percale PROGRAM] [--commit C] [--keep FOLDER] SCAN... > table.md
Converts each SCAN twice, with sides of ten mean edges (the thesis's size), without and with --curl-correction, reads
report.json and prints a table in markdown. Needs Python's standard library only.
"""
import argparse
import datetime
import json
import os
import pathlib
import platform
import shlex
import subprocess
import sys
import tempfile

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
OPTIONS = ["--ngons", "keep", "--edge-factor", "10", "--no-pictures", "--force", "--quiet"]


def machine():
    """Processor, cores, memory and load, in words."""
    name = platform.machine()
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        name = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), name)
    except OSError:
        pass
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    load = os.getloadavg()[0]
    return f"{name}, {os.cpu_count()} cores, {memory:.0f} GiB; load {load:.1f} when the runs began"


def commit_of_tree():
    here = pathlib.Path(__file__).resolve().parent
    run = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=here, capture_output=True, text=True, check=False)
    return run.stdout.strip() or "unknown"


def convert(program, scan, curl, folder):
    """The report of one run, with its exit code; None where there is none."""
    command = [program, "convert", scan, "-o", str(folder)] + OPTIONS + (["--curl-correction"] if curl else [])
    print(shlex.join(command), file=sys.stderr, flush=True)
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    print(run.stderr, end="", file=sys.stderr)
    path = pathlib.Path(folder, "report.json")
    if run.returncode not in (0, 5) or not path.exists():
        return None
    return json.loads(path.read_text(encoding="utf-8"))


def facts(report, stage, name):
    return next((s["facts"].get(name) for s in report["stages"] if s["name"] == stage), None)


def figure(value, form):
    return "-" if value is None else format(value, form)


def row_of(scan, curl, report):
    name = pathlib.Path(scan).name.split(".")[0]
    model = f"{name} ({SAME.get(name, 'another model')})"
    method = "Percale, --curl-correction" if curl else "Percale"
    if report is None:
        return [model, "-", method] + ["failed"] + ["-"] * 8
    p = report["statistics"]["parameterization"]
    triangles = facts(report, "scan", "repair")["faces"]
    failed = [check["name"] for check in report["certificate"]["checks"] if not check["passed"]]
    cpu = sum(stage["cpu_seconds"] for stage in report["stages"])
    return [model, f"{triangles:,}", method, figure(p.get("stretch"), ".3f"), figure(p.get("stretch_core"), ".3f"),
            figure(p.get("shear"), ".4f"), figure(p.get("singular_percent"), ".2f"),
            figure(facts(report, "param", "finest_scale"), ".2f"), f"{report['statistics']['quads']['faces']:,}",
            "fails: " + ", ".join(failed) if failed else "passed", figure(report["seconds"], ".1f"), figure(cpu, ".1f")]


def thesis_rows():
    for model, triangles, *pair in THESIS:
        for method, (stretch, shear, seconds) in zip(("PGP", "ccPGP"), pair):
            yield [f"*{model}*", f"*{triangles}*", f"*thesis, {method}*", f"*{stretch}*", "-", f"*{shear}*"] + ["-"] * 4 + [
                f"*{seconds}*", "-"]


def print_table(rows):
    """Without the columns that no row fills."""
    head = ["model", "triangles", "method", "stretch", "stretch of 99 %", "shear", "singular %", "finest scale", "cells",
            "certificate", "s", "CPU s"]
    used = [k for k in range(len(head)) if any(row[k] != "-" for row in rows)]
    head, rows = [head[k] for k in used], [[row[k] for k in used] for row in rows]
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * 3 + "---:|" * (len(head) - 3))
    for row in rows:
        print("| " + " | ".join(row) + " |")


INTRODUCTION = """# Distortion of the parameterization

Made by `scripts/distortion_table.py`. Rows in *italics* are table F.1 of the thesis (Li 2006), copied, on the thesis's own models
and its machine of 1.7 GHz; they were not measured here. **The models differ**: only the bunny and the camel's head show a shape
that is also in the table, at another resolution, and of the camel only the head. So the rows stand beside each other to show the
range of the figures, not as a race.
"""

LEGEND = """
stretch: normalised L2 stretch over all triangles that are not singular, 1 for an isometry of any scale; a handful of nearly
collapsed triangles can make it large. stretch of 99 %, if there: without the most stretched triangles, 1 % of the area. shear: mean
|cos| of the angle between the two parameter directions, 0 where they are square to each other. singular %: share of triangles that
are singular or flipped. finest scale: how many times smaller than ten mean edges the smallest wanted cell is, where Percale refined
because cells would have lost the scan; the thesis's cells are all of one size without curl correction, so Percale's stretch rises
for this alone where it is above 1. cells: faces of the result, of any number of sides. certificate: the checks that the result
fails, if any; cells of ten mean edges are large for scans of this size. s and CPU s: the whole run, from reading the scan to writing
the files. The thesis does not define its stretch and shear; these are the usual readings of the words.
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scans", nargs="+", metavar="SCAN")
    parser.add_argument("--percale", default="percale", help="the program (default: percale in the PATH)")
    parser.add_argument("--commit", default=commit_of_tree(), help="what the program was built from")
    parser.add_argument("--keep", help="a folder for the results of the runs (default: none are kept)")
    args = parser.parse_args()
    where = machine()
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        for scan in args.scans:
            for curl in (False, True):
                folder = pathlib.Path(args.keep or scratch, pathlib.Path(scan).name + ("-curl" if curl else ""))
                folder.parent.mkdir(parents=True, exist_ok=True)
                rows.append(row_of(scan, curl, convert(args.percale, scan, curl, folder)))
    print(INTRODUCTION)
    print(f"* date: {datetime.date.today()}\n* machine: {where}; shared with other work while this ran, so times are rough\n"
          f"* commit: {args.commit}\n* command of each run: `percale convert SCAN -o OUT {shlex.join(OPTIONS)}`, and with "
          "`--curl-correction`\n")
    print_table(rows + list(thesis_rows()))
    print(LEGEND, end="")


if __name__ == "__main__":
    main()
