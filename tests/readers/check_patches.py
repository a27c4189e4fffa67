"""Evaluates the B-spline patches of G+Smo's XML and of IGES with its own de Boor, and compares with the C evaluator.

Usage: check_patches.py POINTS FILE.xml FILE.igs. POINTS: the diagonal and the number of patches' sides on the border of
the surface, then `patch u v x y z` per line, u and v in 0..1 of the patch. Exit status 77 where NumPy is not installed.
"""
import sys
import xml.etree.ElementTree

try:
    import numpy as np
except ImportError as missing:
    print(missing)
    sys.exit(77)

from bspline import de_boor


class Patch:
    """Knots in both directions and control points [t, s]."""

    def __init__(self, s, t, points):
        self.knots = [np.array(s), np.array(t)]
        for knots in self.knots:
            assert (knots[:4] == knots[0]).all() and (knots[-4:] == knots[-1]).all()
            assert (np.diff(knots[3:-3]) > 0).all()
        self.points = np.array(points).reshape(len(t) - 4, len(s) - 4, 3)

    def at(self, u, v):
        """u and v in 0..1."""
        s, t = (k[0] + x * (k[-1] - k[0]) for k, x in zip(self.knots, (u, v)))
        return de_boor(self.knots[0], de_boor(self.knots[1], self.points, t), s)


def numbers(text, kind=float):
    return [kind(x) for x in text.split()]


def read_gismo(path):
    root = xml.etree.ElementTree.parse(path).getroot()
    assert root.tag == "xml"
    patches = []
    for number, geometry in enumerate(root.findall("Geometry")):
        assert geometry.get("type") == "TensorBSpline2" and geometry.get("id") == str(number)
        basis = geometry.find("Basis")
        assert basis.get("type") == "TensorBSplineBasis2"
        vectors = basis.findall("Basis/KnotVector")
        assert [v.get("degree") for v in vectors] == ["3", "3"]
        assert geometry.find("coefs").get("geoDim") == "3"
        patches.append(Patch(*(numbers(v.text) for v in vectors), numbers(geometry.find("coefs").text)))
    multi = root.find("MultiPatch")
    assert multi.get("parDim") == "2"
    assert multi.find("patches").text == f"0 {len(patches) - 1}"
    interfaces = np.array(numbers(multi.find("interfaces").text or "", int)).reshape(-1, 8)
    boundary = np.array(numbers(multi.find("boundary").text or "", int)).reshape(-1, 2)
    return patches, interfaces, boundary


def interface_gap(patches, interface):
    """Largest distance between both sides of an interface at the same places."""
    first, side, second, other, *maps = interface
    direction, forward = maps[:2], maps[2:]
    normal, end = (side - 1) // 2, (side - 1) % 2
    assert direction[normal] == (other - 1) // 2
    assert sorted(direction) == [0, 1]
    worst = 0
    for x in np.linspace(0, 1, 7):
        here, there = [0, 0], [0, 0]
        here[normal], here[1 - normal] = end, x
        for d in range(2):
            there[direction[d]] = here[d] if forward[d] else 1 - here[d]
        # across the side the parameter runs on: from the end of one patch to the beginning of the next
        there[direction[normal]] = (other - 1) % 2
        assert forward[normal] == (end != (other - 1) % 2)
        worst = max(worst, np.abs(patches[first].at(*here) - patches[second].at(*there)).max())
    return worst


def read_iges(path):
    with open(path, encoding="ascii") as file:
        lines = file.read().splitlines()
    assert all(len(line) == 80 for line in lines)
    sections = {letter: [line for line in lines if line[72] == letter] for letter in "SGDPT"}
    assert "".join(line[72] for line in lines) == "".join(k * len(v) for k, v in sections.items())
    for section in sections.values():
        assert [int(line[73:]) for line in section] == list(range(1, len(section) + 1))
    counts = [len(sections[k]) for k in "SGDP"]
    assert sections["T"][0].startswith("".join(f"{k}{n:7d}" for k, n in zip("SGDP", counts)))
    header = "".join(line[:72] for line in sections["G"])
    assert header.startswith("1H,,1H;,") and header.rstrip().endswith(";")
    patches, directory = [], sections["D"]
    for i in range(0, len(directory), 2):
        fields = [directory[i][8 * k:8 * k + 8] for k in range(9)]
        assert int(fields[0]) == 128 and directory[i + 1][:8] == fields[0]
        start, count = int(fields[1]) - 1, int(directory[i + 1][24:32])
        own = sections["P"][start:start + count]
        assert all(int(line[64:72]) == i + 1 for line in own)
        text = "".join(line[:64].rstrip() for line in own)
        assert text.endswith(";")
        values = [float(x.replace("D", "e")) for x in text[:-1].split(",")]
        n, m = int(values[1]) + 1, int(values[2]) + 1
        assert values[0] == 128 and values[3:10] == [3, 3, 0, 0, 1, 0, 0]
        rest = values[10:]
        s, t, weights = rest[:n + 4], rest[n + 4:n + m + 8], rest[n + m + 8:n + m + 8 + n * m]
        points = rest[n + m + 8 + n * m:-4]
        assert set(weights) == {1.0} and rest[-4:] == [s[0], s[-1], t[0], t[-1]]
        patches.append(Patch(s, t, points))
    return patches


def deviation(patches, samples):
    return max(np.abs(patches[int(f)].at(u, v) - point).max() for f, u, v, *point in samples)


with open(sys.argv[1], encoding="ascii") as points:
    diagonal, border_sides = numbers(next(points))
    samples = np.loadtxt(points)
patches, interfaces, boundary = read_gismo(sys.argv[2])
assert {int(f) for f in samples[:, 0]} == set(range(len(patches)))
worst = deviation(patches, samples) / diagonal
gap = max((interface_gap(patches, i) for i in interfaces.tolist()), default=0) / diagonal
print(f"gismo: {len(patches)} patches, {len(interfaces)} interfaces within {gap:.2g}, {len(boundary)} border sides, "
      f"points within {worst:.2g}")
assert worst < 1e-12 and gap < 1e-12
assert border_sides == len(boundary)
sides = np.concatenate([interfaces[:, :2], interfaces[:, 2:4], boundary])
assert len(np.unique(sides, axis=0)) == len(sides)

iges = read_iges(sys.argv[3])
assert len(iges) == len(patches)
worst = deviation(iges, samples) / diagonal
print(f"iges: points within {worst:.2g}")
assert worst < 1e-12
