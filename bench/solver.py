#!/usr/bin/env python3
"""The linear solver against others, on the field and the PGP system of real scans.

    bench/solver.py record LOG --bench build/release/bench [--device D] SCAN:SUBDIVISIONS...
    bench/solver.py run LOG --bench build/release/bench [--device D] SCAN:SUBDIVISIONS...
    bench/solver.py table LOG [--plot FILE.png] [--roofline FILE] > bench/results/solver.md

`record` does it all: `run`, bench_roofline, then bench/results/solver.md and docs/images/solver.png.

`run` appends a line of JSON per solver and system to LOG; each solver runs in a process of its own. A solver that is
not installed, or takes longer than --limit, is noted as such. PyAMG runs where this Python has it.
"""
import argparse
import contextlib
import datetime
import json
import math
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time

import provenance

METHODS = ["percale", "percale32", "jacobi", "cholmod", "boomeramg", "pyamg"]
NAMES = {"percale": "Percale", "percale32": "Percale, hierarchy in 32 bits", "jacobi": "block-Jacobi CG",
         "cholmod": "CHOLMOD, METIS order", "boomeramg": "hypre BoomerAMG + CG", "pyamg": "PyAMG smoothed aggregation + CG"}


def read_system(path):
    """The matrix as scipy's: complex for kind 1, real for the others."""
    import numpy as np
    import scipy.sparse as sp
    with open(path, "rb") as file:
        kind, n, entries, _ = np.fromfile(file, np.uint32, 4)
        n = int(n)
        start = np.fromfile(file, np.uint32, n + 1).astype(np.int64)
        column = np.fromfile(file, np.uint32, entries).astype(np.int64)
        diagonal = np.fromfile(file, np.float64, n)
        width = (1, 2, 4)[kind]
        value = np.fromfile(file, np.float64, width * entries)
        turn = np.fromfile(file, np.uint8, entries) if kind == 2 else None
    row = np.repeat(np.arange(n), np.diff(start))
    if kind == 0:
        return sp.csr_matrix((value, (row, column)), (n, n)) + sp.diags(diagonal), 1
    z = value[0::2] + 1j * value[1::2]
    if kind == 1:
        return (sp.csr_matrix((z, (row, column)), (n, n)) + sp.diags(diagonal)).tocsr(), 1
    # diag(p, q) M^turn, M (U, V) = (V, conj U), as real 4 x 4 blocks
    source = [[0, 1], [1, 0], [0, 1], [1, 0]]
    conjugate = [[1, 1], [1, -1], [-1, -1], [-1, 1]]
    rows, columns, values = [], [], []
    for half in range(2):
        w = z[half::2]
        from_half = np.array(source)[turn, half]
        sign = np.array(conjugate)[turn, half]
        for r, c, v in ((0, 0, w.real), (0, 1, -sign * w.imag), (1, 0, w.imag), (1, 1, sign * w.real)):
            rows.append(4 * row + 2 * half + r)
            columns.append(4 * column + 2 * from_half + c)
            values.append(v)
    a = sp.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (4 * n, 4 * n))
    return (a + sp.diags(np.repeat(diagonal, 4))).tobsr((4, 4)), 4


