"""OpenCASCADE reads STEP and IGES (through gmsh) as they were meant.

Usage: check_cad.py EXPECTED FILE.step FILE.igs. EXPECTED: faces, solids (0 where the surface is open), area and volume
of the spline. Exit status 77 where gmsh's Python module is not installed.
"""
import sys

try:
    import gmsh
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


def near(x, y):
    return abs(x - y) <= 1e-3 * abs(y)


with open(sys.argv[1], encoding="ascii") as expected:
    faces, solids, area, volume = (float(x) for x in expected.read().split())
gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 2)

assert read(sys.argv[2]) == (faces, solids), (gmsh.model.occ.getEntities(2), gmsh.model.occ.getEntities(3))
print(f"step: {faces:g} faces, {solids:g} solids, area {mass(2)} of {area}, volume {mass(3)} of {volume}")
assert near(mass(2), area)
if solids:
    assert near(mass(3), volume)
    # every edge lies between two faces: the shell is closed
    edges = [tag for d, tag in gmsh.model.getEntities(1)]
    assert all(len(gmsh.model.getAdjacencies(1, tag)[0]) == 2 for tag in edges)

assert read(sys.argv[3]) == (faces, 0)
print(f"iges: {faces:g} faces, area {mass(2)} of {area}")
assert near(mass(2), area)
gmsh.finalize()
