#!/usr/bin/env python3
"""Percale beside Instant Meshes and QuadriFlow at the same wanted number of quads.

usage: peers.py [--percale PROGRAM] [--commit C] [--quads N] [--log FILE] SCAN.obj|SCAN.off|SCAN.ply... > table.md
Needs numpy, and for the peers pyinstantmeshes and pyQuadriFlow (PyPI); a peer that is not there is left out, and the
table says so. Each run is a process of its own, whose CPU time and peak memory the system tells. With --log each
result is added to FILE, and results that FILE has are not made again. With --quads 0 nothing is asked of Percale, and of
the others as many as it gave. PLY: as bench_synth writes it.
"""
import argparse
import datetime
import importlib.metadata
import importlib.util
import json
import os
import pathlib
import resource
import shlex
import sys
import tempfile
import time

from provenance import machine

# name: (module it needs, package on PyPI)
METHODS = {
    "Percale, cells kept": (None, None),
    "Percale": (None, None),
    "Instant Meshes": ("pyinstantmeshes", "pyinstantmeshes"),
    "Instant Meshes, pure quads": ("pyinstantmeshes", "pyinstantmeshes"),
    "QuadriFlow": ("pyQuadriFlow", "pyQuadriFlow"),
}


# What runs in processes of its own. numpy is loaded only there: a process starts with the peak memory of its parent.


def read_polygons(path):
    """Vertices as a list of rows, and polygons, of an OBJ or OFF file."""
    vertices, polygons = [], []
    if path.endswith(".ply"):
        return read_triangles(path)
    with open(path, encoding="utf-8", errors="replace") as file:
        if path.endswith(".off"):
            words = " ".join(line.split("#", 1)[0] for line in file).split()
            n_vertices, n_faces, at = int(words[1]), int(words[2]), 4
            vertices = [[float(w) for w in words[at + 3 * k:at + 3 * k + 3]] for k in range(n_vertices)]
            at += 3 * n_vertices
            for _ in range(n_faces):
                size = int(words[at])
                polygons.append([int(w) for w in words[at + 1:at + 1 + size]])
                at += 1 + size
            return vertices, polygons
        for line in file:
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([float(w) for w in words[1:4]])
            elif words[:1] == ["f"]:
                ids = [int(w.split("/", 1)[0]) for w in words[1:]]
                polygons.append([k - 1 if k > 0 else len(vertices) + k for k in ids])
    return vertices, polygons


def read_triangles(path):
    """Of a binary PLY with doubles, and triangles alone."""
    import numpy as np
    with open(path, "rb") as file:
        counts = {}
        while (line := file.readline()) != b"end_header\n":
            if line.startswith(b"element"):
                counts[line.split()[1]] = int(line.split()[2])
        vertices = np.fromfile(file, "<f8", 3 * counts[b"vertex"]).reshape(-1, 3)
        faces = np.fromfile(file, np.dtype([("n", "u1"), ("v", "<i4", 3)]), counts[b"face"])
    return vertices.tolist(), faces["v"].tolist()


def write_obj(path, vertices, polygons):
    with open(path, "w", encoding="utf-8") as file:
        file.writelines("v " + " ".join(f"{x:.9g}" for x in v) + "\n" for v in vertices)
        file.writelines("f " + " ".join(str(k + 1) for k in p) + "\n" for p in polygons)


def prepare(scan, out):
    """The scan as an OBJ of triangles without unused vertices: every method reads the same file."""
    vertices, polygons = read_polygons(scan)
    triangles = [[p[0], p[k], p[k + 1]] for p in polygons for k in range(1, len(p) - 1)]
    used = sorted({k for t in triangles for k in t})
    place = {k: i for i, k in enumerate(used)}
    write_obj(out, [vertices[k] for k in used], [[place[k] for k in t] for t in triangles])


def instant_meshes(scan, out, quads, pure):
    """Pure quads come from one subdivision, so a quarter of the faces is asked for."""
    import pyinstantmeshes
    pyinstantmeshes.remesh_file(scan, out, target_face_count=quads // 4 if pure else quads, pure_quad=pure,
                                align_to_boundaries=True, deterministic=True)


def quadriflow(scan, out, quads):
    from pyQuadriFlow.pyQuadriFlow import pyquadriflow
    vertices, triangles = read_polygons(scan)
    mesh = pyquadriflow(quads, 0, vertices, triangles, False, True, False, False, False)
    write_obj(out, mesh["vertices"], mesh["faces"])


