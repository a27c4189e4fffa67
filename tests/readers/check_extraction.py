"""Evaluates Bezier extraction from files and compares it with points of the C evaluator.

Usage: check_extraction.py POINTS FILE.iga FILE.bext. POINTS: the diagonal, then `element u v x y z` per line, u and v
in 0..1 of the element. Exit status 77 where NumPy is not installed.
"""
import sys

try:
    import numpy as np
except ImportError as missing:
    print(missing)
    sys.exit(77)


def bernstein(u):
    return np.array([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u * u * (1 - u), u**3])


def read_iga(path):
    """Nodes, and per element its nodes and a matrix: one row of Bernstein coefficients per node."""
    with open(path, encoding="ascii") as file:
        lines = iter(file.read().splitlines())
    assert next(lines) == "type surface"
    counts = [next(lines).split() for _ in range(2)]
    assert [word for word, _ in counts] == ["nodeN", "elemN"]
    node_count, element_count = (int(count) for _, count in counts)
    nodes = []
    for _ in range(node_count):
        word, *numbers = next(lines).split()
        assert word == "node" and len(numbers) == 4 and numbers[3] == "1"
        nodes.append([float(x) for x in numbers[:3]])
    elements = []
    for _ in range(element_count):
        word, count, p, q = next(lines).split()
        assert (word, p, q) == ("belem", "3", "3")
        of = np.array(next(lines).split(), dtype=int)
        rows = np.array([next(lines).split() for _ in range(int(count))], dtype=float)
        assert rows.shape == (len(of), 16)
        elements.append((of, rows))
    assert next(lines, None) is None
    return np.array(nodes), elements


def read_bext(path):
    """The same from fixed columns: integers of 8, ten in a line, reals of 24, five in a line."""
    with open(path, encoding="ascii") as file:
        lines = iter(file.read().splitlines())

    def numbers(kind, count):
        width, most = (8, 10) if kind is int else (24, 5)
        found = []
        while len(found) < count:
            line = next(lines)
            assert len(line) % width == 0 and len(line) <= width * most, line
            found += [kind(line[i:i + width]) for i in range(0, len(line), width)]
        assert len(found) == count
        return found

    assert next(lines) == "B E X T 2.0"
    patch, node_count, element_count, vector_count, weights = numbers(int, 5)
    assert (patch, weights) == (1, 0)
    nodes = np.array([numbers(float, 4) for _ in range(node_count)])
    assert (nodes[:, 3] == 1).all()
    blocks = [numbers(int, 6) for _ in range(numbers(int, 1)[0])]
    connected = []
    for kind, elements, functions, vectors, p, q in blocks:
        assert (kind, p, q) == (1, 3, 3) and functions == vectors
        for _ in range(elements):
            of = numbers(int, functions)
            assert of == sorted(set(of))
            connected.append((np.array(of) - 1, np.array(numbers(int, vectors)) - 1))
    assert len(connected) == element_count
    dense, sparse = numbers(int, 2)
    assert (dense, sparse) == (1, 0)
    count, length = numbers(int, 2)
    assert (count, length) == (vector_count, 16)
    table = np.array([numbers(float, length) for _ in range(count)])
    assert len({row.tobytes() for row in table}) == count
    assert next(lines, None) is None
    return nodes[:, :3], [(of, table[rows]) for of, rows in connected]


def deviation(nodes, elements, samples):
    worst = 0
    for element, u, v, *point in samples:
        of, rows = elements[int(element)]
        values = rows @ np.outer(bernstein(v), bernstein(u)).ravel()
        worst = max(worst, np.abs(values @ nodes[of] - point).max())
    return worst


with open(sys.argv[1], encoding="ascii") as points:
    diagonal = float(next(points))
    samples = np.loadtxt(points)
nodes, elements = read_iga(sys.argv[2])
assert {int(e) for e in samples[:, 0]} == set(range(len(elements)))
used = np.unique(np.concatenate([of for of, _ in elements]))
assert np.array_equal(used, np.arange(len(nodes)))
worst_sum = max(np.abs(rows.sum(axis=0) - 1).max() for _, rows in elements)
worst = deviation(nodes, elements, samples) / diagonal
print(f"iga: {len(nodes)} nodes, {len(elements)} elements, sums within {worst_sum:.2g}, points within {worst:.2g}")
assert worst_sum < 1e-12 and worst < 1e-12

bext_nodes, bext_elements = read_bext(sys.argv[3])
assert np.array_equal(bext_nodes, nodes)
order = sorted(range(len(elements)), key=lambda e: len(elements[e][0]))
back = [None] * len(order)
for place, e in enumerate(order):
    back[e] = bext_elements[place]
worst = deviation(bext_nodes, back, samples) / diagonal
print(f"bext: points within {worst:.2g}")
assert worst < 1e-12
