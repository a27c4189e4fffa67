#!/usr/bin/env python3
"""Time and memory of each stage of `percale convert` as scans grow.

    bench/scaling.py --bench build/release/bench --percale build/release/percale [--log FILE] [SCAN:SUBDIVISIONS...] > table.md

SCAN:K is the scan with every triangle cut into four, K times, on curved patches, and noise of 10 % of an edge along the
normals (bench_synth); SCAN:0 is the scan as it is. With --log each result is added to FILE, those that FILE has for the
same commit are not made again, and the table has the newest of all that are there. --threads 1,2 runs each scan with as many threads; options for the conversion follow
"--". Standard library only.
"""
import argparse
import datetime
import json
import math
import os
import pathlib
import sys
import tempfile
import time

import provenance

NAMES = {"scan": "scan: read, repair", "mesh": "mesh: refine, order, adjacency", "curvature": "curvature", "field": "field",
         "curl": "curl", "param": "param: all tries, with their layouts and quads", "layout": "layout: check, write",
         "quads": "quads", "export": "export: figures, files"}


def spawn(command, environment):
    """Exit code, CPU seconds, seconds and peak bytes (of the last stage alone: percale resets the mark)."""
    begin = time.time()
    quiet = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    child = os.posix_spawnp(command[0], command, environment, file_actions=quiet)
    _, status, usage = os.wait4(child, 0)
    return (os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime, time.time() - begin,
            1024 * usage.ru_maxrss)


def convert(options, path, threads, folder):
    environment = dict(os.environ, OMP_NUM_THREADS=str(threads), POCL_MAX_PTHREAD_COUNT=str(threads))
    out = os.path.join(folder, "out")
    code, cpu, wall, peak = spawn([options.percale, "convert", path, "-o", out, "--no-pictures", "--force", "-q",
                                   *options.convert], environment)
    if code not in (0, 5):
        return {"failed": f"exit code {code}"}
    report = json.loads(pathlib.Path(out, "report.json").read_text(encoding="utf-8"))
    stages = {s["name"]: {"cpu": s["cpu_seconds"], "wall": s["seconds"], "peak": s["peak_bytes"]} for s in report["stages"]}
    stages["export"] = {"cpu": cpu - sum(s["cpu"] for s in stages.values()),
                        "wall": wall - sum(s["wall"] for s in stages.values()), "peak": peak}
    facts = {s["name"]: s.get("facts", {}) for s in report["stages"]}
    return {"code": code, "triangles": facts["scan"]["faces"], "tries": facts["param"]["tries"], "stages": stages,
            "quads": report["statistics"]["quads"]["faces"],
            "irregular": report["statistics"]["irregular_interior_vertices"], "cpu": cpu, "wall": wall}


def run(options, known, log):
    for case in options.case:
        scan, _, subdivisions = case.rpartition(":")
        for threads in map(int, options.threads.split(",")):
            key = [os.path.basename(scan), int(subdivisions), threads, options.convert, options.commit]
            if any(r["key"] == key for r in known):
                continue
            with tempfile.TemporaryDirectory() as folder:
                path = scan
                if int(subdivisions) > 0:
                    path = os.path.join(folder, "scan.ply")
                    made = spawn([os.path.join(options.bench, "bench_synth"), scan, "--subdivide", subdivisions,
                                  "--noise", "0.1", "-o", path], dict(os.environ))
                    if made[0] != 0:
                        sys.exit(f"{case}: bench_synth failed")
                result = convert(options, path, threads, folder)
            result.update(key=key, date=datetime.date.today().isoformat(), machine=provenance.machine("then"))
            known.append(result)
            if log:
                with open(log, "a", encoding="utf-8") as file:
                    file.write(json.dumps(result) + "\n")


def exponent(rows):
    """Of CPU seconds per try with triangles: the straight line through the logarithms."""
    x, y = [math.log(r["triangles"]) for r in rows], [math.log(r["cpu"] / r["tries"]) for r in rows]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    spread = sum((a - mx) ** 2 for a in x)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / spread if spread > 0 else math.nan


def cell(result, stage):
    s = result["stages"].get(stage)
    if not s:
        return ""
    return f"{s['cpu']:.1f}, {100 * s['cpu'] / result['cpu']:.0f} %, {s['peak'] / result['triangles']:.0f}"


def table(results):
    last = results[-1]
    print("# The stages as scans grow\n\nMade by `bench/scaling.py`. Each cell: CPU seconds, share of the whole, peak of the "
          "process in bytes per triangle (on small\nscans most of it is the program and the OpenCL driver).\n")
    print(f"{last['machine'].rpartition(';')[0]}; {last['date']}; commit {', '.join(sorted({r['key'][4] for r in results}))}; other work ran beside it: compare CPU "
          "seconds.\n")
    print("| stage | " + " | ".join(f"{r['key'][0]}, {r['triangles'] / 1e6:.2f} M triangles, {r['key'][2]} thread"
                                    f"{'s' if r['key'][2] > 1 else ''}" for r in results) + " |\n|---" + "|---:" * len(results) + "|")
    for stage, name in NAMES.items():
        if any(stage in r["stages"] for r in results):
            print(f"| {name} | " + " | ".join(cell(r, stage) for r in results) + " |")
    lines = {"whole: CPU s": lambda r: f"{r['cpu']:.1f}", "seconds": lambda r: f"{r['wall']:.1f}", "tries": lambda r: str(r["tries"]),
             "CPU s per try and million triangles": lambda r: f"{1e6 * r['cpu'] / r['tries'] / r['triangles']:.1f}",
             "peak, MB": lambda r: f"{max(s['peak'] for s in r['stages'].values()) / 1e6:,.0f}",
             "peak, bytes per triangle": lambda r: f"{max(s['peak'] for s in r['stages'].values()) / r['triangles']:.0f}",
             "quads, irregular vertices": lambda r: f"{r['quads']:,}, {r['irregular']:,}"}
    for name, value in lines.items():
        print(f"| {name} | " + " | ".join(value(r) for r in results) + " |")
    by_threads = {}
    for r in results:
        by_threads.setdefault(r["key"][2], []).append(r)
    print()
    for threads, rows in by_threads.items():
        if len({r["triangles"] for r in rows}) > 1:
            print(f"Exponent of CPU seconds per try with triangles, threads {threads}: {exponent(rows):.2f}.")


def main():
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", nargs="*", metavar="SCAN:SUBDIVISIONS")
    parser.add_argument("--percale", default="build/release/percale")
    parser.add_argument("--bench", default="build/release/bench")
    parser.add_argument("--threads", default=str(os.cpu_count()))
    parser.add_argument("--commit", default=provenance.commit_of_tree())
    parser.add_argument("--log")
    options = parser.parse_args(sys.argv[1:split])
    options.convert = sys.argv[split + 1:]
    known = []
    if options.log and os.path.exists(options.log):
        known = [json.loads(line) for line in pathlib.Path(options.log).read_text(encoding="utf-8").splitlines()]
    run(options, known, options.log)
    newest = {(*r["key"][:3], *r["key"][3]): r for r in known if "failed" not in r}  # of whatever commit
    table(sorted(newest.values(), key=lambda r: (r["triangles"], r["key"][2])))


if __name__ == "__main__":
    main()