def measure(path):
    """The figures of a mesh of polygons that need no geometry."""
    import numpy as np
    _, polygons = read_polygons(path)
    sizes = np.array([len(p) for p in polygons])
    tails = np.concatenate([np.array(p) for p in polygons])
    heads = np.concatenate([np.roll(np.array(p), -1) for p in polygons])
    low, high = np.minimum(tails, heads), np.maximum(tails, heads)
    edges, place, uses = np.unique(np.stack([low, high], axis=1), axis=0, return_inverse=True, return_counts=True)
    forward = np.bincount(place.reshape(-1), weights=tails < heads, minlength=len(edges))
    valence = np.bincount(edges.reshape(-1), minlength=tails.max() + 1)
    rim = np.zeros(len(valence), bool)
    rim[edges[uses == 1].reshape(-1)] = True
    irregular = int(((valence != 4) & (valence > 0) & ~rim).sum())
    return {"faces": len(polygons), "quad_percent": 100 * float((sizes == 4).mean()), "irregular": irregular,
            "euler": int((valence > 0).sum()) - len(edges) + len(polygons), "loops": loops(edges[uses == 1]),
            "nonmanifold": int(((uses > 2) | ((uses == 2) & (forward != 1))).sum())}


def loops(edges):
    """The number of connected pieces of a graph."""
    root = {}

    def find(v):
        while root.setdefault(v, v) != v:
            root[v] = v = root[root[v]]
        return v

    for a, b in edges.tolist():
        root[find(a)] = find(b)
    return sum(root[v] == v for v in root)


def work(task, arguments):
    if len(arguments) > 3:
        resource.setrlimit(resource.RLIMIT_CPU, 2 * (int(arguments[3]),))
    if task == "prepare":
        prepare(*arguments)
    elif task == "measure":
        print(json.dumps(measure(arguments[0])))
    elif task == "QuadriFlow":
        quadriflow(arguments[0], arguments[1], int(arguments[2]))
    else:
        instant_meshes(arguments[0], arguments[1], int(arguments[2]), "pure" in task)


# The parent.


def spawn(command, capture=None):
    """Runs a command, standard output to the file `capture` or nowhere: exit code, CPU seconds and peak bytes."""
    actions = [(os.POSIX_SPAWN_OPEN, 1, capture or os.devnull, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)]
    child = os.posix_spawnp(command[0], command, os.environ, file_actions=actions)
    _, status, usage = os.wait4(child, 0)
    return os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


def self_task(*arguments, capture=None):
    return spawn([sys.executable, __file__, "--task", *arguments], capture)


def measured(path, scratch):
    answer = str(scratch / "measure.json")
    code, _, _ = self_task("measure", str(path), capture=answer)
    if code != 0:
        raise RuntimeError(f"{path} could not be read")
    return json.loads(pathlib.Path(answer).read_text(encoding="utf-8"))


def percale_command(program, scan, folder, quads, keep):
    return [program, "convert", scan, "-o", folder, *(["--quads", str(quads)] if quads else []),
            "--ngons", "keep" if keep else "split", "--no-pictures", "--force", "--quiet"]


def run(method, args, scan, scratch, quads):
    """One method on one prepared scan: a dictionary of figures."""
    out = scratch / "out.obj"
    begin = time.time()
    if method.startswith("Percale"):
        folder = scratch / "percale"
        code, cpu, peak = spawn(percale_command(args.percale, scan, str(folder), quads, "kept" in method))
        out = folder / "quads.obj"
        done = code in (0, 5)
    else:
        out.unlink(missing_ok=True)
        code, cpu, peak = self_task(method, scan, str(out), str(quads), str(args.limit))
        done = code == 0
    note = "" if code == 0 else f"over {args.limit} CPU s" if cpu > 0.99 * args.limit else f"exit code {code}"
    result = {"cpu": cpu, "peak": peak, "code": code, "wall": time.time() - begin, "note": note}
    if done and out.exists():
        result.update(measured(out, scratch))
    if method.startswith("Percale") and done:
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        failed = [check["name"] for check in report["certificate"]["checks"] if not check["passed"]]
        result["note"] = "certificate: " + ", ".join(failed) if failed else ""
        result["peak"] = max(peak, report["peak_bytes"])  # percale resets the mark that the system tells
    return result


def same(value, wanted):
    return f"{wanted} = {value}" if value == wanted else f"**{wanted}, {value}**"


def row_of(scan, method, base, result, quads):
    row = [scan, method]
    if "faces" not in result:
        return row + ["failed"] + ["-"] * 6 + [f"{result['cpu']:.1f}", f"{result['wall']:.1f}", f"{result['peak'] / 1e6:.0f}",
                                               result["note"]]
    return row + [f"{quads:,} / {result['faces']:,}" if quads else f"- / {result['faces']:,}", f"{result['quad_percent']:.1f}",
                  f"{1000 * result['irregular'] / result['faces']:.1f}", same(result["euler"], base["euler"]),
                  same(result["loops"], base["loops"]), str(result["nonmanifold"]), f"{result['cpu']:.1f}",
                  f"{result['wall']:.1f}", f"{result['peak'] / 1e6:.0f}", result["note"]]


