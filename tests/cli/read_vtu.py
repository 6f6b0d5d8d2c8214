"""Reads the collections of a run with VTK's own readers. Usage: read_vtu.py DIR. Exit 77: VTK is not installed."""
import os
import sys
import xml.etree.ElementTree as ElementTree

try:
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
except ImportError:
    print("skipped: python3-vtk9 is not installed")
    sys.exit(77)

folder = sys.argv[1]
wanted = {"blocks": ("displacement_m", "stress_Pa"),
          "joints": ("opening_m", "slip_m", "damage_tension", "damage_shear", "area_m2", "normal", "block_a", "block_b")}
for what, arrays in wanted.items():
    frames = [d.get("file") for d in ElementTree.parse(os.path.join(folder, what + ".pvd")).iter("DataSet")]
    assert frames, what
    for frame in frames:
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(os.path.join(folder, frame))
        reader.Update()
        assert reader.GetErrorCode() == 0, frame
        grid = reader.GetOutput()
        assert grid.GetNumberOfCells() > 0 and grid.GetNumberOfPoints() > 0, frame
        for name in arrays:
            data = grid.GetPointData().GetArray(name) or grid.GetCellData().GetArray(name)
            assert data is not None, (frame, name)
            for component in range(data.GetNumberOfComponents()):
                low, high = data.GetRange(component)
                assert abs(low) < 1e12 and abs(high) < 1e12, (frame, name, low, high)
    print(what, len(frames), "frames,", grid.GetNumberOfPoints(), "points,", grid.GetNumberOfCells(), "cells")
