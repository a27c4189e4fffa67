"""Reads the spline surfaces of test_skin.c with VTK's own reader.

Usage: check_surface.py WITH_DISTANCE.hdf WITHOUT.hdf ELEMENTS. Exit status 77 where VTK is not installed.
"""
import sys

from vtk_grid import array, points_of, read  # first: it ends the script where VTK is not installed

import numpy as np
from vtkmodules.vtkFiltersCore import vtkFeatureEdges
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter


def border_edges(grid):
    """How many edges VTK finds with one triangle only, or with more than two."""
    surface, edges = vtkGeometryFilter(), vtkFeatureEdges()
    surface.SetInputData(grid)
    edges.SetInputConnection(surface.GetOutputPort())
    edges.FeatureEdgesOff()
    edges.ManifoldEdgesOff()
    edges.BoundaryEdgesOn()
    edges.NonManifoldEdgesOn()
    edges.Update()
    return edges.GetOutput().GetNumberOfCells()


with_distance, without = read(sys.argv[1]), read(sys.argv[2])
assert border_edges(with_distance) == 0
points = points_of(with_distance)
normal = array(with_distance.GetPointData(), "normal")
distance = array(with_distance.GetPointData(), "distance")
assert np.allclose(np.linalg.norm(points, axis=1), distance, rtol=1e-14)
assert np.allclose(np.linalg.norm(normal, axis=1), 1)
assert (np.einsum("ij,ij->i", normal, points) > 0).all()  # outward on the sphere
element = array(with_distance.GetCellData(), "element")
face = array(with_distance.GetCellData(), "face")
assert np.array_equal(np.unique(element), np.arange(int(sys.argv[3])))
assert len(np.unique(np.stack([element, face]), axis=1).T) == len(np.unique(element))
assert without.GetPointData().GetArray("distance") is None
assert without.GetNumberOfCells() == with_distance.GetNumberOfCells()
