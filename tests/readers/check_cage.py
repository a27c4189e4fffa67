"""Subdivides a cage by Catmull and Clark's rules, corners of the border kept, and compares the limit with the spline.

Usage: check_cage.py POINTS CAGE.obj LEVELS. POINTS: the diagonal, the largest distance between samples of the spline
and points of the limit, the number of the cage's vertices; per vertex the spline's point there and 1 where the limit
has to meet it; then the samples. Exit status 77 where NumPy is not installed.
"""
import sys

try:
    import numpy as np
except ImportError as missing:
    print(missing)
    sys.exit(77)


def read_obj(path):
    points, faces = [], []
    with open(path, encoding="ascii") as file:
        for line in file:
            word, *rest = line.split()
            if word == "v":
                points.append([float(x) for x in rest])
            elif word == "f":
                faces.append([int(x) - 1 for x in rest])
    return np.array(points), faces


def edges_of(faces):
    """Edges as pairs of vertices, per directed edge of each face its edge, and the faces of each edge."""
    numbers, beside, around = {}, [], []
    for f, face in enumerate(faces):
        own = []
        for a, b in zip(face, face[1:] + face[:1]):
            e = numbers.setdefault((min(a, b), max(a, b)), len(numbers))
            if e == len(beside):
                beside.append([])
            beside[e].append(f)
            own.append(e)
        around.append(own)
    return np.array(list(numbers)), around, beside


def corners_of(faces, count):
    """The vertices of one face only."""
    return np.bincount(np.concatenate(faces), minlength=count) == 1


def subdivide(points, faces):
    """New points: the vertices, then one per face, then one per edge."""
    edges, around, beside = edges_of(faces)
    border = np.array([len(b) == 1 for b in beside])
    centres = np.array([points[face].mean(axis=0) for face in faces])
    middles = points[edges].mean(axis=1)
    pairs = np.array([(b[0], b[-1]) for b in beside])
    edge_points = np.where(border[:, None], middles, (middles + centres[pairs].mean(axis=1)) / 2)
    n = np.bincount(edges.ravel(), minlength=len(points))[:, None]
    on_border = np.zeros(len(points), dtype=bool)
    on_border[edges[border]] = True
    sum_f, sum_r, sum_b = (np.zeros_like(points) for _ in range(3))
    for f, face in enumerate(faces):
        sum_f[face] += centres[f]
    for k in range(2):
        np.add.at(sum_r, edges[:, k], middles)
        np.add.at(sum_b, edges[border, k], middles[border])
    inner = (sum_f / n + 2 * sum_r / n + (n - 3) * points) / n
    moved = np.where(on_border[:, None], points / 2 + sum_b / 4, inner)
    corner = corners_of(faces, len(points))
    moved[corner] = points[corner]
    first, second = len(points), len(points) + len(faces)
    quads = [[face[i], second + own[i], first + f, second + own[i - 1]]
             for f, (face, own) in enumerate(zip(faces, around)) for i in range(len(face))]
    return np.concatenate([moved, centres, edge_points]), quads


def limit(points, quads):
    """Where the vertices of a mesh of quads go."""
    quads_array = np.array(quads)
    edges, _, beside = edges_of(quads)
    border = np.array([len(b) == 1 for b in beside])
    n = np.bincount(edges.ravel(), minlength=len(points))[:, None]
    on_border = np.zeros(len(points), dtype=bool)
    on_border[edges[border]] = True
    sum_e, sum_b, sum_f = (np.zeros_like(points) for _ in range(3))
    for k in range(2):
        np.add.at(sum_e, edges[:, k], points[edges[:, 1 - k]])
        np.add.at(sum_b, edges[border, k], points[edges[border, 1 - k]])
    for k in range(4):
        np.add.at(sum_f, quads_array[:, k], points[quads_array[:, (k + 2) % 4]])
    inner = (n * n * points + 4 * sum_e + sum_f) / (n * (n + 5))
    found = np.where(on_border[:, None], (4 * points + sum_b) / 6, inner)
    corner = corners_of(quads, len(points))
    found[corner] = points[corner]
    return found


with open(sys.argv[1], encoding="ascii") as file:
    diagonal, tolerance, count = (float(x) for x in next(file).split())
    rows = np.loadtxt(file)
vertices, faces = read_obj(sys.argv[2])
assert len(vertices) == count
points, worst = vertices, 0
for level in range(int(sys.argv[3])):
    points, faces = subdivide(points, faces)
    if level == 0:
        known = rows[:len(vertices)]
        gaps = np.abs(limit(points, faces)[:len(known)] - known[:, :3])
        worst = gaps[known[:, 3] == 1].max(initial=0) / diagonal
points = limit(points, faces)
far = max(np.linalg.norm(points - sample, axis=1).min() for sample in rows[len(vertices):, :3]) / diagonal
print(f"cage: {len(vertices)} vertices, limit at vertices within {worst:.2g}, at samples within {far:.2g}")
assert worst < 1e-12 and far < tolerance
