"""Reads the spline surfaces of test_skin.c with VTK's own reader.

Usage: check_surface.py WITH_DISTANCE.hdf WITHOUT.hdf ELEMENTS. Exit status 77 where VTK is not installed.
"""
import sys

try:
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkFeatureEdges
    from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
    from vtkmodules.vtkIOHDF import vtkHDFReader
except ImportError as missing:
    print(missing)
    sys.exit(77)


def read(path):
    reader = vtkHDFReader()
    assert reader.CanReadFile(path), path
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


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
points = vtk_to_numpy(with_distance.GetPoints().GetData())
normal = vtk_to_numpy(with_distance.GetPointData().GetArray("normal"))
distance = vtk_to_numpy(with_distance.GetPointData().GetArray("distance"))
assert np.allclose(np.linalg.norm(points, axis=1), distance, rtol=1e-14)
assert np.allclose(np.linalg.norm(normal, axis=1), 1)
assert (np.einsum("ij,ij->i", normal, points) > 0).all()  # outward on the sphere
element = vtk_to_numpy(with_distance.GetCellData().GetArray("element"))
face = vtk_to_numpy(with_distance.GetCellData().GetArray("face"))
assert np.array_equal(np.unique(element), np.arange(int(sys.argv[3])))
assert len(np.unique(np.stack([element, face]), axis=1).T) == len(np.unique(element))
assert without.GetPointData().GetArray("distance") is None
assert without.GetNumberOfCells() == with_distance.GetNumberOfCells()
