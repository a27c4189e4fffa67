"""OpenCASCADE reads STEP and IGES (through gmsh) as they were meant.

Usage: check_cad.py EXPECTED FILE.step FILE.igs. EXPECTED: faces, solids (0 where the surface is open), area and volume
of the spline. OpenCASCADE's own figures, which gmsh takes by a rule that is coarse on faces of many elements, have to
be within 1 %; Gauss's rule on the surfaces as it evaluates them within 0.001 %. Exit status 77 where gmsh's or NumPy's
Python module is not installed.
"""
import sys

try:
    import gmsh
    import numpy as np
except ImportError as missing:
    print(missing)
    sys.exit(77)


def mass(dimension):
    return sum(gmsh.model.occ.getMass(dimension, tag) for _, tag in gmsh.model.occ.getEntities(dimension))


def read(path, sew=False):
    gmsh.clear()
    gmsh.option.setNumber("Geometry.OCCSewFaces", sew)
    gmsh.option.setNumber("Geometry.OCCMakeSolids", sew)
    gmsh.model.occ.importShapes(path)
    gmsh.model.occ.synchronize()
    return len(gmsh.model.occ.getEntities(2)), len(gmsh.model.occ.getEntities(3))


def integrals():
    """Area, and volume by the divergence theorem, from OpenCASCADE's points and derivatives."""
    place, weight = np.polynomial.legendre.leggauss(5)
    area = volume = 0
    for _, tag in gmsh.model.occ.getEntities(2):
        low, high = gmsh.model.getParametrizationBounds(2, tag)
        grid = []
        for a, b in zip(low, high):
            lines = np.linspace(a, b, int(np.ceil(4 * (b - a) - 1e-6)) + 1)
            half = np.diff(lines)[:, None] / 2
            grid.append(((lines[:-1, None] + half * (1 + place)).ravel(), (half * weight).ravel()))
        u, v = np.meshgrid(grid[0][0], grid[1][0])
        w = np.outer(grid[1][1], grid[0][1]).ravel()
        uv = np.stack([u.ravel(), v.ravel()], axis=1).ravel()
        points = np.array(gmsh.model.getValue(2, tag, uv)).reshape(-1, 3)
        slopes = np.array(gmsh.model.getDerivative(2, tag, uv)).reshape(-1, 2, 3)
        normals = np.cross(slopes[:, 0], slopes[:, 1])
        area += w @ np.linalg.norm(normals, axis=1)
        volume += w @ np.einsum("ij,ij->i", points, normals) / 3
    return area, volume


def near(x, y, part=1e-2):
    return abs(x - y) <= part * abs(y)


with open(sys.argv[1], encoding="ascii") as expected:
    faces, solids, area, volume = (float(x) for x in expected.read().split())
gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 2)

assert read(sys.argv[2]) == (faces, solids), (gmsh.model.occ.getEntities(2), gmsh.model.occ.getEntities(3))
print(f"step: {faces:g} faces, {solids:g} solids, area {mass(2)} of {area}, volume {mass(3)} of {volume}")
own = integrals()
off = own[1] / volume - 1 if solids else 0
print(f"      by Gauss's rule {own[0] / area - 1:.2g} of the area, {off:.2g} of the volume off")
assert near(mass(2), area) and near(own[0], area, 1e-5)
if solids:
    assert near(mass(3), volume) and near(own[1], volume, 1e-5)
    # every edge lies between two faces: the shell is closed
    edges = [tag for d, tag in gmsh.model.getEntities(1)]
    assert all(len(gmsh.model.getAdjacencies(1, tag)[0]) == 2 for tag in edges)

assert read(sys.argv[3]) == (faces, 0)
own = integrals()
print(f"iges: {faces:g} faces, area {mass(2)} of {area}, by Gauss's rule {own[0] / area - 1:.2g} of it off")
assert near(mass(2), area) and near(own[0], area, 1e-5)
if solids:
    assert near(own[1], volume, 1e-5)
gmsh.finalize()
