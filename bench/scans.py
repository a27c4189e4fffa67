#!/usr/bin/env python3
"""What `percale convert` makes of scans when nothing is asked for: a table in markdown.

usage: scans.py [--percale PROGRAM] [--commit C] SCAN... [-- OPTIONS OF percale convert] > table.md
The figures are those of each run's report.json. Standard library only.
"""
import argparse
import datetime
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

HEAD = ("scan", "triangles", "exit code", "quads", "irregular", "field singularities", "tries",
        "distance: mean, largest (% of the diagonal)", "seconds", "CPU s", "peak, MB", "what the result misses")

SPLINE_HEAD = ("control points", "largest distance of the spline, %", "rounds", "spline, seconds",
               "jump of the normals at spokes: mean, largest, degrees")

INTRODUCTION = """# Scans converted at the defaults

Made by `bench/scans.py`. Irregular: inner vertices without four quads. Tries: parameterizations made, for places that wanted finer
cells. Distance: of points of the scan to the quads. Seconds: of the whole process, from the file to all that it writes. Peak: the
most memory that a stage took. Spokes: edges of a spline that leave extraordinary vertices.
"""


def cpu_of_children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def row(program, scan, options, folder):
    wall, cpu = time.perf_counter(), cpu_of_children()
    run = subprocess.run([program, "convert", scan, "-o", folder, "--no-pictures", "-q", *options], check=False,
                         capture_output=True, text=True)
    wall, cpu = time.perf_counter() - wall, cpu_of_children() - cpu
    name = pathlib.Path(scan).name
    path = pathlib.Path(folder, "report.json")
    if not path.exists():
        return (name, "", run.returncode, *[""] * (len(HEAD) - 4), run.stderr.strip().split(": ", 2)[-1])
    report = json.loads(path.read_text(encoding="utf-8"))
    stages = {stage["name"]: stage for stage in report["stages"]}
    facts, figures = stages["param"]["facts"], report["statistics"]
    distance = figures["distance_scan_to_quads"]
    missed = [check["name"] for check in report["certificate"]["checks"] if not check["passed"]]
    return (name, f"{stages['scan']['facts']['faces']:,}", run.returncode, f"{figures['quads']['faces']:,}",
            figures["irregular_interior_vertices"], facts["field_singularities"], facts["tries"],
            f"{100 * distance['mean']:.3f}, {100 * distance['max']:.2f}",
            f"{wall:.1f}", f"{cpu:.1f}",
            f"{max(stage['peak_bytes'] for stage in report['stages']) / 1e6:,.0f}", ", ".join(missed),
            *spline_cells(stages, figures))


def spline_cells(stages, figures):
    if "spline" not in stages:
        return ()
    facts, spoke = stages["spline"]["facts"], figures["spline"]["jumps"]["spoke"]
    return (f"{facts['control_points']:,}", f"{100 * figures['spline']['distance']['max']:.3f}", facts["rounds"],
            f"{stages['spline']['seconds']:.1f}", f"{spoke['normal_mean_degrees']:.2f}, {spoke['normal_max_degrees']:.0f}")


def main():
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    arguments, options = sys.argv[1:split], sys.argv[split + 1:]
    parser = argparse.ArgumentParser()
    parser.add_argument("--percale", default="build/release/percale")
    parser.add_argument("--commit", default="unknown")
    parser.add_argument("scan", nargs="+")
    chosen = parser.parse_args(arguments)
    print(INTRODUCTION)
    print(f"{datetime.date.today()}, commit {chosen.commit}, {os.cpu_count()} CPUs, load {os.getloadavg()[0]:.1f} at the start"
          + (f", options `{' '.join(options)}`" if options else "") + ".\n")
    head = HEAD + (SPLINE_HEAD if "--tolerance" in options else ())
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head), flush=True)
    for scan in chosen.scan:
        with tempfile.TemporaryDirectory() as folder:
            cells = row(chosen.percale, scan, options, os.path.join(folder, "out"))
        print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


if __name__ == "__main__":
    main()
