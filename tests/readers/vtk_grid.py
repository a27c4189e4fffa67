"""What the scripts that read with VTK share. Importing it ends a script with status 77 where VTK is not installed."""
import sys

try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader
except ImportError as missing:
    print(missing)
    sys.exit(77)


def read(path):
    """The grid in a VTKHDF file."""
    reader = vtkHDFReader()
    assert reader.CanReadFile(path), path
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    assert grid.GetClassName() == "vtkUnstructuredGrid", grid.GetClassName()
    return grid


def points_of(grid):
    return vtk_to_numpy(grid.GetPoints().GetData())


def array(data, name):
    found = data.GetArray(name)
    assert found is not None, name
    return vtk_to_numpy(found)
