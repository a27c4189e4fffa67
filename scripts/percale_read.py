#!/usr/bin/env python3
"""Reads the HDF5 files of Percale (result.h5, stages/*.h5) with h5py and NumPy.

As a program:
    percale_read.py result.h5                    what is in the file, and a few figures
    percale_read.py result.h5 --npz field.npz --group field
                                                 one group (default: all) as a NumPy archive
    percale_read.py result.h5 --obj quads.obj    the quads as Wavefront OBJ
    percale_read.py result.h5 --verify           is the file whole? exit status 1 if not
    percale_read.py result.h5 --seal             seal it again after you changed it with other tools

As a module:
    import percale_read
    result = percale_read.load("result.h5")      # {"quads/position": array, ...}
    for polygon in percale_read.polygons(result):
        ...                                      # arrays of vertex numbers, counter-clockwise

Every dataset has the attributes `units` ("model": those of the scan) and `description`.
docs/file-format.md explains all of them. Needs h5py and NumPy (Debian: python3-h5py).
"""
import argparse
import os
import re
import sys
import zlib

try:
    import h5py
    import numpy as np
except ImportError as missing:
    print(f"percale_read: {missing}; on Debian: apt install python3-h5py", file=sys.stderr)
    sys.exit(77)

SEAL = re.compile(rb"\npercale seal ([0-9a-f]{16}) ([0-9a-f]{8})\n")
SEAL_BYTES = 40
NONE = 0xFFFFFFFF  # "no such thing" among indices


def open_file(path):
    """The open h5py.File; ValueError where it is not one of Percale's."""
    file = h5py.File(path, "r")
    if file.attrs.get("format") != "percale":
        file.close()
        raise ValueError(f"{path}: not a file of Percale")
    if file.attrs["version"] != 1:
        version = file.attrs["version"]
        file.close()
        raise ValueError(f"{path}: format version {version}, this script reads 1")
    return file


def datasets(file, group="/"):
    """All datasets below a group, as a dictionary from full name to h5py.Dataset."""
    found = {}

    def take(name, item):
        if isinstance(item, h5py.Dataset):
            found[item.name.lstrip("/")] = item

    file[group].visititems(take)
    return found


def load(path, group="/"):
    """The arrays below a group, as a dictionary from full name to NumPy array."""
    with open_file(path) as file:
        return {name: item[...] for name, item in datasets(file, group).items()}


def polygons(arrays, group="quads"):
    """One array of vertex numbers for each polygon."""
    return np.split(arrays[f"{group}/corner"], arrays[f"{group}/start"][1:-1])


def sides(arrays, group="quads"):
    """Corners of each polygon that are not T-junctions: 4 for a quad, however its neighbours divide its sides."""
    start = arrays[f"{group}/start"].astype(np.int64)
    count = np.diff(start)
    flat = arrays.get(f"{group}/corner_flat")
    if flat is not None and len(flat):
        total = np.concatenate([[0], np.cumsum(flat, dtype=np.int64)])
        count = count - (total[start[1:]] - total[start[:-1]])
    return count


def singularities(arrays, group="field"):
    """Triangles with a singularity of the direction field, and N times their index."""
    index = arrays[f"{group}/index"]
    where = np.flatnonzero(index)
    return where, index[where]


def parameter(arrays, group="param"):
    """(s,t) of each vertex in periods. Neighbours may differ by quarter turns and whole periods."""
    return arrays[f"{group}/coordinate"] / 2.0**24


def read_checksum(path, length):
    checksum, left = 0, length
    with open(path, "rb") as file:
        while left > 0:
            block = file.read(min(left, 1 << 20))
            if not block:
                return None
            checksum, left = zlib.crc32(block, checksum), left - len(block)
    return checksum


def verify(path):
    """None where the file is as Percale wrote it, else what is wrong."""
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        file.seek(max(0, size - SEAL_BYTES))
        seal = SEAL.fullmatch(file.read())
    if not seal or int(seal[1], 16) != size - SEAL_BYTES:
        return "no seal at the end: cut off, or changed since"
    if read_checksum(path, size - SEAL_BYTES) != int(seal[2], 16):
        return "damaged: the checksum is another"
    return None


def seal_again(path):
    """Percale refuses files that were changed; this vouches for a change made on purpose."""
    with open_file(path):
        pass  # it can be read
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        file.seek(max(0, size - SEAL_BYTES))
        if SEAL.fullmatch(file.read()):
            size -= SEAL_BYTES
    os.truncate(path, size)
    with open(path, "ab") as file:
        file.write(b"\npercale seal %016x %08x\n" % (size, read_checksum(path, size)))


def write_obj(path, arrays, group="quads"):
    with open(path, "w", encoding="ascii") as file:
        for point in arrays[f"{group}/position"]:
            file.write("v %.17g %.17g %.17g\n" % tuple(point))
        for polygon in polygons(arrays, group):
            file.write("f " + " ".join(str(int(v) + 1) for v in polygon) + "\n")


def summary(path):
    with open_file(path) as file:
        for name, value in file.attrs.items():
            text = str(value)
            print(f"{name}: {text if len(text) <= 100 else text[:97] + '...'}")
        for name, item in datasets(file).items():
            shape = " x ".join(str(n) for n in item.shape)
            print(f"{name:28} {str(item.dtype):8} {shape:16} [{item.attrs.get('units', '')}] "
                  f"{item.attrs.get('description', '')}")
        names = set(datasets(file))
        arrays = {name: file[name][...] for name in names
                  if name in ("field/index", "quads/start", "quads/corner", "quads/corner_flat")}
    if "field/index" in arrays:
        index = singularities(arrays)[1]
        print(f"singularities: {np.count_nonzero(index > 0)} positive, {np.count_nonzero(index < 0)} negative")
    if "quads/start" in arrays:
        count = sides(arrays)
        share = 100 * np.mean(count == 4) if len(count) else 0.0
        print(f"polygons: {len(count)}, of them quads: {share:.1f} %")


def main():
    parser = argparse.ArgumentParser(description="Reads the HDF5 files of Percale.")
    parser.add_argument("file")
    parser.add_argument("--group", default="/", help="only what lies below this group (for --npz)")
    parser.add_argument("--npz", metavar="OUT", help="write the arrays as a NumPy archive")
    parser.add_argument("--obj", metavar="OUT", help="write the quads as Wavefront OBJ")
    parser.add_argument("--verify", action="store_true", help="check the seal")
    parser.add_argument("--seal", action="store_true", help="seal the file again after a change")
    options = parser.parse_args()
    try:
        if options.seal:
            seal_again(options.file)
        if options.verify:
            wrong = verify(options.file)
            print(f"{options.file}: {wrong or 'whole'}")
            return 1 if wrong else 0
        if options.npz:
            np.savez(options.npz, **load(options.file, options.group))
        if options.obj:
            write_obj(options.obj, load(options.file, "quads"))
        if not (options.npz or options.obj or options.seal):
            summary(options.file)
    except BrokenPipeError:
        sys.stderr.close()  # the reader of our output has seen enough
    except (OSError, ValueError, KeyError) as wrong:
        print(f"percale_read: {wrong}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
