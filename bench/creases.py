#!/usr/bin/env python3
"""Where T-splines are creased or folded: edges of the triangles of surface.hdf across which it turns by more than an angle.

    bench/creases.py OUT...        folders that `percale convert --tolerance` has written

Takes numpy and h5py.
"""
import pathlib
import sys

import h5py
import numpy as np

ANGLES = (60, 90, 150)


def turns(path):
    """Degrees across each edge between two triangles that have an area."""
    with h5py.File(path) as file:
        data = file["VTKHDF"]
        position = data["Points"][:]
        corners = data["Connectivity"] if "Connectivity" in data else data["Polygons/Connectivity"]
        triangle = corners[:].reshape(-1, 3)
    a, b, c = (position[triangle[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    normal /= np.maximum(area, 1e-300)[:, None]
    edge = np.sort(np.concatenate([triangle[:, [0, 1]], triangle[:, [1, 2]], triangle[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(triangle)), 3)
    order = np.lexsort((edge[:, 1], edge[:, 0]))
    edge, owner = edge[order], owner[order]
    shared = (edge[1:] == edge[:-1]).all(axis=1)
    left, right = owner[:-1][shared], owner[1:][shared]
    wide = 1e-9 * area.max()
    kept = (area[left] > wide) & (area[right] > wide)
    cosine = (normal[left[kept]] * normal[right[kept]]).sum(axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    print("| surface | edges | " + " | ".join(f"over {angle} degrees" for angle in ANGLES) + " |\n|---|" + "---|" * (1 + len(ANGLES)))
    for folder in sys.argv[1:]:
        angle = turns(pathlib.Path(folder, "surface.hdf"))
        counts = " | ".join(f"{int((angle > least).sum()):,}" for least in ANGLES)
        print(f"| {pathlib.Path(folder).name} | {len(angle):,} | {counts} |")


if __name__ == "__main__":
    main()
