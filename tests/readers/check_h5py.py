"""Reads the files of test_read_script.c through scripts/percale_read.py.

Usage: check_h5py.py PLAIN.h5 COMPRESSED.h5. Exit status 77 where h5py is not installed.
"""
import os
import subprocess
import sys

script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "percale_read.py")
sys.path.insert(0, os.path.dirname(script))
import percale_read  # noqa: E402  (exits with 77 where modules are missing)
import h5py  # noqa: E402
import numpy as np  # noqa: E402


def run(*words):
    return subprocess.run([sys.executable, script, *words], capture_output=True, text=True, check=False)


def check_arrays(path):
    arrays = percale_read.load(path)
    points = arrays["mesh/position"]
    assert points.dtype == np.float64 and points.shape == (20000, 3)
    assert np.allclose((np.hypot(points[:, 0], points[:, 1]) - 2) ** 2 + points[:, 2] ** 2, 1)
    assert arrays["mesh/triangle"].dtype == np.uint32 and arrays["mesh/triangle"].max() == 19999
    assert np.array_equal(arrays["field/index"], np.arange(40000) % 41 == 7)
    assert arrays["field/index"].dtype == np.int8
    assert len(percale_read.singularities(arrays)[0]) == 976
    assert [p.tolist() for p in percale_read.polygons(arrays)] == [[0, 1, 2], [3, 2, 1, 0], [4, 3, 2, 1, 0]]
    assert percale_read.sides(arrays).tolist() == [3, 4, 4]
    with percale_read.open_file(path) as file:
        assert file["field"].attrs["symmetry"] == 4
        assert file["stages/mesh"].attrs["options"] == '{"name": "größer"}'
        assert file["stages/field"].attrs["key"] == "0123"
        assert file["mesh/position"].attrs["units"] == "model"
        for name, item in percale_read.datasets(file).items():
            assert isinstance(item.attrs["units"], str) and item.attrs["units"], name
            assert isinstance(item.attrs["description"], str) and item.attrs["description"], name
        return file["mesh/position"].chunks, file["mesh/position"].compression, file["mesh/position"].shuffle


assert check_arrays(sys.argv[1])[1] is None
chunks, compression, shuffle = check_arrays(sys.argv[2])
assert chunks is not None and compression == "gzip" and shuffle
assert os.path.getsize(sys.argv[2]) < os.path.getsize(sys.argv[1])

said = run(sys.argv[1])
assert said.returncode == 0, said.stderr
assert "singularities: 976 positive, 0 negative" in said.stdout and "polygons: 3" in said.stdout, said.stdout
assert "position of each vertex" in said.stdout

work = sys.argv[1] + ".work"
assert run(sys.argv[1], "--npz", work + ".npz", "--group", "field").returncode == 0
with np.load(work + ".npz") as kept:
    assert sorted(kept) == ["field/direction", "field/index", "field/loop_index", "field/normal"], sorted(kept)
os.remove(work + ".npz")
assert run(sys.argv[1], "--obj", work + ".obj").returncode == 0
with open(work + ".obj", encoding="ascii") as obj:
    lines = obj.read().splitlines()
assert len(lines) == 5 + 3 and lines[-1] == "f 5 4 3 2 1"
os.remove(work + ".obj")

# A change breaks the seal, and --seal mends it: the test that called us opens the file again.
assert run(sys.argv[1], "--verify").returncode == 0
with h5py.File(sys.argv[1], "r+") as file:
    file["field"].attrs["symmetry"] = np.int64(2)
assert run(sys.argv[1], "--verify").returncode == 1
assert run(sys.argv[1], "--seal").returncode == 0
assert run(sys.argv[1], "--verify").returncode == 0
assert run(script).returncode == 3
