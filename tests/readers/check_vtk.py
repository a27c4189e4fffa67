"""Reads the files of test_vtkhdf.c with VTK's own reader and compares them with what the test wrote.

Usage: check_vtk.py SCAN.hdf POLYGONS.hdf LAYOUT.hdf. Exit status 77 where VTK is not installed.
"""
import sys

from vtk_grid import array, points_of, read  # first: it ends the script where VTK is not installed

import numpy as np


def check_scan(path):
    grid = read(path)
    n, m = grid.GetNumberOfPoints(), grid.GetNumberOfCells()
    assert (n, m) == (200, 400), (n, m)
    points = points_of(grid)
    assert points.dtype == np.float64 and points.shape == (n, 3)
    assert np.allclose((np.hypot(points[:, 0], points[:, 1]) - 2) ** 2 + points[:, 2] ** 2, 1)  # a torus
    assert all(grid.GetCellType(i) == 5 for i in range(m))
    first = [grid.GetCell(0).GetPointId(k) for k in range(3)]
    assert len(set(first)) == 3 and max(first) < n
    point, cell, v, f = grid.GetPointData(), grid.GetCellData(), np.arange(n), np.arange(m)
    assert np.array_equal(array(point, "k1"), v + 0.25)
    assert np.array_equal(array(point, "k2"), -v - 0.5)
    assert np.array_equal(array(point, "curvature_direction"), np.arange(3 * n).reshape(n, 3) * 0.5)
    assert np.array_equal(array(point, "curvature_weight"), v / 1000)
    assert np.array_equal(array(point, "normal"), np.arange(3 * n).reshape(n, 3) * 2.0)
    assert np.array_equal(array(point, "direction"), np.arange(3 * n).reshape(n, 3) * 3.0)
    assert np.array_equal(array(point, "s"), (2 * v + 1) * 1000 / 2**24)
    assert np.array_equal(array(point, "t"), (2 * v + 2) * 1000 / 2**24)
    assert np.array_equal(array(cell, "singularity").astype(int), f % 5 - 2)
    assert np.array_equal(array(cell, "singular"), f % 4)


def check_polygons(path):
    grid = read(path)
    assert grid.GetNumberOfCells() == 3
    assert [grid.GetCellType(i) for i in range(3)] == [5, 9, 7]
    corners = [[grid.GetCell(i).GetPointId(k) for k in range(grid.GetCell(i).GetNumberOfPoints())] for i in range(3)]
    assert corners == [[0, 1, 2], [3, 2, 1, 0], [4, 3, 2, 1, 0]], corners
    assert array(grid.GetCellData(), "sides").tolist() == [3, 4, 4]
    assert array(grid.GetCellData(), "extra").tolist() == [1.5, 2.5, 3.5]


def check_layout(path):
    grid = read(path)
    m = grid.GetNumberOfCells()
    assert np.array_equal(array(grid.GetCellData(), "cell"), np.arange(m) // 2)
    assert np.array_equal(array(grid.GetCellData(), "source_face"), np.arange(m) // 3)


check_scan(sys.argv[1])
check_polygons(sys.argv[2])
check_layout(sys.argv[3])