def version(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


LEGEND = """
One row per run, all on the same OBJ of triangles. quads asked / given: faces of any number of sides in the output. quads %: share
of them with four sides. irregular: inner vertices of valence other than 4 per 1,000 faces; the ends of T-junctions count. Euler
number and boundary loops: of the scan, then of the result, bold where they differ; a loop is a connected piece of boundary edges.
bad edges: with more than two faces, or with two of unlike orientation. CPU s: user and system time of all threads of the process,
with reading and writing files; s: wall time. MB: its peak resident memory. Those of the peers contain Python's start and their bindings, those of
Percale its certificate, HDF5 files and statistics.

`Percale` is the default, `--ngons split`, quads only; `Percale, cells kept` is `--ngons keep`. `Instant Meshes` is its raw output,
quad-dominant (4-RoSy, 4-PoSy, aligned to boundaries, deterministic); `pure quads` is its own subdivision of a mesh of a quarter of
the faces. `QuadriFlow` runs with seed 0 and boundaries preserved, without the minimum-cost flow. The table says nothing about distance to
the scan, shape of the quads, or alignment to curvature.
"""


def header(args, missing):
    packages = sorted({package for _, package in METHODS.values() if package})
    print("# Percale beside its peers\n\nMade by `bench/peers.py`.\n")
    print(f"* date: {datetime.date.today()}\n* machine: {machine('when the table was printed')}; "
          "shared with other work while this ran, so times are rough")
    print(f"* commit: {args.commit}\n* peers: " + ", ".join(f"{p} {version(p) or 'not there'}" for p in packages))
    print(f"* command: `bench/peers.py --quads {args.quads} "
          + " ".join(pathlib.Path(scan).name for scan in args.scans) + "`, which runs `"
          + shlex.join(percale_command("percale", "SCAN", "OUT", args.quads, False)) + "`")
    for method in missing:
        print(f"* not run: {method}, whose package {METHODS[method][1]} was not installed")
    print()


def collect(args, methods):
    """Rows of the table; each result goes to the log as soon as it is there."""
    log = pathlib.Path(args.log) if args.log else None
    known = {}
    if log and log.exists():
        known = {tuple(r["key"]): r for r in map(json.loads, log.read_text(encoding="utf-8").splitlines())}
    rows = []
    for scan in args.scans:
        name = pathlib.Path(scan).name.split(".")[0]
        with tempfile.TemporaryDirectory() as folder:
            scratch = pathlib.Path(folder)
            triangles = str(scratch / "scan.obj")
            self_task("prepare", scan, triangles)
            base = measured(triangles, scratch)
            given = 0
            for method in methods:
                quads = args.quads or (0 if method.startswith("Percale") else given)
                key = (name, method, quads)
                if key not in known:
                    print(f"{name}: {method}", file=sys.stderr, flush=True)
                    known[key] = {"key": key, **run(method, args, triangles, scratch, quads)}
                    if log:
                        with log.open("a", encoding="utf-8") as file:
                            file.write(json.dumps(known[key]) + "\n")
                if method == "Percale":
                    given = known[key].get("faces", 0)
                rows.append(row_of(name, method, base, known[key], quads))
    return rows


def main():
    if sys.argv[1:2] == ["--task"]:
        return work(sys.argv[2], sys.argv[3:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scans", nargs="+", metavar="SCAN")
    parser.add_argument("--percale", default="percale", help="the program (default: percale in the PATH)")
    parser.add_argument("--commit", default="unknown", help="what the program was built from")
    parser.add_argument("--quads", type=int, default=4000)
    parser.add_argument("--methods", help="those to run, by commas (default: all)")
    parser.add_argument("--limit", type=int, default=36000, help="CPU seconds that a peer may take")
    parser.add_argument("--log", help="a file for results as they come")
    args = parser.parse_args()
    missing = [m for m, (module, _) in METHODS.items() if module and not importlib.util.find_spec(module)]
    wanted = args.methods.split(",") if args.methods else list(METHODS)
    rows = collect(args, [m for m in METHODS if m in wanted and m not in missing])
    header(args, missing)
    head = ["scan", "method", "quads asked / given", "quads %", "irregular", "Euler number", "boundary loops", "bad edges",
            "CPU s", "s", "MB", "note"]
    print("| " + " | ".join(head) + " |\n|---|---|" + "---:|" * 9 + "---|")
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print(LEGEND, end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
