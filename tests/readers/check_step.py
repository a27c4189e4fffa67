"""Reads a STEP file: every edge is the same curve in space and in the parameters of its faces, and loops close.

Usage: check_step.py FILE.step DIAGONAL FACES. Exit status 77 where NumPy is not installed.
"""
import re
import sys

try:
    import numpy as np
except ImportError as missing:
    print(missing)
    sys.exit(77)

from bspline import de_boor


def parse(text):
    """Lists nested as in the file; references as ints, numbers as floats, all else as text."""
    tokens = re.findall(r"'[^']*'|#\d+|[(),]|[^(),'#]+", text)
    stack = [[]]
    for token in tokens:
        if token == "(":
            stack.append([])
        elif token == ")":
            done = stack.pop()
            stack[-1].append(done)
        elif token[0] == "#":
            stack[-1].append(int(token[1:]))
        elif re.fullmatch(r"-?[0-9.]+(E-?[0-9]+)?", token):
            stack[-1].append(float(token))
        elif token != ",":
            stack[-1].append(token)
    return stack[0]


with open(sys.argv[1], encoding="ascii") as file:
    entity = {int(number): (kind, parse(rest)[0]) for number, kind, rest in
              re.findall(r"^#(\d+)=([A-Z_0-9]+)(\(.*\));$", file.read(), re.MULTILINE)}


def args(number, kind):
    assert entity[number][0] == kind, (entity[number], kind)
    return entity[number][1]


def point(number):
    return np.array(args(number, "CARTESIAN_POINT")[1])


def knots(counts, values):
    return np.repeat(np.array(values), np.array(counts, dtype=int))


def curve(number):
    a = args(number, "B_SPLINE_CURVE_WITH_KNOTS")
    assert a[1] == 3
    return knots(a[6], a[7]), np.array([point(p) for p in a[2]])


def surface(number):
    a = args(number, "B_SPLINE_SURFACE_WITH_KNOTS")
    assert a[1:3] == [3, 3]
    return knots(a[8], a[10]), knots(a[9], a[11]), np.array([[point(p) for p in row] for row in a[3]])


def trace(number):
    """The surface's number, and the line in its parameters."""
    _, on, definition = args(number, "PCURVE")
    _, (line,), _ = args(definition, "DEFINITIONAL_REPRESENTATION")
    _, origin, vector = args(line, "LINE")
    _, direction, length = args(vector, "VECTOR")
    return on, point(origin), length * np.array(args(direction, "DIRECTION")[1])


diagonal, worst, used, surfaces = float(sys.argv[2]), 0, {}, {}
for number, (kind, values) in entity.items():
    if kind != "EDGE_CURVE":
        continue
    _, begin, end, both, sense = values
    assert sense == ".T."
    _, in_space, traces, _ = args(both, "SURFACE_CURVE")
    knot, points = curve(in_space)
    for vertex, tip in ((begin, points[0]), (end, points[-1])):
        worst = max(worst, np.abs(point(args(vertex, "VERTEX_POINT")[1]) - tip).max())
    for on, origin, way in map(trace, traces):
        used.setdefault(number, []).append(on)
        s, t, net = surfaces.setdefault(on, surface(on))
        for x in np.linspace(knot[0], knot[-1], 4):
            u, v = origin + x * way
            assert s[0] <= u <= s[-1] and t[0] <= v <= t[-1], (u, v)
            assert u in (s[0], s[-1]) or v in (t[0], t[-1]), (u, v)
            gap = de_boor(t, de_boor(s, net, u), v) - de_boor(knot, points, x)
            worst = max(worst, np.abs(gap).max())
faces = 0
for number, (kind, values) in entity.items():
    if kind != "ADVANCED_FACE":
        continue
    faces += 1
    _, (bound,), on, sense = values
    loop = args(args(bound, "FACE_OUTER_BOUND")[1], "EDGE_LOOP")[1]
    chain = []
    for oriented in loop:
        _, _, _, edge, forward = args(oriented, "ORIENTED_EDGE")
        assert on in used[edge]
        ends = args(edge, "EDGE_CURVE")[1:3]
        chain.append(ends if forward == ".T." else ends[::-1])
    assert all(a[1] == b[0] for a, b in zip(chain, chain[1:] + chain[:1]))
print(f"step: {faces} faces, {len(used)} edges, curves on surfaces within {worst / diagonal:.2g}")
assert faces == int(sys.argv[3]) and worst < 1e-12 * diagonal
