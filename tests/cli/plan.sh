# Without -o nothing is written.
. "$here/lib.sh"
torus 24 10 >t.obj
"$PERCALE" convert t.obj
"$PERCALE" convert t.obj --quads 1k
"$PERCALE" convert t.obj --edge-length 0.5 --json
ls
