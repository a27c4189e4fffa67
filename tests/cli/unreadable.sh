# What cannot be read: exit code 3 and a place.
. "$here/lib.sh"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n' >range.obj
printf 'v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >nan.obj
printf 'ply\nformat binary_little_endian 1.0\nelement vertex 2000000000\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n' >huge.ply
: >empty.stl
torus 6 4 >torus.ply
for scan in missing.obj . range.obj nan.obj huge.ply empty.stl torus.ply; do
    try "$PERCALE" check $scan
    try convert $scan -o out
    # A second try with a better file must not find a folder in its way.
    [ -e out ] && echo "out is left behind" && rm -r out
done
torus 6 4 >t.obj
mkdir theirs
try convert nan.obj -o theirs
ls -A theirs | grep . && echo "theirs is not empty"
[ -d theirs ] || echo "theirs is gone"
try convert t.obj -o out --device nosuchdevice 2>&1 | sed 's/;.*//' | head -c 60
