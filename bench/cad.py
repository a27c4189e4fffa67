#!/usr/bin/env python3
"""T-splines of finished conversions as OpenCASCADE reads their STEP files, as a Markdown table.

Usage: cad.py OUT... > table.md, each OUT a folder of `percale convert --tolerance`. Needs python3-gmsh, python3-vtk9, python3-numpy
and python3-h5py. Area and volume are taken by Gauss's rule from OpenCASCADE's points and derivatives and compared with those of
the report, those of the spline itself; distances are from 3 x 3 of its points per face to the triangles of the scan (scan.hdf).
"""
import json
import os
import sys
import time

import gmsh
import h5py
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray


def triangles(path):
    with h5py.File(path) as file:
        group = file["VTKHDF"]
        polygons = group["Polygons"] if "Polygons" in group else group
        return group["Points"][:].astype(float), polygons["Connectivity"][:].reshape(-1, 3)


def locator(points, corners):
    mesh, cells, where = vtk.vtkPolyData(), vtk.vtkCellArray(), vtk.vtkPoints()
    where.SetData(numpy_to_vtk(points, deep=True))
    mesh.SetPoints(where)
    rows = np.column_stack([np.full(len(corners), 3), corners]).astype(np.int64)
    cells.SetCells(len(corners), numpy_to_vtkIdTypeArray(rows.ravel(), deep=True))
    mesh.SetPolys(cells)
    found = vtk.vtkStaticCellLocator()
    found.SetDataSet(mesh)
    found.BuildLocator()
    return found, mesh


def farthest(tree, points):
    at, cell, sub, square, most = [0.0] * 3, vtk.reference(0), vtk.reference(0), vtk.reference(0.0), 0.0
    for p in points:
        tree.FindClosestPoint(p, at, cell, sub, square)
        most = max(most, float(square))
    return most**0.5


def sides(tag, place):
    """Parameters of Gauss's points on face `tag`, and their weights."""
    low, high = gmsh.model.getParametrizationBounds(2, tag)
    grid = []
    for a, b in zip(low, high):
        lines = np.linspace(a, b, int(np.ceil(4 * (b - a) - 1e-6)) + 1)
        half = np.diff(lines)[:, None] / 2
        grid.append(((lines[:-1, None] + half * (1 + place[0])).ravel(), (half * place[1]).ravel()))
    u, v = np.meshgrid(grid[0][0], grid[1][0])
    return np.stack([u.ravel(), v.ravel()], axis=1).ravel(), np.outer(grid[1][1], grid[0][1]).ravel()


def row(folder):
    with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
        statistics = json.load(file)["statistics"]
    spline, diagonal = statistics["spline"], statistics["diagonal"]
    scan = triangles(os.path.join(folder, "scan.hdf"))
    tree, _mesh = locator(*scan)
    begin = time.time()
    gmsh.clear()
    gmsh.model.occ.importShapes(os.path.join(folder, "surface.step"))
    gmsh.model.occ.synchronize()
    faces, solids = gmsh.model.getEntities(2), gmsh.model.getEntities(3)
    shared = [len(gmsh.model.getAdjacencies(1, tag)[0]) for _, tag in gmsh.model.getEntities(1)]
    read = time.time() - begin
    gauss = np.polynomial.legendre.leggauss(3)
    area = volume = most = 0.0
    for _, tag in faces:
        uv, weight = sides(tag, gauss)
        points = np.array(gmsh.model.getValue(2, tag, uv)).reshape(-1, 3)
        slopes = np.array(gmsh.model.getDerivative(2, tag, uv)).reshape(-1, 2, 3)
        normals = np.cross(slopes[:, 0], slopes[:, 1])
        area += weight @ np.linalg.norm(normals, axis=1)
        volume += weight @ np.einsum("ij,ij->i", points, normals) / 3
        most = max(most, farthest(tree, points[:: max(1, len(points) // 9)]))
    shell, name = spline["shell"], os.path.basename(os.path.normpath(folder))
    off = f"{100 * (volume / spline['volume'] - 1):.4f}" if "volume" in spline else "open"
    cells = (name, f"{shell['faces']:,}", f"{len(faces):,}", len(solids), shell["border_edges"], shared.count(1),
             f"{100 * (area / spline['area'] - 1):.4f}", off, f"{100 * most / diagonal:.3f}", f"{100 * spline['tolerance']:.2g}",
             f"{read:.1f}")
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    print("| scan | faces written | faces read | solids | border edges | read with one face | area off, % | volume off, % | "
          "from its points to the scan, % of the diagonal | tolerance, % | seconds to read |")
    print("|---" * 11 + "|")
    for folder in sys.argv[1:]:
        row(folder)
    gmsh.finalize()


main()
