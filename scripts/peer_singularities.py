#!/usr/bin/env python3
"""Singularities that a peer puts on each scan, to set beside those of bench_field.

usage: peer_singularities.py im|quadriflow SCAN.obj|SCAN.off|SCAN.ply[.gz]...
Needs pyinstantmeshes or pyQuadriFlow (PyPI) and numpy, trimesh. The edge length asked for is ten mean edges, Percale's
default. Instant Meshes reports the singularities of its field; for QuadriFlow irregular vertices are counted.
-1: it failed.
"""
import gzip
import io
import os
import re
import sys
import tempfile

import numpy as np
import trimesh


def load(path):
    kind = path[:-3] if path.endswith(".gz") else path
    stream = gzip.open(path, "rb") if path.endswith(".gz") else open(path, "rb")
    with stream:
        mesh = trimesh.load(io.BytesIO(stream.read()), file_type=kind.rsplit(".", 1)[1], force="mesh", process=False)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    return np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.int32)


def mean_edge(vertices, faces):
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    return float(np.linalg.norm(vertices[edges[:, 0]].astype(float) - vertices[edges[:, 1]], axis=1).mean())


def captured(call):
    """Runs call() and returns its result and what it wrote to the file descriptor of standard output."""
    sys.stdout.flush()
    keep = os.dup(1)
    with tempfile.TemporaryFile() as spill:
        os.dup2(spill.fileno(), 1)
        try:
            result = call()
        except RuntimeError:
            result = None
        finally:
            os.dup2(keep, 1)
            os.close(keep)
        spill.seek(0)
        return result, spill.read().decode(errors="replace")


def instant_meshes(vertices, faces):
    """The number of singularities that Instant Meshes reports for its orientation field."""
    import pyinstantmeshes
    length = 10 * mean_edge(vertices, faces)
    _, log = captured(lambda: pyinstantmeshes.remesh(vertices, faces, target_edge_length=length, extrinsic=True,
                                                     deterministic=True))
    found = re.search(r"Orientation field has (\d+) singularities", log)
    return int(found.group(1)) if found else -1


def quadriflow(vertices, faces):
    """Interior vertices off valence 4 in QuadriFlow's mesh."""
    from pyQuadriFlow.pyQuadriFlow import pyquadriflow
    a, b, c = (vertices[faces[:, k]].astype(float) for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    wanted = max(int(area / (10 * mean_edge(vertices, faces)) ** 2), 8)
    mesh = pyquadriflow(wanted, 0, vertices, faces, False, True, False, False, False)
    return irregular(mesh["faces"])


def irregular(quads):
    """Vertices off the boundary whose valence is not 4."""
    valence, uses = {}, {}
    for quad in quads:
        for k, v in enumerate(quad):
            valence[v] = valence.get(v, 0) + 1
            edge = (min(v, quad[k - 1]), max(v, quad[k - 1]))
            uses[edge] = uses.get(edge, 0) + 1
    rim = {v for edge, n in uses.items() if n == 1 for v in edge}
    return sum(n != 4 and v not in rim for v, n in valence.items())


def main():
    peers = {"im": instant_meshes, "quadriflow": quadriflow}
    if len(sys.argv) < 3 or sys.argv[1] not in peers:
        sys.exit(__doc__)
    for path in sys.argv[2:]:
        print(f"{os.path.basename(path):24s} {peers[sys.argv[1]](*load(path)):6d}", flush=True)


if __name__ == "__main__":
    main()