def run_pyamg(path):
    import numpy as np
    import pyamg
    a, width = read_system(path)
    rng = np.random.default_rng(1)
    b = rng.uniform(-1, 1, a.shape[0])
    if np.iscomplexobj(a.data):
        b = b + 1j * rng.uniform(-1, 1, a.shape[0])
    near_null = np.kron(np.ones((a.shape[0] // width, 1)), np.eye(width)) if width > 1 else None
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    cpu, wall = time.process_time(), time.time()
    symmetry = "hermitian" if np.iscomplexobj(a.data) else "symmetric"
    levels = pyamg.smoothed_aggregation_solver(a, B=near_null, symmetry=symmetry)
    out = {"method": "pyamg", "rows": a.shape[0] // width, "setup_cpu": time.process_time() - cpu,
           "setup": time.time() - wall, "solve_cpu": [], "solve": [], "iterations": [], "residual": []}
    for tolerance in (1e-6, 1e-10):
        history = []
        cpu, wall = time.process_time(), time.time()
        x = levels.solve(b, tol=tolerance, accel="cg", maxiter=2000, residuals=history)
        out["solve_cpu"].append(time.process_time() - cpu)
        out["solve"].append(time.time() - wall)
        out["iterations"].append(len(history) - 1)
        out["residual"].append(float(np.linalg.norm(b - a @ x) / np.linalg.norm(b)))
    out["bytes"] = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
    print(json.dumps(out))


def one(command, limit, environment):
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, env=environment, check=False)
    except subprocess.TimeoutExpired:
        return {"failed": f"over {limit} s"}
    if done.returncode != 0:
        return {"failed": (done.stderr.strip().splitlines() or ["exit " + str(done.returncode)])[-1]}
    return json.loads(done.stdout.strip().splitlines()[-1])


def run(options):
    environment = dict(os.environ, OMP_WAIT_POLICY="passive", OMPI_ALLOW_RUN_AS_ROOT="1",
                       OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    program = os.path.join(options.bench, "bench_rivals")
    with tempfile.TemporaryDirectory() as folder, open(options.log, "a", encoding="utf-8") as log:
        for case in options.cases:
            scan, _, subdivisions = case.rpartition(":")
            for kind in options.kinds.split(","):
                path = os.path.join(folder, "system")
                made = one([program, "make", path, options.device, scan, subdivisions, kind], None, environment)
                for method in options.methods.split(","):
                    command = [program, method, path, options.device]
                    if method == "pyamg":
                        command = [sys.executable, os.path.abspath(__file__), "pyamg", path]
                    result = dict(made) if "failed" in made else one(command, options.limit, environment)
                    result.update(machine=provenance.machine("then"), commit=provenance.commit_of_tree())
                    result.update(method=method, scan=os.path.basename(scan), subdivisions=int(subdivisions),
                                  kind=kind, rows=made.get("rows", 0), load=os.getloadavg()[0],
                                  date=datetime.date.today().isoformat())
                    log.write(json.dumps(result) + "\n")
                    log.flush()


def exponent(rows, seconds):
    """Of the straight line through the logarithms."""
    x, y = [math.log(r) for r in rows], [math.log(s) for s in seconds]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    spread = sum((a - mx) ** 2 for a in x)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / spread if spread > 0 else float("nan")


def table(options):
    with open(options.log, encoding="utf-8") as file:
        results = [json.loads(line) for line in file]
    newest = {(r["kind"], r["rows"], r["scan"], r["method"]): r for r in results}
    good = [r for r in newest.values() if "failed" not in r]
    print("# The linear solver against others\n")
    if options.plot:
        print("![CPU seconds against vertices](../../docs/images/solver.png)\n")
    last = max(newest.values(), key=lambda r: r["date"])
    print(f"{last.get('machine', 'machine not recorded; ').rpartition(';')[0]}; {last['date']}; "
          f"one minute's load {min(r['load'] for r in results):.0f} to {max(r['load'] for r in results):.0f}: "
          f"compare CPU seconds.\nMade by `bench/solver.py`; commit {options.commit or last.get('commit', 'unknown')}.\n")
    for kind, title in (("field", "Field"), ("pgp", "PGP")):
        print(f"## {title} systems\n")
        print("| scan | vertices | solver | set-up, CPU s | to 1e-6: its, CPU s | to 1e-10: its, CPU s | "
              "set-up and 1e-6 against Percale | bytes per vertex |")
        print("|---|---|---|---|---|---|---|---|")
        for key in sorted({k[:3] for k in newest if k[0] == kind}, key=lambda k: (k[1], k[2])):
            for method in METHODS:
                r = newest.get(key + (method,))
                if not r:
                    continue
                head = f"| {key[2]} | {key[1]} | {NAMES[method]} |"
                if "failed" in r:
                    print(f"{head} {r['failed']} | | | | |")
                    continue
                ours = newest.get(key + ("percale",), {})
                ratio = ""
                if "failed" not in ours and ours:
                    ratio = "%.1f" % ((r["setup_cpu"] + r["solve_cpu"][0]) / (ours["setup_cpu"] + ours["solve_cpu"][0]))
                cells = [f"{r['iterations'][t] or 'direct'}, {r['solve_cpu'][t]:.2f}"
                         + ("" if r["residual"][t] <= 1.05 * (1e-6, 1e-10)[t] else f" (only {r['residual'][t]:.0e})")
                         for t in range(2)]
                print(f"{head} {r['setup_cpu']:.2f} | {cells[0]} | {cells[1]} | {ratio} | "
                      + (f"{r['bytes'] / r['rows']:.0f} |" if r["bytes"] else "not measured |"))
        print()
        growth = []
        for method in METHODS:
            of = [r for r in good if r["kind"] == kind and r["method"] == method]
            if len({r["rows"] for r in of}) > 1:
                seconds = [r["setup_cpu"] + r["solve_cpu"][0] for r in of]
                growth.append(f"{NAMES[method]} {exponent([r['rows'] for r in of], seconds):.2f}")
        if growth:
            print(f"Exponent of CPU seconds, set-up and 1e-6, with vertices: {'; '.join(growth)}.\n")
        print(asked(newest, kind))
    if options.roofline:
        print(roofline_tables(options.roofline))
    if options.plot:
        plot(good, options.plot)


def seconds_of(r):
    return r["setup_cpu"] + r["solve_cpu"][0]


def asked(newest, kind):
    """The ratios that matter, on the largest system that both solved."""
    ours = {k: r for k, r in newest.items() if k[0] == kind and k[3] == "percale" and "failed" not in r}
    lines = ["| on the largest system of both | time against Percale | memory against Percale |", "|---|---|---|"]
    for method in METHODS[1:]:
        both = [k for k in ours if "failed" not in newest.get(k[:3] + (method,), {"failed": 1})]
        if both:
            key = max(both, key=lambda k: k[1])
            mine, other = ours[key], newest[key[:3] + (method,)]
            memory = f"{other['bytes'] / mine['bytes']:.1f}" if other["bytes"] and mine["bytes"] else "not measured"
            lines.append(f"| {NAMES[method]}, {key[1]} vertices | {seconds_of(other) / seconds_of(mine):.1f} | {memory} |")
    largest = max(ours, key=lambda k: k[1], default=None)
    if not largest:
        return ""
    share = ours[largest]["setup_cpu"] / ours[largest]["solve_cpu"][0]
    text = f"Percale at {largest[1]} vertices: set-up {share:.2f} of the solve to 1e-6"
    field = newest.get(("field",) + largest[1:])
    if kind == "pgp" and field and "failed" not in field:
        text += f"; all of it {seconds_of(ours[largest]) / seconds_of(field):.2f} times the field system"
    return "\n".join(lines) + f"\n\n{text}.\n"


def roofline_tables(path):
    """bench_roofline's lines as tables."""
    out = ["## Kernels against the triad\n",
           "`bench_roofline`: synthetic systems; the triad of the same run, before each of them and after.\n"]
    for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines():
        head = re.match(r"(.*), (\w+), (\d+) rows: share of the triad's ([\d.]+) GB/s", line)
        kernel = re.match(r"  (\S+)\s+(?:(\d+) launches)?\s+([\d.]+) ms\s+([\d.]+) MB\s+([\d.]+) GB/s\s+([\d.]+)", line)
        if head:
            out += [f"\n{head[2].capitalize()}, {head[3]} rows, {head[1]}:\n",
                    "| kernel | launches | ms | MB | GB/s | share of the triad |", "|---|---|---|---|---|---|"]
        elif kernel:
            out.append(f"| {kernel[1]} | {kernel[2] or ''} | {kernel[3]} | {kernel[4]} | {kernel[5]} | {kernel[6]} |")
        elif line.strip():
            out.append(f"\n{line.strip()[0].upper()}{line.strip()[1:]}.")
    return "\n".join(out)


def record(options):
    root = pathlib.Path(__file__).resolve().parent.parent
    run(options)
    with tempfile.TemporaryDirectory() as folder:
        options.roofline = os.path.join(folder, "roofline")
        options.commit = None
        try:
            import matplotlib  # noqa: F401
            options.plot = str(root / "docs/images/solver.png")
        except ImportError:
            options.plot = None
        measured = subprocess.run([os.path.join(options.bench, "bench_roofline"), options.device, str(options.vertices)],
                                  capture_output=True, text=True, check=True)
        pathlib.Path(options.roofline).write_text(measured.stdout, encoding="utf-8")
        with open(root / "bench/results/solver.md", "w", encoding="utf-8") as file, contextlib.redirect_stdout(file):
            table(options)


def plot(good, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import NullFormatter
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.6), sharey=True, layout="constrained")
    for axis, kind in zip(axes, ("field", "pgp")):
        for method in METHODS:
            of = sorted((r["rows"], r["setup_cpu"] + r["solve_cpu"][0])
                        for r in good if r["kind"] == kind and r["method"] == method)
            if of:
                axis.loglog(*zip(*of), "o-", label=NAMES[method])
        axis.set_title(f"{kind} systems, set-up and solve to 1e-6")
        axis.set_xlabel("vertices")
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.grid(True, which="both", alpha=0.3)
    axes[0].set_ylabel("CPU seconds")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("run", "record"):
        runs = commands.add_parser(name)
        runs.add_argument("log")
        runs.add_argument("cases", nargs="+", metavar="SCAN:SUBDIVISIONS")
        runs.add_argument("--bench", required=True)
        runs.add_argument("--device", default="cpu")
        runs.add_argument("--vertices", type=int, default=1000000, help="of the systems of bench_roofline")
        runs.add_argument("--limit", type=float, default=1800)
        runs.add_argument("--kinds", default="field,pgp")
        runs.add_argument("--methods", default=",".join(METHODS))
    tables = commands.add_parser("table")
    tables.add_argument("log")
    tables.add_argument("--plot")
    tables.add_argument("--roofline")
    tables.add_argument("--commit")
    commands.add_parser("pyamg").add_argument("path")
    options = parser.parse_args()
    if options.command == "run":
        run(options)
    elif options.command == "record":
        record(options)
    elif options.command == "table":
        table(options)
    else:
        run_pyamg(options.path)


if __name__ == "__main__":
    main()
